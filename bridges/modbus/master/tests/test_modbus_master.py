"""Master of a line of Modbus RTU at a tap of a bench, in simulated time."""

import pytest

from bridges.modbus.master.modbus_master import ModbusMaster, UnitPoll
from bridges.modbus.protocol.client_side import read, write, write_single
from bridges.modbus.protocol.pdu import Table
from bridges.modbus.protocol.poll_cycle import Poll, PollCycle
from hil.master.sans_io.transaction import Outcome
from hil.testing.line_masters import attend
from hil.vocab.line_format import LineFormat
from hil.vocab.time import FOREVER, NS_PER_MS

TAP = "bus0.master"
EVEN = LineFormat("8E1", "E", 1, 11)
INPUTS, HOLDING = Table.INPUT_REGISTERS, Table.HOLDING_REGISTERS
SET_POINT = 11
LOAD, MILLI = 1024, (0x3F50, 0x624D, 0xD2F1, 0xA9FC)
"""Register of load_torque_Nm, and 0.001 as a float of 64 bits."""


@pytest.fixture
def line(bench):
    made = bench(
        {
            "bench": "plant",
            "devices": {
                "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
                "s1": {"profile": "sac"},
            },
            "segments": {
                "bus0": {
                    "modbus": {"units": {"m1": 1, "s1": 2}, "response_ms": 1.0},
                    "baud": 19200,
                    "format": "8E1",
                    "taps": {"master": {"port": "memory"}},
                }
            },
        }
    )
    made.run(ms=1500)
    return made


def master_of(*polls: UnitPoll, **given) -> ModbusMaster:
    return ModbusMaster(polls, baud=19200, line_format=EVEN, **({"response_ns": 20 * NS_PER_MS} | given))


def test_a_cycle_takes_what_was_calculated(line):
    polls = [UnitPoll(unit, read(INPUTS, 0, 2)) for unit in (1, 2)]
    master = master_of(*polls)
    attend(line, {TAP: master}, lambda: master.cycles == 5)
    calculated = PollCycle(19200, EVEN, [Poll(1, 4, 2), Poll(2, 4, 2)], 1 * NS_PER_MS)
    assert master.cycle_ns == pytest.approx(calculated.summary()["cycle_ns"], abs=2000)
    assert [len(poll.answer.values) for poll in polls] == [2, 2]
    assert [poll.missed for poll in polls] == [0, 0]


def test_cycles_begin_at_their_interval(line):
    master = master_of(UnitPoll(1, read(INPUTS, 0, 2)), interval_ns=100 * NS_PER_MS)
    attend(line, {TAP: master}, lambda: master.cycles == 4)
    assert master.cycle_ns == pytest.approx(100 * NS_PER_MS, abs=2000)


def test_a_request_waits_for_one_poll_at_most(line):
    polls = [UnitPoll(unit, read(INPUTS, 0, 2)) for unit in (1, 2)]
    master = master_of(*polls)
    attend(line, {TAP: master}, lambda: master.cycles == 1)
    asked_ns = line.now_ns
    asked = master.ask(2, read(HOLDING, 0, 1), line.now_ns)
    attend(line, {TAP: master}, lambda: asked.is_over)
    assert asked.outcome is Outcome.DONE
    assert len(asked.answer.values) == 1
    one_poll = PollCycle(19200, EVEN, [Poll(1, 4, 2)], 1 * NS_PER_MS)
    assert asked.sent_ns - asked_ns <= one_poll.summary()["cycle_ns"] + one_poll.silence_ns
    before = master.cycles
    attend(line, {TAP: master}, lambda: master.cycles > before)


def test_a_write_is_done_and_read_back(line):
    master = master_of()
    written = master.ask(1, write(HOLDING, LOAD, MILLI), line.now_ns)
    back = master.ask(1, read(HOLDING, LOAD, 4), line.now_ns)
    attend(line, {TAP: master}, lambda: master.is_idle)
    assert (written.outcome, back.answer.values) == (Outcome.DONE, MILLI)
    assert master.due_ns() == FOREVER


def test_an_exception_is_a_refusal_and_is_not_repeated(line):
    master = master_of()
    asked = master.ask(1, read(INPUTS, 60_000, 2), line.now_ns)
    attend(line, {TAP: master}, lambda: asked.is_over)
    assert (asked.outcome, asked.sent) == (Outcome.REFUSED, 1)
    assert "illegal data address" in asked.why


def test_a_write_without_an_answer_is_not_known_and_goes_out_once(line, fault):
    fault(line, "modbus_no_answer", "m1.modbus")
    master = master_of()
    written = master.ask(1, write_single(HOLDING, SET_POINT + 1, 7), line.now_ns)
    seen = master.ask(1, read(HOLDING, SET_POINT + 1, 1), line.now_ns)
    attend(line, {TAP: master}, lambda: master.is_idle)
    assert (written.outcome, written.sent) == (Outcome.NOT_KNOWN, 1)
    assert (seen.outcome, seen.sent) == (Outcome.NOT_KNOWN, 2)


def test_a_silent_unit_costs_its_time_out_and_the_others_are_polled(line):
    silent, there = UnitPoll(9, read(INPUTS, 0, 1)), UnitPoll(2, read(INPUTS, 0, 1))
    master = master_of(silent, there)
    attend(line, {TAP: master}, lambda: master.cycles == 3)
    assert (silent.answer, silent.missed, silent.why) == (None, 3, "no answer to it")
    assert there.missed == 0


def test_a_late_answer_is_not_that_of_another_request(line, fault):
    fault(line, "modbus_late", "m1.modbus", late_ms=30)
    master = master_of(response_ns=25 * NS_PER_MS)
    first = master.ask(1, read(HOLDING, SET_POINT + 1, 1), line.now_ns)
    second = master.ask(1, read(HOLDING, SET_POINT + 2, 1), line.now_ns)
    attend(line, {TAP: master}, lambda: master.is_idle)
    assert {first.outcome, second.outcome} == {Outcome.DONE}
    assert first.sent == second.sent == 1


def test_an_answer_of_another_unit_is_none(line, fault):
    fault(line, "modbus_wrong_unit", "m1.modbus", unit=2)
    master = master_of()
    asked = master.ask(1, read(HOLDING, 0, 1), line.now_ns)
    attend(line, {TAP: master}, lambda: asked.is_over)
    assert asked.outcome is Outcome.NOT_KNOWN


def test_a_broadcast_is_sent_and_all_are_given_time(line):
    master = master_of()
    sent = master.ask(0, write(HOLDING, LOAD, MILLI), line.now_ns)
    back = [master.ask(unit, read(HOLDING, LOAD, 4), line.now_ns) for unit in (1, 2)]
    attend(line, {TAP: master}, lambda: master.is_idle)
    assert sent.outcome is Outcome.SENT
    assert back[0].sent_ns - sent.sent_ns > 100 * NS_PER_MS
    assert [each.answer.values for each in back] == [MILLI, MILLI]


def test_noise_makes_no_wrong_answer(line):
    line.fault("wire_noise", "bus0", rate=0.002, seed=4)
    polls = [UnitPoll(unit, read(HOLDING, SET_POINT, 3)) for unit in (1, 2)]
    values = {poll.unit: set() for poll in polls}
    master = master_of(*polls, polled=lambda poll: poll.answer and values[poll.unit].add(poll.answer.values))
    attend(line, {TAP: master}, lambda: master.cycles == 40)
    assert values == {1: {(0, 0, 0)}, 2: {(0, 0, 0)}}
    assert all(poll.polls == 40 for poll in polls)


@pytest.mark.parametrize(
    ("unit", "request_"), [(248, read(INPUTS, 0)), (0, read(INPUTS, 0)), (1, read(INPUTS, 0, 200))]
)
def test_what_cannot_be_asked_is_refused(unit, request_):
    with pytest.raises(ValueError, match=r"unit 248|a broadcast only writes|"):
        master_of().ask(unit, request_, 0)
    with pytest.raises(ValueError, match=r"unit 248|a broadcast only writes|"):
        master_of(UnitPoll(unit, request_))


def test_a_port_that_goes_ends_all(line):
    master = master_of(UnitPoll(1, read(INPUTS, 0, 1)))
    master.advance(line.now_ns)
    asked = master.ask(1, read(INPUTS, 0, 1), line.now_ns)
    master.lose(line.now_ns, "the port has gone")
    assert asked.outcome is Outcome.NOT_SENT
    assert (master.outstanding, master.due_ns()) == ([], FOREVER)
