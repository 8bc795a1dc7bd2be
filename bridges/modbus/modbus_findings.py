"""Checks of Modbus nodes on segments: whose they are, and their numbers."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from typing import Any

from bridges.modbus.modbus_model import MODBUS
from hil.config.catalogue import ProfileInfo
from hil.config.document import Finding, KeyPath
from hil.config.explain import suggestion
from hil.config.joint_findings import no_twin_finding
from hil.vocab.address import DeviceParts, address_of, no_part


def modbus_findings(
    segments: Mapping[str, Any], devices: Mapping[str, ProfileInfo], real: Collection[str]
) -> Iterator[Finding]:
    """Findings about nodes. ``devices``: those whose profile is known; ``real``: real boards."""
    taken: dict[str, str] = {}
    for name, segment in segments.items():
        modbus = segment.get(MODBUS) if isinstance(segment, dict) else None
        if not isinstance(modbus, dict):
            continue
        units, may_repeat = modbus.get("units"), modbus.get("duplicate_units") is True
        units = units if isinstance(units, dict) else {}
        yield from _nodes(name, units, devices, real, taken, may_repeat=may_repeat)


def _nodes(
    segment: str,
    units: Mapping[str, Any],
    devices: Mapping[str, ProfileInfo],
    real: Collection[str],
    taken: dict[str, str],
    *,
    may_repeat: bool,
) -> Iterator[Finding]:
    """Findings about the nodes of one segment. ``taken``: axes that have a node, with its segment;
    ``may_repeat``: several may have one number."""
    numbers: dict[int, str] = {}
    for axis, number in units.items():
        path = ("segments", segment, MODBUS, "units", axis)
        if finding := _axis_finding(path, str(axis), devices, real):
            yield finding
            continue
        device, part = address_of(str(axis))
        label = DeviceParts(devices[device].axes).label(device, part)
        if label in taken:
            message = f"{label} has a node on {taken[label]} already"
            yield Finding(path, message, "an axis has one: take one of them out", at_key=True)
            continue
        taken[label] = segment
        other = numbers.setdefault(number, label) if isinstance(number, int) else label
        if other != label and not may_repeat:
            remedy = 'give each a number of its own, or add "duplicate_units: true" to modbus'
            yield Finding(path, f"unit {number} is {other} already", remedy)


def _axis_finding(
    path: KeyPath, axis: str, devices: Mapping[str, ProfileInfo], real: Collection[str]
) -> Finding | None:
    device, part = address_of(axis)
    if finding := no_twin_finding(path, device, devices, real, "nodes here are of twins"):
        return replace(finding, at_key=True)
    profile = devices[device]
    if part and part not in profile.axes:
        message = no_part(device, "axis", part, profile.axes)
        return Finding(path, message, suggestion(part, [*profile.axes]), at_key=True)
    if MODBUS in (*profile.uarts, *profile.axes):
        message = f"a {profile.name} has a part {MODBUS} of its own"
        return Finding(path, message, "leave it out: its node would have the same name", at_key=True)
    return None
