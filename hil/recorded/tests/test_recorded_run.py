"""A recorded run at any time of it is as the bench was then."""

from io import StringIO
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hil.recorded.recorded_fields import NoSuchField, RunField, parse_fields
from hil.recorded.recorded_run import RecordedRun
from hil.recorded.sampled import sampled
from hil.recorded.time_words import NoSuchTime, parse_time, time_text
from hil.sim.input_log import InputLog
from hil.sim.log_reading import read_input_log
from hil.testing import Bench
from hil.vocab.time import NS_PER_MS, NS_PER_S, SimTimeNs

CONFIG = {
    "bench": "two",
    "devices": {"m1": {"profile": "mechaduino"}, "m2": {"profile": "mechaduino"}, "s1": {"profile": "sac"}},
}


def drive(bench: Bench) -> None:
    """Type at the boards, at odd times."""
    bench.start()
    for index, (name, text) in enumerate(
        (("m1", b"y"), ("m1", b"x"), ("s1", b"?\r"), ("m1", b"r\r90\r"), ("m2", b"x"))
    ):
        bench.run(37.1 + index)
        bench.port(name).write(text)
    bench.run(800)


def recorded() -> InputLog:
    with Bench(CONFIG) as bench:
        drive(bench)
        text = StringIO()
        bench.inputs.write_to(text)
    return read_input_log(text.getvalue().splitlines(keepends=True))


def states(run: RecordedRun) -> dict[str, str]:
    return {name: repr(run.runtime.snapshot(name).as_dict()) for name in run.runtime.parts.axes}


@settings(max_examples=30, deadline=None)
@given(st.lists(st.integers(3900 * NS_PER_MS, 5200 * NS_PER_MS), min_size=1, max_size=6))
def test_any_way_to_a_time_leads_to_one_state(times_ns: list[int]) -> None:
    log, last_ns = recorded(), SimTimeNs(max(times_ns))
    straight, halting = RecordedRun(log), RecordedRun(log)
    straight.run_until(last_ns)
    for at_ns in sorted(times_ns):
        halting.run_until(SimTimeNs(at_ns))
        assert {group.now_ns for group in map(halting.runtime.parts.group_of, ("m1", "m2", "s1"))} == {at_ns}
    assert states(straight) == states(halting)


def test_what_boards_send_is_heard_at_its_time() -> None:
    log = recorded()
    run, heard = RecordedRun(log), list[tuple[str, int, bytes]]()
    run.listeners.append(lambda device, port, at_ns, data: heard.append((device.name, at_ns, data)))
    run.run_until(run.end_ns)
    for name in ("m1", "m2", "s1"):
        then = [(sent.device, sent.at_ns, sent.data) for sent in log.sent if sent.device == name]
        assert then
        assert [each for each in heard if each[0] == name] == then


def test_inputs_of_a_group_that_was_late_are_taken_at_their_times() -> None:
    log = recorded()
    late = [each for each in log.inputs if each.device == "s1"]
    others = [each for each in log.inputs if each.device != "s1"]
    order = [*others, *late]  # as if s1's firmware had taken its time
    moved = InputLog(log.config, log.memories, order, log.sent, lines=[1] * len(order))
    straight, run = RecordedRun(log), RecordedRun(moved)
    for each in (straight, run):
        each.run_until(SimTimeNs(4500 * NS_PER_MS))
    assert states(straight) == states(run)


@pytest.mark.parametrize("from_ms", [0, 3900])
def test_samples_stand_at_the_multiples_of_the_interval(from_ms: int) -> None:
    log = recorded()
    run = RecordedRun(log)
    fields = parse_fields(run.runtime, ["m1.e", "m1.position_deg", "m2.velocity_rpm"])
    from_ns, to_ns = SimTimeNs(from_ms * NS_PER_MS), SimTimeNs(5000 * NS_PER_MS)
    rows: dict[str, list[tuple[float, ...]]] = {}
    for chunk in sampled(run, fields, from_ns, to_ns, NS_PER_MS):
        rows.setdefault(chunk.axis, []).extend(chunk.rows)
    assert [row[0] for row in rows["m1"]] == [*range(from_ns, to_ns + 1, NS_PER_MS)]
    assert [row[0] for row in rows["m2"]] == [row[0] for row in rows["m1"]]
    at_ns, e, position_deg = rows["m1"][4500 - from_ms]
    again = RecordedRun(log)
    again.run_until(SimTimeNs(int(at_ns)))
    snapshot = again.runtime.snapshot("m1")
    assert (snapshot.e, snapshot.position_deg) == (e, position_deg)
    assert any(one[2] != other[2] for one, other in pairwise(rows["m1"]))


def test_names_of_fields() -> None:
    run = RecordedRun(recorded())
    assert parse_fields(run.runtime, ["m1.e", "m1.e", " m2.u"]) == [
        RunField("m1", "e"),
        RunField("m2", "u"),
    ]
    assert RunField("m1", "position_deg") in parse_fields(run.runtime, ["m1.*"])
    for text, said in (
        ("m1.positon_deg", 'did you mean "position_deg"?'),
        ("m3.e", "there are m1, m2, s1"),
        ("e", "names no axis"),
        ("", "names no axis"),
        ("m1.at_ns", "no field"),
    ):
        with pytest.raises(NoSuchField, match=said.replace("?", r"\?")):
            parse_fields(run.runtime, [text])


@given(st.integers(0, 10**18))
def test_times_are_read_as_they_are_written(at_ns: int) -> None:
    assert parse_time(time_text(at_ns), SimTimeNs(at_ns)) == at_ns


def test_times_are_counted_from_faults() -> None:
    end_ns, faults = SimTimeNs(100 * NS_PER_S), {1: 10 * NS_PER_S, 3: 40 * NS_PER_S, 2: 30 * NS_PER_S}
    for text, seconds in (
        ("fault", 40),
        ("fault-1s", 39),
        ("Fault1-500ms", 9.5),
        ("fault 2 + 1:00", 90),
    ):
        assert parse_time(text, end_ns, faults) == seconds * NS_PER_S
    for text, said in (
        ("fault4-1s", "the run had no fault 4; its faults are 1, 3, 2"),
        ("fault1-11s", "not within the run"),
        ("fault-x", "'x' is no time"),
        ("faulty", "'faulty' is no time"),
    ):
        with pytest.raises(NoSuchTime, match=said):
            parse_time(text, end_ns, faults)
    with pytest.raises(NoSuchTime, match=r"the run had no fault; write a time, as 12\.5s"):
        parse_time("fault-1s", end_ns)


def test_words_for_times() -> None:
    end_ns = SimTimeNs(7200 * NS_PER_S)
    for text, seconds in (
        ("12.5s", 12.5),
        ("900ms", 0.9),
        ("1:02:03.5", 3723.5),
        ("2:03", 123),
        ("-10s", 7190),
        ("7", 7),
    ):
        assert parse_time(text, end_ns) == seconds * NS_PER_S
    for text in ("", "s", "12 parsecs", "1:2:3:4", "--3s", "7201s", "-7201s", "nan", "1e3s"):
        with pytest.raises(NoSuchTime):
            parse_time(text, end_ns)
