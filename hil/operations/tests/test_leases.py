"""Leases of a bench: who is refused, when they end, what is kept, and what ports do meanwhile."""

import json
from pathlib import Path
from typing import Any, cast

import pytest

from hil.live.places import Places
from hil.live.port_link import PortLink
from hil.operations.event_log import EventLog
from hil.operations.leases import Leases
from hil.operations.table import Asked
from hil.vocab.desk_protocol import Source
from hil.vocab.lease import LONGEST_S, time_said
from hil.vocab.ports import Port
from hil.vocab.verbs import Role, VerbRefused

NS = 1_000_000_000
ANN, BOB = Source("ann", Role.OPERATOR), Source("bob", Role.ADMIN)
LINE = Source("modbus line", Role.OPERATOR, door="modbus")


class Wall:
    now_ns = 1_800_000_000 * NS

    def __call__(self) -> int:
        return self.now_ns


class OnePort:
    """Port that takes everything."""

    def resume_reading(self) -> None: ...


class OneEnd:
    """Backend that keeps what it is fed, and what it hears of the line."""

    def __init__(self) -> None:
        self.heard: list[object] = []

    def room(self) -> int:
        return 100

    def hold(self, is_held: bool) -> None: ...
    def feed(self, data: bytes) -> None:
        self.heard.append(data)

    def refresh(self) -> None: ...
    def client_left(self, baud: int | None) -> None:
        self.heard.append(baud)

    def line_opened(self) -> None:
        self.heard.append("opened")

    def leave(self) -> None: ...


class Lab:
    """Bench with one port, its events and its lease."""

    def __init__(self, folder: Path) -> None:
        self.wall, self.end = Wall(), OneEnd()
        self.link: PortLink[OneEnd] = PortLink("m1", cast(Port, OnePort()))
        self.link.occupy(self.end)
        self.file = folder / "lease.json"
        self.start()

    def start(self) -> None:
        """Start it, again if it was there."""
        self.places, self.events = Places(), EventLog(lambda: 0)
        self.places["m1"] = self.link
        self.leases = Leases(self.file, self.places, self.events, self.wall)

    def said(self) -> list[tuple[str, str]]:
        return [(row["who"], row["text"]) for row in self.events.told(0)["events"]]

    def begin(self, source: Source = ANN, **given: Any) -> Any:
        return self.leases.begin(Asked(source, ""), **({"why": "press tests", "for_s": 60.0} | given))

    def refuses(self, source: Source, operation: str = "set", **given: Any) -> bool:
        try:
            self.leases.check(source, operation, given)
        except VerbRefused as refusal:
            return refusal.code == "leased"
        return False


@pytest.fixture
def lab(tmp_path: Path) -> Lab:
    return Lab(tmp_path)


def test_others_are_refused_in_a_sentence_with_holder_end_and_reason(lab: Lab) -> None:
    assert not lab.refuses(BOB)
    lab.begin()
    assert not lab.refuses(ANN)
    with pytest.raises(VerbRefused) as caught:
        lab.leases.check(BOB, "set", {})
    assert str(caught.value) == "ann has this bench until 2027-01-15 08:01 UTC, 1 min more: press tests"


def test_a_stop_a_check_and_what_a_run_has_to_say_are_never_refused(lab: Lab) -> None:
    lab.begin()
    for operation in ("halt", "stop", "cancel_run", "attach", "detach", "break_lease"):
        assert not lab.refuses(BOB, operation)
    assert not lab.refuses(BOB, "run", check=True)
    assert lab.refuses(BOB, "run", check=False)
    assert [
        do for do in ("look", "join", "go", "beat", "stop") if lab.refuses(BOB, "part", given={"do": do})
    ] == [
        "look",
        "join",
    ]


def test_a_door_without_names_is_closed_unless_the_lease_opens_it(lab: Lab) -> None:
    lab.begin(doors=["can"])
    assert lab.refuses(LINE)
    lab.leases.give(Asked(ANN, ""))
    answer = lab.begin(doors=["modbus", "ports"])
    assert not lab.refuses(LINE)
    assert answer["lease"]["closed"] == ["can", "web", "zenoh"]


def test_it_ends_by_itself_and_the_events_say_so(lab: Lab) -> None:
    lab.begin()
    lab.wall.now_ns += 60 * NS
    assert not lab.refuses(BOB)
    assert lab.leases.told() == {"lease": None}
    assert lab.said()[-1] == ("bench", "lease of ann ended: press tests")
    assert not lab.file.exists()


def test_it_is_renewed_from_now_by_its_holder_alone(lab: Lab) -> None:
    lab.begin()
    lab.wall.now_ns += 50 * NS
    with pytest.raises(VerbRefused, match="this is no lease of yours to renew: ann has"):
        lab.leases.renew(Asked(BOB, ""), for_s=60)
    assert lab.leases.renew(Asked(ANN, ""), for_s=30)["lease"]["left_s"] == 30
    with pytest.raises(VerbRefused, match="no lease of yours to give back"):
        lab.leases.give(Asked(BOB, ""))


def test_a_break_names_both(lab: Lab, caplog: pytest.LogCaptureFixture) -> None:
    lab.begin()
    lab.leases.end_anothers(Asked(BOB, ""))
    assert not lab.refuses(BOB)
    assert lab.said()[-1] == ("bob", "bob broke the lease of ann: press tests")
    assert "bob broke the lease of ann" in caplog.text
    with pytest.raises(VerbRefused, match="there is no lease to give back"):
        lab.leases.give(Asked(ANN, ""))
    with pytest.raises(VerbRefused, match="nobody has a lease"):
        lab.leases.end_anothers(Asked(BOB, ""))


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"for_s": None, "until_wall_ns": Wall.now_ns - NS}, "is past: this bench's clock says 2027-01-15"),
        ({"for_s": None, "until_wall_ns": Wall.now_ns + 8 * 86_400 * NS}, "a lease ends within 7 d"),
        ({"for_s": None, "until_wall_ns": 1 << 80}, "a lease ends within 7 d"),
        ({"for_s": None}, "give either for_s or until_wall_ns"),
        ({"until_wall_ns": Wall.now_ns + NS}, "give either"),
        ({"doors": ["port"]}, "doors: there is no 'port'; did you mean"),
        ({"why": "  "}, "why: this is no line of text; write in a line"),
        ({"why": "a\nWARNING b"}, "why: this is no line of text; write in a line"),
    ],
)
def test_what_is_no_lease_is_refused(lab: Lab, given: dict[str, Any], why: str) -> None:
    with pytest.raises(VerbRefused) as caught:
        lab.begin(**given)
    assert caught.value.code == "bad_parameter"
    assert why in str(caught.value)
    assert lab.leases.told() == {"lease": None}


def test_a_second_holder_and_one_without_a_name_are_refused(lab: Lab) -> None:
    with pytest.raises(VerbRefused, match="a lease needs a name, and the door modbus knows none"):
        lab.begin(LINE)
    lab.begin()
    with pytest.raises(VerbRefused, match=r"^ann has this bench until"):
        lab.begin(BOB)
    with pytest.raises(VerbRefused, match=r"you have it already: `hil lease renew`; ann has"):
        lab.begin()


def test_it_outlives_a_restart_and_one_that_ended_meanwhile_is_over(lab: Lab) -> None:
    lab.begin(doors=["can"])
    lab.start()
    assert lab.refuses(BOB)
    assert lab.link.is_shut
    lab.wall.now_ns += int(61 * NS)
    lab.start()
    assert not lab.refuses(BOB)
    assert not lab.link.is_shut
    assert lab.said() == [("bench", "lease of ann ended: press tests")]


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", '{"user": 1}', json.dumps({"user": "a", "why": "", "doors": ["x"]}), "\xff" * 9000],
)
def test_a_file_that_is_no_lease_lets_all_command(
    lab: Lab, text: str, caplog: pytest.LogCaptureFixture
) -> None:
    lab.file.write_text(text)
    lab.start()
    assert not lab.refuses(BOB)
    assert "is no lease; nobody has the bench" in caplog.text


def test_a_lease_that_cannot_be_kept_holds(lab: Lab, caplog: pytest.LogCaptureFixture) -> None:
    lab.file.mkdir()
    lab.begin()
    assert lab.refuses(BOB)
    assert "a restart of the bench forgets it" in caplog.text


def test_a_closed_port_delivers_nothing_and_counts_it(lab: Lab, caplog: pytest.LogCaptureFixture) -> None:
    lab.begin()
    lab.link.received(b"abc")
    lab.link.line_opened()
    lab.link.client_left(1200)
    lab.leases.look()
    lab.link.received(b"de")
    lab.leases.look()
    assert lab.end.heard == []
    assert lab.leases.told()["lease"]["undelivered"] == {"m1": 5}
    assert lab.said()[-1] == ("m1", "2 bytes not delivered: ann has the bench")
    assert caplog.text.count("m1: bytes of a client are not delivered") == 1
    lab.leases.give(Asked(ANN, ""))
    assert "bytes of clients that were not delivered: m1 5" in caplog.text
    lab.link.received(b"f")
    lab.link.line_opened()
    assert lab.end.heard == [b"f", "opened"]
    assert lab.link.undelivered_bytes == 0


def test_a_port_that_comes_meanwhile_is_closed_too(lab: Lab) -> None:
    lab.begin()
    lab.places["m2"] = link = PortLink("m2", cast(Port, OnePort()))
    assert link.is_shut


def test_a_lease_with_open_ports_leaves_them_alone(lab: Lab) -> None:
    lab.begin(doors=["ports"])
    lab.link.received(b"abc")
    assert lab.end.heard == [b"abc"]


@pytest.mark.parametrize(
    ("length_s", "said"),
    [(0, "0 s"), (59.6, "1 min"), (7_140, "1 h 59 min"), (LONGEST_S, "7 d"), (90_061, "1 d 1 h")],
)
def test_lengths_of_time(length_s: float, said: str) -> None:
    assert time_said(length_s) == said
