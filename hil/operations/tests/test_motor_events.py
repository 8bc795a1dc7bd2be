"""Events of motors: each stall once, at its time, after a power-up and in a fork too."""

from dataclasses import replace

from hil.operations.event_log import EventLog
from hil.operations.motor_events import MotorEvents
from hil.sim.noted_events import NotedEvent, noted_event
from hil.testing import Bench

TOO_FAST = b"m9000v2400a1\r"
"""Move that the default motor of a SAC does not follow."""


def stalled_bench() -> Bench:
    bench = Bench({"bench": "stalls", "devices": {"s1": {"profile": "sac"}}})
    bench.run(ms=1500)
    return bench


def stall(bench: Bench) -> int:
    bench.port("s1").write(TOO_FAST)
    bench.run(ms=4000)
    return int(bench.axis("s1").snapshot().stalled_at_ns)


def look(bench: Bench, motors: MotorEvents) -> None:
    native, group = bench.runtime.core.native, bench.runtime.parts.group_of("s1")
    native.release(group.id)  # as real time does, which publishes what it is
    native.acquire(group.id)
    for _ in motors.look():
        pass


def noted(events: EventLog) -> list[NotedEvent]:
    return [noted_event(event) for event in events.told(0)["events"]]


def test_a_stall_is_told_once_and_one_after_a_power_up_is_another() -> None:
    with stalled_bench() as bench:
        events = EventLog(lambda: bench.now_ns)
        motors = MotorEvents(events, bench.runtime)
        first_ns = stall(bench)
        look(bench, motors)
        bench.device("s1").reset()
        bench.run(ms=1500)
        second_ns = stall(bench)
        for _ in range(2):
            look(bench, motors)
        assert [event.at_ns for event in noted(events)] == [first_ns, second_ns]


def test_a_bench_that_goes_on_from_a_recorded_run_has_its_stalls_already() -> None:
    with stalled_bench() as bench:
        at_ns = stall(bench)
        events = EventLog(lambda: bench.now_ns)
        look(bench, MotorEvents(events, bench.runtime))
        (event,) = noted(events)
        assert event.at_ns == at_ns

        future = EventLog(lambda: bench.now_ns)
        future.begin_with([replace(event, number=7)])
        look(bench, MotorEvents(future, bench.runtime))
        assert [each.number for each in noted(future)] == [7]


def test_others_have_their_turn_between_many_motors() -> None:
    names = [f"m{number}" for number in range(40)]
    config = {"bench": "many", "devices": {name: {"profile": "mechaduino"} for name in names}}
    with Bench(config) as bench:
        assert len(list(MotorEvents(EventLog(lambda: 0), bench.runtime).look())) == 2
