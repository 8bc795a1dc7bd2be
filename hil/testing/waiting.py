"""Waits of tests for a condition, on any kind of bench."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from hil.net.condition import ConditionError, parse_condition

if TYPE_CHECKING:
    from hil.testing.bench_face import AnyBench

LOOK_MS = 1.0
"""Simulated time between two looks."""


WITHIN_MS = 10_000.0
"""Longest wait, by default."""


class NotInTime(AssertionError):
    """Error of something that did not come to its end in time."""


def wait_until(
    bench: "AnyBench", condition: Callable[[], object] | str, of_axis: str, within_ms: float
) -> int:
    """Let time pass until a condition holds, which is looked at each millisecond, in real time as often as
    that goes; answers the simulated time then. ``condition``: a function, or the address of an axis whose
    fields ``of_axis`` compares, as `hil wait` does: ``"m1", "position_deg > 89 and loop_on == 1"``.

    Raises:
        NotInTime: it does not hold within ``within_ms``, with the fields as they are then.
        ValueError: there are no such fields, or there is no such condition.
    """
    __tracebackhide__ = True
    if not within_ms >= 0:
        raise ValueError(f"within_ms: write a number from 0 on, not {within_ms!r}")
    if not isinstance(condition, str) and not callable(condition):
        example = 'wait_until(lambda: ...) or wait_until("m1", "position_deg > 89")'
        raise TypeError(f"{condition!r} is neither a function nor an axis; write {example}")
    holds, told = _of_axis(bench, condition, of_axis) if isinstance(condition, str) else (condition, str)
    end_ns = bench.now_ns + within_ms * 1e6
    while not holds():
        left_ms = (end_ns - bench.now_ns) / 1e6
        if left_ms <= 0:
            what = f"{condition}: {of_axis}" if of_axis else getattr(condition, "__name__", "the condition")
            raise NotInTime(f"{what} did not hold within {within_ms:g} ms{told()}")
        bench.run(min(left_ms, LOOK_MS))
    return bench.now_ns


def state_test(axis: str, text: str) -> Callable[[Mapping[str, float | None]], bool]:
    """Make a function that answers whether a condition on an axis's fields, as `hil wait` has it, holds with
    these fields. Raises ValueError: there is no such condition; or, when it is called, no such field."""
    wanted = parse_condition(text)

    def holds(state: Mapping[str, float | None]) -> bool:
        wanted.check(axis, [name for name in state if name != "at_ns"])
        return wanted.holds(state)

    return holds


def _of_axis(bench: "AnyBench", axis: str, text: str) -> tuple[Callable[[], bool], Callable[[], str]]:
    """Functions that answer whether a condition on an axis holds, and what its fields are."""
    __tracebackhide__ = True
    if not text:
        raise ValueError(f'write an axis and a condition, as in "m1", "position_deg > 89", not {axis!r}')
    face = bench.axis(axis)

    def state() -> dict[str, Any]:
        now = face.snapshot().as_dict()
        return {name: None if value != value else value for name, value in now.items()}  # nan: not told

    try:
        wanted = parse_condition(text)
        wanted.check(axis, [name for name in state() if name != "at_ns"])
    except ConditionError as error:  # raised again here: a test's report then shows the test's own line
        raise ConditionError(str(error)) from None

    def told() -> str:
        now = state()
        return ": " + ", ".join(f"{name} is {_shown(now[name])}" for name in wanted.fields)

    return lambda: wanted.holds(state()), told


def _shown(value: float | None) -> str:
    return "not told" if value is None else f"{value:g}"
