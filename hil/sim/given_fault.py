"""Checks of a fault that somebody asks for: its kind and its parameters."""

from collections.abc import Mapping

from hil.vocab.faults import FAULT_KINDS, TIMING, Fault, FaultRefused
from hil.vocab.near_words import meant
from hil.vocab.parameters import filled


def fault_of(kind: str, target: str, given: Mapping[str, object]) -> tuple[Fault | None, dict[str, str]]:
    """Make the fault with its kind's defaults filled in, or answer the errors by the name of the parameter
    (the kind's own name under "fault")."""
    known = FAULT_KINDS.get(kind)
    if known is None:
        return None, {"fault": meant(kind, FAULT_KINDS, f"kinds are {', '.join(FAULT_KINDS)}")}
    parameters, problems = filled(kind, (*known.parameters, *TIMING), given)
    return (None, problems) if problems else (Fault(kind, target, parameters), {})


def fault_refusal(kind: str, target: str, given: Mapping[str, object]) -> Fault:
    """Make a fault as ``fault_of``.

    Raises:
        FaultRefused: with all problems.
    """
    fault, problems = fault_of(kind, target, given)
    if fault is None:
        raise FaultRefused("; ".join(f"{name}: {problem}" for name, problem in problems.items()))
    return fault
