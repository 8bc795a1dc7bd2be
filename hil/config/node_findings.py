"""Checks that nodes of all protocols on segments share: whose they are, and that no number is taken."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from hil.config.catalogue import ProfileInfo
from hil.config.document import Finding, KeyPath
from hil.config.explain import suggestion
from hil.config.joint_findings import no_twin_finding
from hil.vocab.address import DeviceParts, address_of, no_part


class NodeRules(NamedTuple):
    """Nodes of a protocol in a configuration."""

    key: str
    axes_key: str
    """Keys as ``hil.vocab.bus.NodeKind`` has them."""
    word: str
    """Word for a node."""
    number_findings: Callable[[KeyPath, int, str | None, Mapping[str, Any]], Iterable[Finding]]
    """Finds what is wrong with a number. Arguments: its path, the number, the axis before that has it too or
    None, what stands under ``key``."""


def node_findings(
    segments: Mapping[str, Any], devices: Mapping[str, ProfileInfo], real: Collection[str], rules: NodeRules
) -> Iterator[Finding]:
    """Findings about nodes. ``devices``: those whose profile is known; ``real``: real boards."""
    taken: dict[str, str] = {}
    for name, segment in segments.items():
        config = segment.get(rules.key) if isinstance(segment, dict) else None
        nodes = config.get(rules.axes_key) if isinstance(config, dict) else None
        if not isinstance(config, dict) or not isinstance(nodes, dict):
            continue
        numbers: dict[int, str] = {}
        for axis, number in nodes.items():
            path = ("segments", name, rules.key, rules.axes_key, axis)
            if finding := _axis_finding(path, str(axis), devices, real, rules):
                yield finding
                continue
            device, part = address_of(str(axis))
            label = DeviceParts(devices[device].axes).label(device, part)
            if label in taken:
                message = f"{label} has a {rules.word} on {taken[label]} already"
                yield Finding(path, message, "an axis has one: take one of them out", at_key=True)
                continue
            taken[label] = name
            if isinstance(number, int):
                other = numbers.setdefault(number, label)
                yield from rules.number_findings(path, number, other if other != label else None, config)


def _axis_finding(
    path: KeyPath, axis: str, devices: Mapping[str, ProfileInfo], real: Collection[str], rules: NodeRules
) -> Finding | None:
    device, part = address_of(axis)
    if finding := no_twin_finding(path, device, devices, real, f"{rules.word}s here are of twins"):
        return replace(finding, at_key=True)
    profile = devices[device]
    if part and part not in profile.axes:
        message = no_part(device, "axis", part, profile.axes)
        return Finding(path, message, suggestion(part, [*profile.axes]), at_key=True)
    if not profile.axes and profile.map is None:
        return Finding(path, f"a {profile.name} has no axis", f"a {rules.word} needs one", at_key=True)
    if rules.key in (*profile.uarts, *profile.axes):
        message = f"a {profile.name} has a part {rules.key} of its own"
        remedy = f"leave it out: its {rules.word} would have the same name"
        return Finding(path, message, remedy, at_key=True)
    return None
