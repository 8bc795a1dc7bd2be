"""Master at a tap of a bench, in simulated time: scan, table, text, release, soft_ops, several lines."""

import pytest

from device_profiles.sac.line_nodes import NODES
from device_profiles.sac.packet import encode
from hil.master.sans_io.node_master import NodeMaster
from hil.master.sans_io.transaction import Outcome
from hil.testing.line_masters import NotInTime, attend
from hil.vocab.time import FOREVER, NS_PER_MS
from hil.wire.serial_line import character_ns

TAP = "bus0.master"


def settle(bench, master):
    attend(bench, {TAP: master}, lambda: master.is_idle)


def test_a_round_trip_is_the_packets_the_turnaround_and_nothing_else(segment):
    b, master = segment(1), NodeMaster(NODES)
    sent = master.send(4, b"m100", b.now_ns)
    settle(b, master)
    assert sent.outcome is Outcome.DONE
    assert sent.round_trip_ns == pytest.approx(character_ns(10 + 2 + 7, 38400), abs=1000)
    assert master.table[4].round_trip_ns == sent.round_trip_ns


@pytest.mark.parametrize("baud", [9600, 38400])
def test_a_scan_of_all_addresses_takes_what_was_calculated(segment, baud):
    b, master = segment(7, first=20, baud=baud), NodeMaster(NODES, baud=baud)
    begun_ns = b.now_ns
    asked = master.scan(None, b.now_ns)
    settle(b, master)
    there = [each.unit for each in asked if each.outcome is Outcome.DONE]
    assert (len(asked), there) == (252, list(range(20, 27)))
    assert (b.now_ns - begun_ns) / master.scan_ns(252, 7) == pytest.approx(1, abs=0.001)


def test_a_scan_finds_who_refuses_and_who_sends_no_crc(segment, fault):
    b, master = segment(3), NodeMaster(NODES)
    fault(b, "packet_nak", "s4.network")
    b.port("s5").write(b"$H0\r")
    b.run(ms=20)
    master.scan([4, 5, 6, 7], b.now_ns)
    settle(b, master)
    assert [address for address, row in master.table.items() if row.is_there] == [4, 5, 6]


def test_a_text_is_shown_once(segment):
    b, master = segment(2), NodeMaster(NODES)
    master.text(5, "hello", b.now_ns)
    settle(b, master)
    b.run(ms=20)
    assert b.port("s5").read() == b"\r\nhello\r\nSAC>"
    assert b.port("s4").read() == b""


def test_a_text_of_a_node_is_an_event(segment):
    b, master = segment(2), NodeMaster(NODES)
    b.port("s5").write(b"1 good morning\r")
    attend(b, {TAP: master}, lambda: 5 in master.table)
    assert [event[1:] for event in master.take_events()] == [(5, "text", "good morning")]
    assert master.table[5].text == "good morning"


def test_a_release_waits_for_what_is_before_it_and_starts_all_at_once(segment):
    b, master = segment(3), NodeMaster(NODES)
    held = [master.send(node, b"m50v300s", b.now_ns) for node in (4, 5, 6)]
    release = master.release(b.now_ns)
    behind = master.send(4, b"v200", b.now_ns)
    settle(b, master)
    assert release.outcome is Outcome.SENT
    assert release.sent_ns >= max(each.ended_ns for each in held)
    assert behind.sent_ns >= release.ended_ns
    b.run(ms=2000)
    assert [b.axis(f"s{node}").snapshot().commanded_deg for node in (4, 5, 6)] == [90.0] * 3


def test_a_release_waits_for_a_late_answer(segment, fault):
    b, master = segment(2), NodeMaster(NODES)
    fault(b, "packet_no_ack", "s4.network")
    held = master.send(4, b"m50s", b.now_ns)
    release = master.release(b.now_ns)
    settle(b, master)
    assert release.sent_ns >= held.ended_ns >= held.sent_ns + NODES.busy_ns


def test_soft_ops_tell_state_and_times_of_commands(segment):
    b, master = segment(2), NodeMaster(NODES)
    master.send(4, b"$O1", b.now_ns)
    master.send(4, b"m100v300a999d999", b.now_ns)
    settle(b, master)
    attend(b, {TAP: master}, lambda: master.table[4].begun == 1)
    assert master.table[4].state == "moving"
    assert master.table[5].state == "not known" if 5 in master.table else True
    attend(b, {TAP: master}, lambda: master.table[4].ended == 1)
    row = master.table[4]
    assert row.state == "standing"
    kinds = [(event.node, event.kind) for event in master.take_events()]
    assert kinds == [(4, "DC1"), (4, "DC2")]
    assert row.command_ns == pytest.approx(100 * NS_PER_MS, abs=3 * NS_PER_MS)


def test_begin_that_a_node_tells_does_not_spoil_the_command_for_another(segment):
    b, master = segment(4), NodeMaster(NODES)
    master.send(NODES.to_all, b"$O1", b.now_ns)
    sent = [master.send(node, b"m200v300a999d999", b.now_ns) for node in (4, 5, 6, 7)]
    settle(b, master)
    b.run(ms=50)
    assert [(each.outcome, each.sent) for each in sent] == [(Outcome.DONE, 1)] * 4
    assert sum(each.begun for each in master.table.values()) >= 3
    assert b.segment("bus0").counters(b.now_ns)["collisions"] == 0


def test_a_stop_goes_before_all_and_drops_what_waits(segment):
    b, master = segment(3), NodeMaster(NODES)
    master.send(4, b"m9000v60", b.now_ns)
    settle(b, master)
    waiting = [master.send(5, b"m100", b.now_ns) for _ in range(5)]
    stops = master.stop([4, 5], b.now_ns, is_at_once=True)
    settle(b, master)
    assert [each.outcome for each in stops] == [Outcome.SENT, Outcome.DONE, Outcome.DONE]
    assert [each.outcome for each in waiting[1:]] == [Outcome.NOT_SENT] * 4
    where_deg = b.axis("s4").snapshot().commanded_deg
    b.run(ms=500)
    assert b.axis("s4").snapshot().commanded_deg == where_deg < 90


def test_a_port_that_goes_leaves_nothing_without_outcome(segment):
    b, master = segment(2), NodeMaster(NODES)
    sent = [master.send(node, b"m10", b.now_ns) for node in (4, 5, 4)]
    master.lose(b.now_ns, "bus0.master has gone")
    assert [each.outcome for each in sent] == [Outcome.NOT_KNOWN, Outcome.NOT_SENT, Outcome.NOT_SENT]
    assert sent[0].why == "bus0.master has gone, before its answer came"
    assert master.send(4, b"m10", b.now_ns).outcome is Outcome.NOT_SENT
    assert master.due_ns() == FOREVER


def test_who_calls_back_when_one_ends_may_send_at_once(segment):
    b, master = segment(2), NodeMaster(NODES)
    then = []
    master.send(4, b"v100", b.now_ns, ended=lambda it: then.append(master.send(5, b"v90", it.ended_ns)))
    attend(b, {TAP: master}, lambda: bool(then) and master.is_idle)
    assert then[0].outcome is Outcome.DONE


def test_a_line_that_is_never_quiet_is_used_all_the_same(segment, fault):
    b, master = segment(2), NodeMaster(NODES)
    fault(b, "node_babble", "s5.network", bytes=40, every_ms=5)
    sent = master.send(4, b"v77", b.now_ns)
    settle(b, master)
    assert sent.sent == 3
    assert sent.is_over


def test_two_lines_at_once(bench):
    names = [f"s{n}" for n in (1, 2)]
    wires = {f"bus{n}": {"stations": [f"s{n}"], "taps": {"master": {"port": "memory"}}} for n in (1, 2)}
    b = bench({"bench": "t", "devices": {name: {"profile": "sac"} for name in names}, "segments": wires})
    b.run(ms=1100)
    masters = {f"bus{n}.master": NodeMaster(NODES) for n in (1, 2)}
    sent = [master.send(85, b"m10", b.now_ns) for master in masters.values()]
    attend(b, masters, lambda: all(each.is_idle for each in masters.values()))
    assert [each.outcome for each in sent] == [Outcome.DONE] * 2
    assert abs(sent[0].sent_ns - sent[1].sent_ns) < NS_PER_MS


def test_a_master_that_does_not_come_to_its_end_is_told(segment):
    b, master = segment(1), NodeMaster(NODES)
    with pytest.raises(NotInTime, match="after 100 ms"):
        attend(b, {TAP: master}, lambda: False, within_ms=100)


@pytest.mark.parametrize(("address", "command"), [(2, b"m1"), (256, b"m1"), (4, b""), (4, b"a\2b")])
def test_what_cannot_be_sent_is_refused_and_nothing_waits(address, command):
    master = NodeMaster(NODES)
    with pytest.raises(ValueError, match=r"address|empty|STX"):
        master.send(address, command, 0)
    assert master.is_idle
    assert master.table == {}


def test_answers_that_a_line_cannot_carry_do_not_count_and_the_reason_says_so():
    for has_bit_times, outcome in ((True, Outcome.NOT_KNOWN), (False, Outcome.DONE)):
        master = NodeMaster(NODES, has_bit_times=has_bit_times)
        sent = master.send(4, b"m100", 0)
        master.receive(encode(1, 4, b"\x06"), 100_000)
        while not master.is_idle:
            master.advance(master.due_ns())
        assert sent.outcome is outcome
        assert ("earlier than 38400 baud can carry it" in sent.why) == has_bit_times


def test_a_master_that_is_due_for_ever_is_told(segment):
    class Hanging(NodeMaster):
        def due_ns(self) -> int:
            return 0

    with pytest.raises(NotInTime, match="again and again"):
        attend(segment(1), {TAP: Hanging(NODES)}, lambda: False)
