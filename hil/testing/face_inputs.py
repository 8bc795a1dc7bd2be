"""Inputs that a test gives a board of a bench in memory: checked as a replay checks them."""

from collections.abc import Mapping
from typing import Any

from hil.sim.bench import BenchRuntime
from hil.sim.client_tap import ClientTap
from hil.sim.input_check import input_problem
from hil.sim.inputs import Input, SetField
from hil.sim.settable import setting_problem
from hil.sim.twin import Twin
from hil.vocab.near_words import meant
from hil.vocab.verbs import VerbRefused


def give(runtime: BenchRuntime, to: Twin | ClientTap, given: Input, part: str = "") -> None:
    """Let an input take effect now. Raises ValueError: no board can have it."""
    target = to.axes.label(to.name, part) if isinstance(to, Twin) else to.name
    if problem := input_problem(runtime, target, given):
        raise ValueError(problem)
    runtime.apply_input(target, given)


def carry_out(
    runtime: BenchRuntime, device: Twin, part: str, verb: str, parameters: Mapping[str, float | str]
) -> dict[str, Any]:
    """Carry out a verb now; answers its result. Raises VerbRefused."""
    verb = verb.replace("-", "_")  # as in move-abs
    known = device.verbs.get(verb)
    if known is None or not (known.run or known.types):
        names = [name for name, each in device.verbs.items() if each.run or each.types]
        at = device.axes.label(device.name, part) if part else device.name
        raise VerbRefused("no_verb", f"{at} has no {verb!r}; {meant(verb, names)}")
    at_ns, answer = runtime.do_verb(device, verb, known.filled(parameters), part)
    return dict(answer) | {"effective_at_ns": at_ns}


def set_field(runtime: BenchRuntime, device: Twin, part: str, field: str, value: float) -> None:
    """Set a field of an axis from outside. ``part``: the axis's name; empty: the first. Raises ValueError: it
    cannot be set, or not to this value."""
    settable = device.axes[part].kind.settable
    if field not in settable:
        at = device.axes.label(device.name, part)
        raise ValueError(f"{at} has no field {field!r} that can be set; {meant(field, settable)}")
    if problem := setting_problem(runtime.faults, device, field, value, part):
        raise ValueError(problem)
    give(runtime, device, SetField(field, float(value)), part)
