"""A search finds what a look at each moment would see."""

from collections.abc import Callable
from io import StringIO
from typing import Any

import pytest

from hil.net.condition import ConditionError, parse_condition
from hil.recorded.recorded_run import RecordedRun
from hil.recorded.search import FoundTime, search
from hil.sim.input_log import InputLog
from hil.sim.log_reading import read_input_log
from hil.testing import Bench
from hil.vocab.time import NS_PER_MS, SimTimeNs

CONFIG = {
    "bench": "two",
    "devices": {
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "m2": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "s1": {"profile": "sac"},
        "s2": {"profile": "sac"},
    },
    "segments": {"bus0": {"stations": ["s1", "s2"], "taps": {"master": {"port": "memory"}}}},
    "can": {"can0": {"bit_rate": 500000, "nodes": {"m1": 5, "m2": 6}}},
}


def moves(bench: Bench) -> None:
    """Move the boards there and back, with a fault and traffic on the wires between, at no whole
    millisecond: a sample at the time of an input is taken before it."""
    bench.start()
    bench.run(0.3)
    for name in ("m1", "m2"):
        bench.port(name).write(b"y")
        bench.run(40)
        bench.port(name).write(b"x")
    bench.run(37.3)
    fault = bench.fault("shaft_load", "m1", torque_Nm=0.1)
    for index in range(4):
        bench.port("m1").write(b"r\r%d\r" % (90 * (index % 2)))
        bench.run(211.7)
        bench.port("m2").write(b"r\r%d\r" % (45 * (index % 2)))
        bench.run(213.1)
        bench.tap("bus0.master").write(bytes.fromhex("55aa0011"))
        bench.run(20)
    fault.clear()
    bench.run(300)


def recorded(drive: Callable[[Bench], None] = moves, config: Any = CONFIG) -> InputLog:
    with Bench(config) as bench:
        drive(bench)
        text = StringIO()
        bench.inputs.write_to(text)
    return read_input_log(text.getvalue().splitlines(keepends=True))


@pytest.fixture(scope="module")
def log() -> InputLog:
    return recorded()


def found(
    log: InputLog, text: str, from_ms: float = 0, to_ms: float | None = None, every_ms: float = 1
) -> list[FoundTime]:
    run = RecordedRun(log)
    to_ns = run.end_ns if to_ms is None else SimTimeNs(round(to_ms * NS_PER_MS))
    from_ns = SimTimeNs(round(from_ms * NS_PER_MS))
    return [*search(run, parse_condition(text), from_ns, to_ns, round(every_ms * NS_PER_MS))]


def seen(
    log: InputLog, holds: Callable[[Any, Any], bool], from_ms: int, to_ms: int
) -> list[tuple[int, int | None]]:
    """Beginnings and ends as who looks each millisecond sees them."""
    run, spans, was = RecordedRun(log), list[list[int | None]](), False
    for at_ms in range(from_ms, to_ms + 1):
        at_ns = SimTimeNs(at_ms * NS_PER_MS)
        run.run_until(at_ns)
        now = holds(run.runtime.snapshot("m1"), run.runtime.snapshot("m2"))
        if now and not was:
            spans.append([at_ns, None])
        elif was and not now:
            spans[-1][1] = at_ns
        was = now
    return [(int(begin or 0), end) for begin, end in spans]


@pytest.mark.parametrize(
    ("text", "holds"),
    [
        ("abs(m1.e) > 20", lambda m1, m2: abs(m1.e) > 20),
        (
            "m1.position_deg > 45 and m2.position_deg < 20",
            lambda m1, m2: m1.position_deg > 45 and m2.position_deg < 20,
        ),
        ("m1.position_deg - m2.position_deg > 30", lambda m1, m2: m1.position_deg - m2.position_deg > 30),
        ("not (m1.velocity_rpm < 5 or m2.u == 0)", lambda m1, m2: m1.velocity_rpm >= 5 and m2.u != 0),
        ("m1.at_ns > 0", None),
        ("m1.loop_on == 1", lambda m1, m2: m1.loop_on == 1),
    ],
)
def test_times_are_those_that_who_looks_each_millisecond_sees(
    log: InputLog, text: str, holds: Callable[[Any, Any], bool] | None
) -> None:
    if holds is None:
        with pytest.raises(ConditionError, match="m1 has no 'at_ns'"):
            found(log, text)
        return
    spans = [(each.begins_ns, each.ends_ns) for each in found(log, text, 3000, 5000)]
    assert spans == seen(log, holds, 3000, 5000)
    assert spans


def test_a_window_cuts_what_holds(log: InputLog) -> None:
    (whole,) = found(log, "m1.loop_on == 1", 3000)
    assert whole.ends_ns is None
    (part,) = found(log, "m1.loop_on == 1", 4500.25, 4600)
    assert part == FoundTime(4501 * NS_PER_MS, None, {"m1.loop_on": 1})
    assert found(log, "m1.loop_on == 1", 0, whole.begins_ns / NS_PER_MS - 1) == []


def test_values_are_those_where_it_began(log: InputLog) -> None:
    for each in found(log, "abs(m1.e) > 20 and m2.u < 1e9"):
        run = RecordedRun(log)
        run.run_until(SimTimeNs(each.begins_ns))
        assert each.values == {"m1.e": run.runtime.snapshot("m1").e, "m2.u": run.runtime.snapshot("m2").u}


def test_what_a_board_sent(log: InputLog) -> None:
    sent = [each for each in log.sent if each.device == "m1" and not each.port]
    assert [each.begins_ns for each in found(log, 'm1.sent has "90.00"')] == [
        each.at_ns for each in sent if b"90.00" in each.data
    ]
    assert len(found(log, 'not m1.sent has "90.00"')) == len(
        {each.at_ns for each in sent if b"90.00" not in each.data}
    )
    (piece, *_) = found(log, 'm1.sent has "90.00\\r"')
    assert piece.ends_ns == piece.begins_ns
    assert "90.00" in str(piece.values["m1.sent"])


def test_words_that_come_in_pieces_are_found_and_lines_are_compared() -> None:
    def type_slowly(bench: Bench) -> None:
        bench.start()
        for letter in b"r\r90\rr\r190\r":
            bench.port("m1").write(bytes((letter,)))
            bench.run(30)

    log = recorded(type_slowly, {"bench": "one", "devices": {"m1": {"profile": "mechaduino"}}})
    given = [(each.at_ns, each.input.data) for each in log.inputs if hasattr(each.input, "data")]
    nines = [at_ns for at_ns, data in given if data == b"0"]
    assert [each.begins_ns for each in found(log, 'm1.received has "90"')] == nines
    ends = [at_ns for at_ns, data in given if data == b"\r"]
    assert [each.begins_ns for each in found(log, 'm1.received == "90"')] == [ends[1]]
    assert [each.begins_ns for each in found(log, "m1.received == '190'")] == [ends[3]]
    assert len(found(log, 'm1.received != "90"')) == 3
    assert len(found(log, "m1.received has 0x390d")) == 0
    assert len(found(log, "m1.received has 0x300d")) == 2


def test_a_moment_and_a_field_hold_together(log: InputLog) -> None:
    every = found(log, 'm1.received has "r"')
    fast = found(log, 'm1.received has "r" and m1.position_deg > 45')
    assert 0 < len(fast) < len(every)
    for each in fast:
        run = RecordedRun(log)
        run.run_until(SimTimeNs(each.begins_ns))
        assert run.runtime.snapshot("m1").position_deg > 45
    either = found(log, 'm1.received has "r" or m1.position_deg > 45')
    assert {each.begins_ns for each in every} - {each.begins_ns for each in fast} <= {
        each.begins_ns for each in either
    }


def test_faults_verbs_and_other_inputs(log: InputLog) -> None:
    (begins,) = [each.at_ns for each in log.inputs if type(each.input).__name__ == "Inject"]
    (ends,) = [each.at_ns for each in log.inputs if type(each.input).__name__ == "Clear"]
    assert found(log, 'm1.fault has "load"') == [FoundTime(begins, begins, {"m1.fault": "shaft_load"})]
    assert [each.begins_ns for each in found(log, 'm1.input == "clear"')] == [ends]
    assert found(log, 'm1.fault == "load"') == []
    verbs = recorded(lambda bench: bench.device("m1").do("stop") and None)
    assert len(found(verbs, 'm1.verb == "stop"', to_ms=5)) == 1


TO_85 = bytes.fromhex("02550179036400")
"""Packet to the SACs, whose address is 85: y, which they acknowledge."""


def collide(bench: Bench) -> None:
    """Let the master send while a station answers."""
    bench.start()
    for _ in range(3):
        bench.tap("bus0.master").write(TO_85)
        bench.run(200)
    bench.fault("node_babble", "bus0.master", every_ms=50, bytes=40)
    bench.tap("bus0.master").write(TO_85)
    bench.run(400)


def test_collisions_on_a_wire() -> None:
    log = recorded(collide)
    run, events = RecordedRun(log), list[tuple[int, int]]()
    wire = run.runtime.wires["bus0"]
    wire.watchers.append(lambda event: events.append((event.at_ns, wire.counters(1)["collisions"])))
    run.run_until(run.end_ns)
    first_ns = next(at_ns for at_ns, collisions in events if collisions)
    (collided,) = found(log, "bus0.collisions > 0")
    assert collided == FoundTime(first_ns, None, {"bus0.collisions": 1})
    assert found(log, "bus0.collisions > 0", first_ns / NS_PER_MS + 100)[0].ends_ns is None
    assert found(log, "bus0.collisions < 0") == []
    assert found(log, "not bus0.collisions > 0")[0].ends_ns == first_ns
    assert found(log, 'bus0.error has "framing" or bus0.error has "collision"')


def test_packets_and_frames() -> None:
    log = recorded(collide)
    packets = found(log, "bus0.to == 85")
    assert packets
    as_text = found(log, 'bus0.to == "85"')
    assert [each.begins_ns for each in as_text] == [each.begins_ns for each in packets]
    assert as_text[0].values == {"bus0.to": "85"}
    assert found(log, "bus0.to == 85 and bus0.to == 86") == []
    frames = found(recorded(lambda bench: bench.run(500)), "can0.can_id == 0x705", to_ms=500)
    assert [each.values for each in frames] == [{"can0.can_id": 0x705}]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("m1.positon_deg > 5", """m1 has no 'positon_deg'; did you mean "position_deg"?"""),
        ("bus1.collisions > 5", """there is no 'bus1'; did you mean "bus0"?"""),
        ("e > 5", "'e' does not say of what: write it as in m1.e"),
        ("bus0.collision > 0", """did you mean "collisions"?"""),
        ("bus0.text > 0", """bus0.text is a text: write words in quotes, as in `bus0.text has "..."`"""),
        ('m1.e has "5"', "m1.e is a number: compare it with one, as in `m1.e > 5`"),
        ('can0.sent has "5"', "can0 has no 'sent'"),
        ("bus0.can_id > 5", "bus0 has no 'can_id'"),
        ("m1. > 5", "'.' means nothing here"),
    ],
)
def test_what_names_nothing(log: InputLog, text: str, said: str) -> None:
    with pytest.raises(ConditionError) as error:
        found(log, text)
    assert said in str(error.value)


def test_an_interval_that_cannot_be(log: InputLog) -> None:
    with pytest.raises(ValueError, match="write 50us or more"):
        found(log, "m1.e > 5", every_ms=0.001)
