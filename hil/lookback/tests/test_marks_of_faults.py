"""Faults as marks of a time line, each as long as it lasted; and events that no input tells of."""

from typing import Any

import pytest

from hil.lookback.run_marks import RunMarks
from hil.sim.inputs import Clear, Inject, Logged
from hil.sim.noted_events import NotedEvent
from hil.vocab.time import NS_PER_S, SimTimeNs


def injected(kind: str = "wire_cut", **timing: float) -> Logged:
    return Logged(SimTimeNs(10 * NS_PER_S), "s1", Inject(1, kind, tuple(timing.items())))


def cleared(at_s: int) -> Logged:
    return Logged(SimTimeNs(at_s * NS_PER_S), "s1", Clear(1))


def bands(*inputs: Logged, most: int = 400) -> list[tuple[float, float | None]]:
    """Begin and end of the marks, in s, at 60 s."""
    marks = RunMarks()
    for each in inputs:
        marks.add(each)

    def seconds(mark: dict[str, Any]) -> tuple[float, float | None]:
        to_ns = mark["to_ns"]
        return mark["from_ns"] / NS_PER_S, None if to_ns is None else to_ns / NS_PER_S

    return [seconds(mark) for mark in marks.told(60 * NS_PER_S, most)]


@pytest.mark.parametrize(
    ("inputs", "expected"),
    [
        ([injected()], [(10, None)]),
        ([injected(), cleared(14)], [(10, 14)]),
        ([injected(for_s=2.0)], [(10, 12)]),
        ([injected(for_s=2.0, start_s=3.0)], [(13, 15)]),
        ([injected(for_s=5.0), cleared(12)], [(10, 12)]),
        ([injected(for_s=2.0, start_s=3.0), cleared(11)], []),
        ([injected("node_reset")], [(10, 10)]),
        ([injected(for_s=1.0, every_s=20.0)], [(10, 11), (30, 31), (50, 51)]),
        ([injected(for_s=4.0, every_s=20.0), cleared(32)], [(10, 14), (30, 32)]),
        ([injected("node_reset", every_s=20.0), cleared(31)], [(10, 10), (30, 30)]),
    ],
)
def test_a_fault_is_a_band_for_as_long_as_it_lasted(
    inputs: list[Logged], expected: list[tuple[float, float | None]]
) -> None:
    assert bands(*inputs) == expected


def test_one_that_came_very_often_is_one_band() -> None:
    assert bands(injected(for_s=0.001, every_s=0.01), most=100) == [(10, None)]


def test_events_that_no_input_tells_of_are_marks_and_a_refusal_is_one() -> None:
    marks = RunMarks()
    at_ns = 10 * NS_PER_S
    marks.note([{"lane": "refusals", "at_ns": at_ns + 5, "of": "m1", "text": "m1 refused enable"}])
    marks.note([{"lane": "refusals", "at_ns": 2 * at_ns, "of": "m1", "text": "m1 refused disable"}])
    marks.happen(NotedEvent(1, "verbs", at_ns, at_ns, "m1", "ann", "enable", 1))
    marks.happen(NotedEvent(2, "refusals", at_ns, at_ns, "m1", "ann", "enable: no", 1))
    marks.happen(NotedEvent(3, "clients", at_ns, at_ns, "m1", "m1", "a client came", 1))
    marks.happen(NotedEvent(3, "clients", at_ns, at_ns + 9, "m1", "m1", "a client came", 2))
    told = [(mark["lane"], mark["to_ns"], mark["text"]) for mark in marks.told(60 * NS_PER_S)]
    assert told == [
        ("refusals", at_ns, "m1: enable: no (ann)"),
        ("refusals", 2 * at_ns, "m1 refused disable"),
        ("clients", at_ns + 9, "a client came"),
    ]
