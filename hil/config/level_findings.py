"""Checks of the levels that wires bring to pins: 5 V at an input that takes 3.3 V."""

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from hil.config.board_numbers import HardwareVersion
from hil.config.catalogue import ProfileInfo
from hil.config.document import Finding
from hil.vocab.address import DeviceParts, address_of, pin_of

MOST_V = 3.6
"""Maximum at a pin of 3.3 V logic. Source: SAMD21 data sheet, VDD + 0.3 V."""


def level_findings(
    value: Mapping[str, Any], devices: Mapping[str, ProfileInfo], real: Collection[str]
) -> Iterator[Finding]:
    """Findings of wires that bring more to an input than its board's version takes. What is no wire between
    twins' pins is left to other checks."""
    wires = value.get("wires")
    for index, wire in enumerate(wires if isinstance(wires, list) else ()):
        given = [wire.get(end) for end in ("from", "to")] if isinstance(wire, dict) else []
        ends = [end for end in given if isinstance(end, str)]
        if len(ends) < 2:
            continue
        (source, _), (target, pin) = (pin_of(end) for end in ends)
        (giver, _), (taker, part) = address_of(source), address_of(target)
        if not {giver, taker} <= devices.keys() - set(real):
            continue
        level_V, version = _outputs_V(devices[giver], value, giver), _version(devices[taker], value, taker)
        if level_V is None or level_V <= MOST_V or version is None or not version.inputs_5V:
            continue
        if _takes_5V(devices[taker], part, pin, version):
            continue
        profile = devices[taker]
        others = [
            f'hardware: "{name}"'
            for name, other in profile.hardware.items()
            if _takes_5V(profile, part, pin, other)
        ]
        message = f"{giver} brings {level_V:g} V to {pin} of {taker}, which takes 3.3 V"
        choices = [
            "put a level converter between: a board at 3.3 V",
            *(f"or write {each}" for each in others),
        ]
        yield Finding(("wires", index, "to"), message, ", ".join(choices))


def _version(profile: ProfileInfo, value: Mapping[str, Any], device: str) -> HardwareVersion | None:
    name = value["devices"][device].get("hardware") or profile.default_hardware
    return profile.hardware.get(name) if isinstance(name, str) else None


def _outputs_V(profile: ProfileInfo, value: Mapping[str, Any], device: str) -> float | None:
    if profile.processor is not None:
        return profile.processor.supply_V
    version = _version(profile, value, device)
    return version.outputs_V if version else None


def _takes_5V(profile: ProfileInfo, part: str, pin: str, version: HardwareVersion) -> bool:
    """True if it does, by any name of the pin; or if there is no such pin."""
    axes = DeviceParts(profile.axes)
    if not axes or (part and part not in axes):
        return True
    inputs = profile.kind(part or axes.first).inputs
    same = [name for name, number in inputs.items() if number == inputs.get(pin)]
    return not same or any(name in version.inputs_5V for name in same)
