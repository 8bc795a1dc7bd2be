"""When a drive is there, and when its motion has ended: pure, by times that are given."""

from hil.drives.drive_link import FIRST_WAIT_NS, LONGEST_WAIT_NS, LOST_AFTER, DriveLink, Reading, Waits
from hil.drives.drive_motion import SETTLES_NS, SHOWS_NS, STUCK_NS, Arrival

MS = 1_000_000


def test_waits_grow_to_their_limit_and_begin_anew() -> None:
    waits = Waits()
    taken = [waits.take_ns() for _ in range(10)]
    assert taken[:3] == [FIRST_WAIT_NS, 2 * FIRST_WAIT_NS, 4 * FIRST_WAIT_NS]
    assert taken[-1] == LONGEST_WAIT_NS
    waits.reset()
    assert waits.take_ns() == FIRST_WAIT_NS


def test_a_drive_is_there_when_it_was_read_and_lost_after_some_requests() -> None:
    link = DriveLink()
    assert (link.state, link.session) == ("away", 0)
    link.place_found()
    assert (link.state, link.is_tried) == ("silent", False)
    link.unanswered("no answer")
    assert (link.state, link.why, link.is_tried) == ("silent", "no answer", True)
    link.answered(10 * MS, MS)
    link.greeted()
    assert (link.is_there, link.session, link.counters.reconnects) == (True, 1, 0)
    for _ in range(LOST_AFTER - 1):
        link.unanswered("no answer")
    assert link.is_there
    link.answered(20 * MS, MS)
    for _ in range(LOST_AFTER):
        assert link.is_there
        link.unanswered("no answer")
    assert (link.state, link.why) == ("silent", "no answer, 3 times in a row")
    link.greeted()
    assert (link.session, link.counters.reconnects) == (2, 1)
    link.place_lost("unplugged")
    assert (link.state, link.why, link.session) == ("away", "unplugged", 2)
    link.place_found()
    assert not link.is_there


def test_round_trips_and_age() -> None:
    link = DriveLink()
    assert (link.age_ns(5), link.round_trip_ns(0.5)) == (None, None)
    for trip_ns in range(1, 101):
        link.answered(1000 + trip_ns, trip_ns)
    assert (link.round_trip_ns(0.5), link.round_trip_ns(0.99), link.round_trip_ns(1.0)) == (51, 100, 100)
    assert link.age_ns(2000) == 900


def at(ms: float, position_deg: float, moving: bool | None = None) -> Reading:
    bits = {} if moving is None else {"status.moving": moving}
    return Reading(round(ms * MS), {"position_deg": position_deg}, bits)


def test_arrival_by_the_drives_own_word() -> None:
    arrival = Arrival(90.0, 0)
    assert arrival.look(at(0, 90.0, False)) == "under_way"  # asked before the command
    assert arrival.look(at(10, 0.0, False)) == "under_way"  # it does not show yet
    assert arrival.look(at(30, 5.0, True)) == "under_way"
    assert arrival.look(at(800, 89.9, True)) == "under_way"
    assert arrival.look(at(900, 89.9, False)) == "arrived"


def test_a_short_motion_may_be_over_before_a_poll_has_seen_it() -> None:
    arrival = Arrival(0.1, 0)
    assert arrival.look(at(10, 0.1, False)) == "under_way"
    assert arrival.look(at(SHOWS_NS / MS + 1, 0.1, False)) == "arrived"


def test_arrival_by_the_position_where_there_is_no_word() -> None:
    arrival = Arrival(90.0, 0)
    assert arrival.look(at(10, 0.0)) == "under_way"
    assert arrival.look(at(500, 89.0)) == "under_way"
    assert arrival.look(at(510, 89.6)) == "arrived"


def test_who_stops_short_or_stands_is_told() -> None:
    short_ms = (SHOWS_NS + SETTLES_NS) / MS
    arrival = Arrival(90.0, 0)
    assert arrival.look(at(100, 45.0, True)) == "under_way"
    assert arrival.look(at(100 + short_ms - 1, 45.0, False)) == "under_way"
    assert arrival.look(at(100 + short_ms + 1, 45.0, False)) == "short"
    stuck = Arrival(90.0, 0)
    assert stuck.look(at(100, 45.0, True)) == "under_way"
    assert stuck.look(at(100 + STUCK_NS / MS - 1, 45.0, True)) == "under_way"
    assert stuck.look(at(100 + STUCK_NS / MS + 1, 45.01, True)) == "short"
    slow = Arrival(90.0, 0)
    for second in range(1, 60):
        assert slow.look(at(second * 1000, float(second), True)) == "under_way"
