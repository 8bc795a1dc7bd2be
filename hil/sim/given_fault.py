"""Checks of a fault that somebody asks for: its kind and its parameters."""

from collections.abc import Mapping

from hil.vocab.faults import FAULT_KINDS, TIMING, Fault, FaultKind, FaultRefused
from hil.vocab.near_words import meant
from hil.vocab.parameters import filled

SHORTEST_S = 0.001
"""Shortest time from one beginning of a fault to the next."""
_SHOWN = 40
"""Number of characters of a name that are shown."""


def fault_of(kind: str, target: str, given: Mapping[str, object]) -> tuple[Fault | None, dict[str, str]]:
    """Make the fault with its kind's defaults filled in, or answer the errors by the name of the parameter
    (the kind's own name under "fault")."""
    known = FAULT_KINDS.get(kind)
    if known is None:
        return None, {"fault": _no_kind(kind)}
    parameters, problems = filled(kind, (*known.parameters, *TIMING), given)
    if not problems and (problem := _repeat_problem(known, parameters)):
        problems = {"every_s": problem}
    return (None, problems) if problems else (Fault(kind, target, parameters), {})


def _repeat_problem(kind: FaultKind, parameters: Mapping[str, float | str]) -> str | None:
    """Error text for a fault that comes again, or None."""
    every_s, for_s = float(parameters["every_s"]), float(parameters["for_s"])
    if not every_s:
        return None
    if every_s < SHORTEST_S:
        return f"write 0, or at least {SHORTEST_S:g} s"
    if kind.is_once:
        return "it is over at once: leave for_s out" if for_s else None
    if not for_s:
        return "say for how long each time: for_s"
    return None if for_s < every_s else f"it lasts {for_s:g} s: write more than that"


def fault_refusal(kind: str, target: str, given: Mapping[str, object]) -> Fault:
    """Make a fault as ``fault_of``.

    Raises:
        FaultRefused: with all problems.
    """
    fault, problems = fault_of(kind, target, given)
    if fault is None:
        raise FaultRefused(fault_problems(problems))
    return fault


def fault_problems(problems: Mapping[str, str]) -> str:
    """Text of the errors of ``fault_of``."""
    return "; ".join(
        problem if name == "fault" else f"{name[:_SHOWN]}: {problem}" for name, problem in problems.items()
    )


def _no_kind(kind: str) -> str:
    known = meant(kind, FAULT_KINDS, f"kinds are {', '.join(FAULT_KINDS)}")
    return f"there is no fault {kind[:_SHOWN]!r}; {known}"
