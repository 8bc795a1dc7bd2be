"""The log of a bench's events: what it has, in which words, and what it leaves out."""

import asyncio
from typing import Any

import pytest

from hil.live.run_recording import RunRecording
from hil.operations.event_log import KEPT, TEXT, EventLog, NotedDoing, Wish, halt_words
from hil.operations.recorded_events import RecordedEvents
from hil.operations.table import Asked
from hil.sim.noted_events import NotedEvent, latest_events
from hil.vocab.desk_protocol import Done, Source
from hil.vocab.verbs import Role, VerbRefused

ANN = Source("ann", Role.OPERATOR)


class Clock:
    now_ns = 0

    def __call__(self) -> int:
        return self.now_ns


def wish(operation: str = "do", name: str = "move_abs", *, streams: bool = False, **given: Any) -> Wish:
    return Wish(Asked(ANN, "m1"), operation, name, given, streams)


def told(log: EventLog) -> list[tuple[str, str, str, str]]:
    return [(row["kind"], row["of"], row["who"], row["text"]) for row in log.told(0)["events"]]


def test_a_verb_has_who_asked_for_it_and_the_time_at_which_it_took_effect() -> None:
    log = EventLog(Clock())
    log.done(wish(position_deg=90, how="grace"), Done(7, {}))
    (event,) = log.told(0)["events"]
    assert told(log) == [("verbs", "m1", "ann", "move_abs position_deg 90, how grace")]
    assert (event["at_ns"], event["count"]) == (7, 1)


def test_what_streams_is_one_event_while_it_goes_on() -> None:
    clock = Clock()
    log = EventLog(clock)
    for at_ns in range(0, 5_000_000_000, 500_000_000):
        clock.now_ns = at_ns
        log.done(wish(name="set_point", streams=True, value=at_ns), {})
    clock.now_ns = 9_000_000_000
    log.done(wish(name="set_point", streams=True, value=1), {})
    rows = log.told(0)["events"]
    assert [(row["count"], row["to_ns"]) for row in rows] == [(10, 4_500_000_000), (1, 9_000_000_000)]


def test_only_what_has_changed_is_told_again() -> None:
    log = EventLog(Clock())
    log.put("clients", "s1", "s1", "one came")
    log.put("verbs", "m1", "ann", "enable")
    before = log.told(0)["revision"]
    log.put("clients", "s1", "s1", "one came")
    assert [row["number"] for row in log.told(before)["events"]] == [1]
    assert log.told(log.told(before)["revision"])["events"] == []


def test_older_events_are_left_out_and_counted() -> None:
    log = EventLog(Clock())
    for number in range(KEPT + 5):
        log.put("verbs", "m1", "ann", f"verb {number}")
    answer = log.told(0)
    assert (len(answer["events"]), answer["left_out"]) == (KEPT, 5)


def test_a_long_text_is_cut_and_a_program_is_left_out() -> None:
    log = EventLog(Clock())
    log.refused(wish(), VerbRefused("not_now", "x" * 10_000))
    log.done(wish("load_program", "load_program", program="a" * 10_000, file="blink.hex"), {})
    refusal, load = (text for *_, text in told(log))
    assert len(refusal) == TEXT
    assert load == "load_program file blink.hex"


def test_a_run_that_is_only_checked_is_no_event() -> None:
    log = EventLog(Clock())
    log.done(wish("run", "run", check=True), {"run": "square", "steps": 2})
    assert told(log) == []


@pytest.mark.parametrize("is_refused", [False, True])
def test_a_coroutine_is_noted_when_it_ends(is_refused: bool) -> None:
    log, noted = EventLog(Clock()), wish()

    async def doing() -> Done:
        await asyncio.sleep(0)
        if is_refused:
            raise VerbRefused("not_now", "the loop is off")
        return Done(5, {})

    async def main() -> None:
        waits = NotedDoing(
            doing(),
            lambda answer: log.done(noted, answer),
            lambda why: log.refused(noted, why),
            lambda: log.not_ended(noted),
        )
        assert told(log) == []
        await asyncio.gather(asyncio.ensure_future(waits), return_exceptions=True)

    asyncio.run(main())
    assert told(log)[0][0] == ("refusals" if is_refused else "verbs")


def test_a_coroutine_that_never_began_leaves_nothing() -> None:
    log = EventLog(Clock())

    async def main() -> None:
        async def doing() -> None:
            raise AssertionError

        task = asyncio.ensure_future(NotedDoing(doing(), lambda answer: None, lambda why: None, lambda: None))
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)

    asyncio.run(main())
    assert told(log) == []


def test_a_halt_is_told_with_what_it_stopped() -> None:
    assert halt_words({"stopped": [], "runs": [], "refused": {}}) == "nothing moved"
    answer = {"stopped": ["m1"], "runs": ["square"], "refused": {"r1": "it is away"}}
    assert halt_words(answer) == "stopped m1, run square; not stopped: r1: it is away"


class RecordingInMemory(RunRecording):
    """Recording that keeps what it is told."""

    def __init__(self) -> None:
        super().__init__()
        self.records: list[NotedEvent] = []

    @property
    def writer(self) -> Any:
        return self

    def add(self, record: NotedEvent) -> None:
        self.records.append(record)


def test_a_recording_has_the_events_of_the_list_in_few_lines() -> None:
    clock, recording = Clock(), RecordingInMemory()
    log, recorded = EventLog(clock), RecordedEvents(recording)
    log.listeners.append(recorded.put)
    for number in range(1000):
        clock.now_ns = number * 10_000_000
        log.done(wish(name="set_point", streams=True, value=number), {})
    log.refused(wish(), VerbRefused("not_now", "the loop is off"))
    recorded.end()
    assert len(recording.records) < 15
    found = [event.as_dict() for event in latest_events(recording.records)]
    kept = log.told(0)["events"]
    assert found == [{name: row[name] for name in found[0]} for row in kept]

    again = EventLog(clock)
    again.begin_with(latest_events(recording.records))
    assert told(again) == told(log)
    again.put("clients", "m1", "m1", "a client came")
    assert [row["number"] for row in again.told(0)["events"]] == [1, 2, 3]
