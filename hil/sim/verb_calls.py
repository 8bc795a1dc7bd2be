"""Calls of a board's verbs: of the whole board, or of one of its axes."""

from collections.abc import Callable, Collection, Mapping
from functools import partial
from typing import Any

from hil.core import CoreAxis
from hil.sim.hardware import DeviceSpec, Hardware
from hil.sim.setpoints import Setpoints
from hil.sim.sketch import Sketch
from hil.vocab.address import DeviceParts, no_part
from hil.vocab.path import Path
from hil.vocab.time import SimTimeNs
from hil.vocab.verbs import Effect, Verb, VerbRefused

_REFUSED = (VerbRefused,)
Answer = Mapping[str, float | str | int]
"""Answer of a verb, by names."""


def verb_problem(device: str, axes: DeviceParts[CoreAxis], verb: Verb, part: str) -> str | None:
    """Reason why a device's verb is not one of its part of this name, or None; empty: of the device."""
    is_of_axis = verb.is_of_axis or verb.name == "pin"
    if part not in axes and (part or is_of_axis):
        return no_part(device, "axis", part, axes)
    if part and not is_of_axis and len(axes) > 1:
        return f"{verb.name} is of the whole board: ask {device} for it"
    return None


def axes_of(axes: DeviceParts[CoreAxis], verb: Verb, part: str) -> Collection[str]:
    """Names of the axes whose motions a verb is about."""
    return [part or axes.first] if part or verb.is_of_axis else axes


def axis_arguments(axes: DeviceParts[CoreAxis]) -> dict[str, dict[str, str]]:
    """Arguments that tell a function of the profile which axis is meant, by the axis's name: a board with
    several axes is told, ``axis=``."""
    return {name: {"axis": name} if len(axes) > 1 else {} for name in axes}


def _checked(verb: Verb, answer: object) -> Answer | None:
    """Answer of a verb. Raises TypeError: it is none that can be handed on."""
    if answer is None or isinstance(answer, Mapping):
        return answer
    raise TypeError(f"verb {verb.name}: it answers {type(answer).__name__}, and no mapping of names, or None")


class VerbCalls:
    """Calls of one device's verbs."""

    def __init__(self, spec: DeviceSpec, hardware: Hardware, sketch: Sketch, setpoints: Setpoints) -> None:
        self._device, self._profile = spec.name, spec.profile
        self._hardware, self._sketch, self._setpoints = hardware, sketch, setpoints
        self._named = axis_arguments(hardware.axes)
        self._follow = spec.follow

    @property
    def follows_paths(self) -> bool:
        return self._follow is not None

    def follow(self, path: Path, start_ns: int, now_ns: SimTimeNs, part: str) -> None:
        """Let an axis follow a path; shorter than a verb, as drives do it at each SYNC.

        Raises:
            VerbRefused: the board follows none, or the firmware refuses it.
        """
        follow, axis = self._follow, part or self._hardware.axes.first
        if follow is None:
            raise VerbRefused("cannot", f"a {self._profile} follows no paths")
        if (named := self._named.get(axis)) is None:
            raise VerbRefused("no_verb", no_part(self._device, "axis", part, self._hardware.axes))
        sketch = self._sketch
        sketch.turn(lambda: follow(sketch.firmware, path=path, start_ns=start_ns, **named), passes=_REFUSED)
        self._setpoints.note(axis, Effect.ENDS, now_ns, self._hardware.note)

    def carry_out(self, verb: Verb, parameters: Mapping[str, Any], now_ns: SimTimeNs, part: str) -> Answer:
        """Carry out a verb of the device or one of its axes; answers what it answers.

        Raises:
            VerbRefused: the part has no such verb, or the firmware refuses it.
        """
        axes = self._hardware.axes
        if why := verb_problem(self._device, axes, verb, part):
            raise VerbRefused("no_verb", why)
        work = self._call(verb, part or axes.first, parameters)
        answer = self._sketch.turn(work, passes=_REFUSED)
        if verb.types:
            self._hardware.interfaces.by_name[""].arrive(verb.types, None)
        for axis in axes_of(axes, verb, part):
            self._setpoints.note(axis, verb.effect, now_ns, self._hardware.note)
        return answer or {}

    def _call(self, verb: Verb, axis: str, parameters: Mapping[str, Any]) -> Callable[[], Answer | None]:
        if verb.name == "pin":
            pin, level = str(parameters["pin"]), int(parameters["level"])
            return partial(self._hardware.axes[axis].pin, pin, level)
        if verb.run is None:
            return lambda: None
        named = self._named[axis] if verb.is_of_axis else {}
        return lambda: _checked(verb, verb.run(self._sketch.firmware, **parameters, **named))  # type: ignore[misc]
