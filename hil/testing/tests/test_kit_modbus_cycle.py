"""The computed times of a poll cycle are those of the same polls on a segment, to the nanosecond."""

import pytest
from modbus_line import M1, MASTER, Line, config

from bridges.modbus.protocol import client_side as client
from bridges.modbus.protocol.frame import encode
from bridges.modbus.protocol.pdu import Table
from bridges.modbus.protocol.poll_cycle import FUNCTIONS, Poll, PollCycle
from bridges.modbus.registers import layout
from hil.sim.inputs import Play
from hil.testing import Bench
from hil.vocab.line_format import FORMATS

AT = layout.PARAMETERS_AT + 8 * layout.PER_VERB
HOLDING = Table.HOLDING_REGISTERS
POLLS = {
    Poll(1, 4, 20): client.read(Table.INPUT_REGISTERS, layout.FIELDS_AT, 20),
    Poll(2, 1, 9): client.read(Table.COILS, 0, 9),
    Poll(1, 2, 7): client.read(Table.DISCRETE_INPUTS, layout.STATUS_AT, 7),
    Poll(2, 3, 2): client.read(HOLDING, AT, 2),
    Poll(0, 6): client.write_single(HOLDING, layout.CONTROL_AT, 1),
    Poll(1, 5): client.write_single(Table.COILS, layout.INPUTS_AT, 1),
    Poll(2, 6): client.write_single(HOLDING, layout.CONTROL_AT, 1),
    Poll(1, 15, 2): client.write(Table.COILS, layout.INPUTS_AT, (0, 1)),
    Poll(1, 16, 2): client.write(HOLDING, AT, (0, 0)),
    Poll(1, 22): client.mask_write(AT, 1, 1),
    Poll(2, 23, 2): client.read_write(AT, 2, AT, (0, 0)),
}


@pytest.mark.parametrize(
    ("baud", "form", "response_ms"),
    [(19200, "8E1", 1.0), (9600, "8N1", 0.0), (115200, "8N1", 2.5), (1_000_000, "8O1", 0.2), (300, "8N2", 1)],
)
def test_a_segment_takes_the_reckoned_times(baud: int, form: str, response_ms: float) -> None:
    cycle = PollCycle(baud, FORMATS[form], [*POLLS], round(response_ms * 1e6), 5_000_000, 123)
    times = list(cycle.times())
    frames = [encode(poll.unit, of.function, client.encode(of)[1:]) for poll, of in POLLS.items()]
    units = {"units": {"m1": 1, "m2": 2}, "response_ms": response_ms}
    with Bench(config({"m1": M1, "m2": M1}, baud=baud, format=form, modbus=units)) as bench:
        line = Line(bench)
        from_ns, runtime = bench.now_ns, bench._runtime
        rows = tuple((each.start_ns, raw.hex()) for each, raw in zip(times, frames, strict=True))
        runtime.apply_to(runtime.taps[MASTER], Play(rows))
        bench.run(ms=cycle.summary()["cycle_ns"] / 1e6)
        assert line.bench.segment("bus0").counters(0)["errors"] == {}
    wire = [(each.at_ns - from_ns, each.who, len(each.raw)) for each in line.wire]
    wanted = []
    for each in times:
        poll = each.poll
        wanted.append((each.start_ns, MASTER, poll.request_bytes))
        if poll.unit:
            at_ns = each.start_ns + each.request_ns + each.wait_ns
            wanted.append((at_ns, f"m{poll.unit}.modbus", poll.answer_bytes))
    assert wire == wanted


def test_a_nanosecond_sooner_the_next_request_is_not_told_apart() -> None:
    cycle = PollCycle(19200, FORMATS["8E1"], [Poll(1, 4, 1)] * 2, 1_000_000)
    (_, second) = cycle.times()
    raw = encode(1, 4, b"\0\0\0\1").hex()
    for early_ns, errors in ((0, {}), (1, {"gap": 1})):
        with Bench(config({"m1": M1})) as bench:
            bench.run(ms=4000)
            runtime = bench._runtime
            runtime.apply_to(runtime.taps[MASTER], Play(((0, raw), (second.start_ns - early_ns, raw))))
            bench.run(ms=100)
            assert bench.segment("bus0").counters(0)["errors"] == errors


def test_what_is_no_poll() -> None:
    assert Poll(1, 99).problem == f"function 99: write one of {', '.join(map(str, FUNCTIONS))}"
    assert Poll(248, 4).problem == "unit 248: write 1 to 247, or 0 for a broadcast"
    assert Poll(1, 4, 126).problem == "count 126: function 4 takes 1 to 125"
    assert Poll(1, 6, 2).problem == "count 2: function 6 takes 1 to 1"
    assert Poll(0, 3).problem == "function 3 to all: a broadcast only writes"
    assert Poll(1, 23, 121).problem is None
    assert Poll(0, 22).problem is None
