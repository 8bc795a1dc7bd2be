"""Checks of TMCL modules on segments: whose they are, and their addresses."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from typing import Any

from hil.config.catalogue import ProfileInfo
from hil.config.document import Finding, KeyPath
from hil.config.explain import suggestion
from hil.config.joint_findings import no_twin_finding
from hil.vocab.address import DeviceParts, address_of, no_part
from tmcl_bus.frames import HOST
from tmcl_bus.tmcl_model import TMCL


def tmcl_findings(
    segments: Mapping[str, Any], devices: Mapping[str, ProfileInfo], real: Collection[str]
) -> Iterator[Finding]:
    """Findings about modules. ``devices``: those whose profile is known; ``real``: real boards."""
    taken: dict[str, str] = {}
    for name, segment in segments.items():
        config = segment.get(TMCL) if isinstance(segment, dict) else None
        modules = config.get("modules") if isinstance(config, dict) else None
        if not isinstance(config, dict) or not isinstance(modules, dict):
            continue
        numbers: dict[int, str] = {}
        for axis, number in modules.items():
            path = ("segments", name, TMCL, "modules", axis)
            if finding := _axis_finding(path, str(axis), devices, real):
                yield finding
                continue
            device, part = address_of(str(axis))
            label = DeviceParts(devices[device].axes).label(device, part)
            if label in taken:
                message = f"{label} has a module on {taken[label]} already"
                yield Finding(path, message, "an axis has one: take one of them out", at_key=True)
                continue
            taken[label] = name
            yield from _number_findings(path, number, label, numbers, config.get("host", HOST))


def _number_findings(
    path: KeyPath, number: object, label: str, numbers: dict[int, str], host: object
) -> Iterator[Finding]:
    """Findings about the address of a module. ``numbers``: modules of the segment before, by address."""
    if not isinstance(number, int):
        return
    if (other := numbers.setdefault(number, label)) != label:
        yield Finding(path, f"module {number} is {other} already", "give each an address of its own")
    if number == host:
        message = f"{number} is the host's address: the module would take replies of others for requests"
        yield Finding(path, message, 'give it another one, or tmcl another "host"')


def _axis_finding(
    path: KeyPath, axis: str, devices: Mapping[str, ProfileInfo], real: Collection[str]
) -> Finding | None:
    device, part = address_of(axis)
    if finding := no_twin_finding(path, device, devices, real, "modules here are of twins"):
        return replace(finding, at_key=True)
    profile = devices[device]
    if not profile.axes:
        return Finding(path, f"a {profile.name} has no axis", "a module needs one", at_key=True)
    if part and part not in profile.axes:
        message = no_part(device, "axis", part, profile.axes)
        return Finding(path, message, suggestion(part, [*profile.axes]), at_key=True)
    if TMCL in (*profile.uarts, *profile.axes):
        message = f"a {profile.name} has a part {TMCL} of its own"
        return Finding(path, message, "leave it out: its module would have the same name", at_key=True)
    return None
