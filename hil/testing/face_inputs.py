"""Inputs that a test gives a board of a bench in memory: checked as a replay checks them."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from hil.core import CoreAxis
from hil.sim.bench import BenchRuntime
from hil.sim.client_tap import ClientTap
from hil.sim.input_check import input_problem
from hil.sim.inputs import Input, SetField
from hil.sim.settable import setting_problem
from hil.sim.twin import Twin
from hil.vocab.near_words import meant
from hil.vocab.verbs import VerbRefused

OF_PYSERIAL = {"readline", "readlines", "read_until", "flush", "in_waiting", "reset_input_buffer", "timeout"}
"""Names of pyserial's ports that are looked for at the kit's."""
_STARTS = re.compile(r"\b(?:starts|starting)\b")
"""Words of boards that have not started yet."""


def give(runtime: BenchRuntime, to: Twin | ClientTap, given: Input, part: str = "") -> None:
    """Let an input take effect now. Raises ValueError: no board can have it."""
    target = to.axes.label(to.name, part) if isinstance(to, Twin) else to.name
    if problem := input_problem(runtime, target, given):
        raise ValueError(problem)
    runtime.apply_input(target, given)


def carry_out(
    runtime: BenchRuntime,
    device: Twin,
    part: str,
    verb: str,
    parameters: Mapping[str, float | str],
    unnamed: Sequence[object] = (),
) -> dict[str, Any]:
    """Carry out a verb now; answers its result. ``unnamed``: parameters that were given without their names.

    Raises:
        VerbRefused: it was not carried out.
        TypeError: parameters have no names.
    """
    __tracebackhide__ = True
    verb = verb.replace("-", "_")  # as in move-abs
    known = device.verbs.get(verb)
    if known is None or not (known.run or known.types):
        names = [name for name, each in device.verbs.items() if each.run or each.types]
        at = device.axes.label(device.name, part) if part else device.name
        raise VerbRefused("no_verb", f"{at} has no {verb!r}; {meant(verb, names)}")
    if unnamed:
        names = [each.name for each in known.parameters[: len(unnamed)]] or ["name"]
        written = ", ".join(f"{name}={value!r}" for name, value in zip(names, unnamed, strict=False))
        raise TypeError(f"do({verb!r}, ...): parameters have names; write do({verb!r}, {written})")
    try:
        at_ns, answer = runtime.do_verb(device, verb, known.filled(parameters), part)
    except VerbRefused as refusal:
        at = device.axes.label(device.name, part) if part else device.name
        also = "; b.start() lets it start" if _STARTS.search(str(refusal)) else ""
        raise VerbRefused(refusal.code, f"{at}: {refusal}{also}") from None
    return dict(answer) | {"effective_at_ns": at_ns}


def instead_of_field(at: str, axis: CoreAxis, name: str) -> str:
    """Remedy where a field of an axis is taken for an attribute; empty: it has no such field."""
    read = f'read b.axis("{at}").snapshot().{name}' if name in axis.kind.fields else ""
    write = f'set it by b.axis("{at}").set("{name}", ...)' if name in axis.kind.settable else ""
    return ", or ".join(filter(None, (read, write)))


def instead_of_pyserial(at: str, name: str) -> str:
    """Remedy where a name of pyserial's ports is looked for at the kit's; empty: it is none."""
    return f'b.serial("{at}", timeout=1) is pyserial\'s port' if name in OF_PYSERIAL else ""


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
