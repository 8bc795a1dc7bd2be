"""A recorded bench is told as it was at a time, and what happened in a window as a list."""

from io import StringIO

from hil.recorded.bench_then import bench_then
from hil.recorded.recorded_run import RecordedRun
from hil.recorded.run_events import events
from hil.sim.input_log import InputLog
from hil.sim.log_reading import read_input_log
from hil.testing import Bench
from hil.vocab.time import NS_PER_MS, SimTimeNs

CONFIG = {
    "bench": "two",
    "devices": {
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "s1": {"profile": "sac"},
    },
}


def ms(value: float) -> SimTimeNs:
    return SimTimeNs(round(value * NS_PER_MS))


def recorded() -> tuple[InputLog, dict[str, float]]:
    """Log of a run that has a fault and ends with a move, and the state of m1 at 5000 ms."""
    with Bench(CONFIG) as bench:
        bench.start()
        for at_ms, text in ((4100, b"x"), (4200, b"y"), (4300, b"r\r90\r")):
            bench.run(at_ms - bench.now_ns / NS_PER_MS)
            bench.port("m1").write(text)
        bench.run(100)
        bench.fault("byte_drop", "s1", rate=0.5)
        bench.run(5000 - bench.now_ns / NS_PER_MS)
        state = bench.axis("m1").snapshot().as_dict()
        bench.run(500)
        text_file = StringIO()
        bench.inputs.write_to(text_file)
    return read_input_log(text_file.getvalue().splitlines(keepends=True)), state


def test_state_words_and_faults_are_those_of_the_time() -> None:
    log, state = recorded()
    then = bench_then(RecordedRun(log), ms(5000))
    assert then.axes["m1"] == state
    assert then.axes["m1"]["position_deg"] > 80
    assert [(row["number"], row["kind"], row["target"]) for row in then.faults] == [(1, "byte_drop", "s1")]
    assert b"90" in then.words["m1"]
    before = bench_then(RecordedRun(log), ms(4000))
    assert not before.faults
    assert b"90" not in before.words["m1"]


def test_events_of_a_window_stand_in_the_order_of_their_times() -> None:
    log, _ = recorded()
    inputs = [each.at_ns for each in log.inputs]
    found = [*events(RecordedRun(log), ms(4100), ms(5000))]
    assert [event.at_ns for event in found] == sorted(event.at_ns for event in found)
    assert [event.at_ns for event in found if event.what != "sent"] == inputs
    lines = [event.line() for event in found]
    assert any(line.startswith("4.1s               m1") and line.endswith("<- 'x'") for line in lines)
    assert any("s1" in line and "<- fault 1: byte_drop rate=0.5" in line for line in lines)
    sent = b"".join(bytes.fromhex(event.values["data"]) for event in found if event.what == "sent")
    assert b"90" in sent
    assert not [*events(RecordedRun(log), ms(4110), ms(4190))]
