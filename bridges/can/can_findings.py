"""Checks of CAN buses: whose nodes are on them, their ids, and their switches."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from typing import Any

from hil.config.catalogue import ProfileInfo
from hil.config.document import Finding, KeyPath
from hil.config.explain import shown, suggestion
from hil.config.joint_findings import no_twin_finding
from hil.config.station_names import CANOPEN, nodes_of
from hil.config.switch_findings import switch_axes
from hil.core.kinds import KINDS
from hil.vocab.address import DeviceParts, address_of, no_input, no_part
from hil.vocab.faults import CAN_NODE, LINE, ON_LINE

Devices = Mapping[str, ProfileInfo]
MOST_NODES = 256
"""Maximum number of nodes on a bus, taps included."""
MAKER_KEYS = ("eds", "units", "objects")
"""Keys of a node of a maker's drive."""
_CAM = ("from_deg", "to_deg", "below_deg", "above_deg")
_EXAMPLE = "write {from_deg: 10, to_deg: 20}, {below_deg: -90}, {above_deg: 90}, {pin: D3} or {switch: NAME}"


def can_findings(value: Mapping[str, Any], devices: Devices, real: Collection[str]) -> Iterator[Finding]:
    """Findings about the buses of a configuration. ``devices``: those whose profile is known; ``real``: real
    boards."""
    buses, segments = value.get("can"), value.get("segments")
    taken: dict[str, str] = {}
    for name, bus in buses.items() if isinstance(buses, dict) else ():
        others = {"device": devices, "segment": segments if isinstance(segments, dict) else {}}
        for what, names in others.items():
            if name in names:
                message = f"a {what} has the name {shown(name)} already"
                yield Finding(("can", name), message, "give the bus another", at_key=True)
        nodes, taps = (bus.get(key) for key in ("nodes", "taps")) if isinstance(bus, dict) else (None, None)
        if isinstance(nodes, dict):
            count = len(nodes) + (len(taps) if isinstance(taps, dict) else 0)
            if count > MOST_NODES:
                message = f"there are {count} nodes and taps, and a bus has at most {MOST_NODES}"
                yield Finding(("can", name), message, "put some of them on another bus", at_key=True)
            may_share = bus.get("duplicate_ids") is True
            yield from _nodes(name, nodes, devices, real, taken, may_share=may_share)
            yield from _named_switches(("can", name, "nodes"), nodes, devices, switch_axes(value, devices))
            if any(isinstance(node, dict) and any(map(node.get, MAKER_KEYS)) for node in nodes.values()):
                from bridges.can.maker_findings import maker_findings

                yield from maker_findings(name, bus, devices)


def fault_places(name: str, bus: Mapping[str, Any], devices: Devices) -> dict[str, set[str]]:
    """Targets of faults of a bus, itself and its stations, with their kinds."""
    taps = bus.get("taps")
    on_bus = [f"{name}.{tap}" for tap in taps] if isinstance(taps, dict) else []
    on_bus += nodes_of(bus.get("nodes"), devices, CANOPEN)
    return {each: {ON_LINE, CAN_NODE} for each in on_bus} | {name: {LINE}}


def _nodes(
    bus: str,
    nodes: Mapping[str, Any],
    devices: Devices,
    real: Collection[str],
    taken: dict[str, str],
    *,
    may_share: bool,
) -> Iterator[Finding]:
    """Findings about the nodes of one bus. ``taken``: axes that have a node, with its bus."""
    ids: dict[int, str] = {}
    for axis, given in nodes.items():
        path = ("can", bus, "nodes", axis)
        if finding := _axis_finding(path, str(axis), devices, real):
            yield finding
            continue
        device, part = address_of(str(axis))
        axes = DeviceParts(devices[device].axes)
        label = axes.label(device, part)
        if label in taken:
            message = f"{label} has a node on {taken[label]} already"
            yield Finding(path, message, "an axis has one: take one of them out", at_key=True)
            continue
        taken[label] = bus
        number = given.get("id") if isinstance(given, dict) else given
        at_id = (*path, "id") if isinstance(given, dict) else path
        if isinstance(number, int) and ids.setdefault(number, label) != label and not may_share:
            message = f"node {number} is {ids[number]} already"
            remedy = 'give each an id of its own, or add the line "duplicate_ids: true"'
            yield Finding(at_id, message, remedy)
        switches = given.get("switches") if isinstance(given, dict) else None
        if isinstance(switches, dict):
            kind = KINDS[axes[part].law]
            inputs = {pin: number for pin, number in kind.inputs.items() if kind.level_field(pin)}
            yield from _switches((*path, "switches"), label, switches, inputs)


def _axis_finding(path: KeyPath, axis: str, devices: Devices, real: Collection[str]) -> Finding | None:
    device, part = address_of(axis)
    if finding := no_twin_finding(path, device, devices, real, "nodes here are of twins"):
        return replace(finding, at_key=True)
    profile = devices[device]
    if not profile.axes or (part and part not in profile.axes):
        message = no_part(device, "axis", part, profile.axes)
        return Finding(path, message, suggestion(part, [*profile.axes]), at_key=True)
    if not KINDS[DeviceParts(profile.axes)[part].law].is_commanded:
        message = f"a {profile.name} has no drive that a node could command"
        return Finding(path, message, "leave it out", at_key=True)
    if CANOPEN in (*profile.uarts, *profile.axes):
        message = f"a {profile.name} has a part {CANOPEN} of its own"
        return Finding(path, message, "leave it out: its node would have the same name", at_key=True)
    return None


def _switches(
    path: KeyPath, axis: str, switches: Mapping[str, Any], inputs: Mapping[str, int]
) -> Iterator[Finding]:
    """Findings about the switches of one node. ``inputs``: numbers of the axis's inputs by name."""
    pins: dict[int, str] = {}
    for name, switch in switches.items():
        if not isinstance(switch, dict):
            continue
        here = (*path, name)
        yield from _switch(here, switch)
        pin = switch.get("pin")
        if not isinstance(pin, str):
            continue
        if pin not in inputs:
            message, known = no_input(axis, pin, inputs)
            remedy = known if inputs else "write a cam: this axis has no inputs"
            yield Finding((*here, "pin"), message, remedy)
        elif (other := pins.setdefault(inputs[pin], name)) != name:
            message = f"the switch {other} is at {pin} already"
            yield Finding((*here, "pin"), message, "give each a pin of its own")
    below, above = _angle(switches, "negative", "below_deg"), _angle(switches, "positive", "above_deg")
    if below is not None and above is not None and below >= above:
        message = f"the switch negative is active up to {below:g}, where positive is active too"
        remedy = "leave room between them: below_deg of negative is less than above_deg of positive"
        yield Finding((*path, "positive", "above_deg"), message, remedy)


def _named_switches(
    path: KeyPath, nodes: Mapping[str, Any], devices: Devices, axes: Mapping[str, str]
) -> Iterator[Finding]:
    """Findings about switches of the bench at nodes. ``axes``: those that actuate them, by their names."""
    for axis, given in nodes.items():
        owner, part = address_of(str(axis))
        switches = given.get("switches") if isinstance(given, dict) and owner in devices else None
        if not isinstance(switches, dict):
            continue
        label = DeviceParts(devices[owner].axes).label(owner, part)
        here = [name for name, of in axes.items() if of == label]
        for name, switch in switches.items():
            wanted = switch.get("switch") if isinstance(switch, dict) else None
            if not isinstance(wanted, str) or wanted in here:
                continue
            message = f"there is no switch {shown(wanted)} at {label}"
            if wanted in axes:
                message = f"the switch {wanted} is at {axes[wanted]}, and not at {label}"
            remedy = (
                suggestion(wanted, here) if here else f"add one to the bench's switches, with axis: {label}"
            )
            yield Finding((*path, axis, "switches", name, "switch"), message, remedy)


def _switch(path: KeyPath, switch: Mapping[str, Any]) -> Iterator[Finding]:
    given = [key for key in _CAM if switch.get(key) is not None]
    has_pin = switch.get("pin") is not None
    others = [
        key for key in (*given, "pin" if has_pin else "", "active" if switch.get("active") else "") if key
    ]
    if switch.get("switch") is not None:
        if others:
            message = f"the bench's switch says where it is, and here is {others[0]} too"
            yield Finding((*path, others[0]), message, "take one of them out", at_key=True)
    elif given and has_pin:
        message = f"a switch is a cam or at a pin, and here are {given[0]} and pin"
        yield Finding((*path, "pin"), message, "take one of them out", at_key=True)
    elif not given and not has_pin:
        yield Finding(path, "there is neither a cam nor a pin", _EXAMPLE, at_key=True)
    elif switch.get("active") is not None and not has_pin:
        yield Finding((*path, "active"), "a cam has no level", "leave this key out", at_key=True)
    elif given == ["from_deg", "to_deg"]:
        begin, end = switch["from_deg"], switch["to_deg"]
        if all(isinstance(each, int | float) for each in (begin, end)) and not begin < end:
            message = f"a cam from {begin:g} to {end:g} is never under the switch"
            yield Finding((*path, "to_deg"), message, "write an angle beyond from_deg")
    elif len(given) > 1 or given in (["from_deg"], ["to_deg"]):
        yield Finding((*path, given[0]), f"{' and '.join(given)} are no cam", _EXAMPLE, at_key=True)


def _angle(switches: Mapping[str, Any], name: str, key: str) -> float | None:
    switch = switches.get(name)
    value = switch.get(key) if isinstance(switch, dict) else None
    return value if isinstance(value, int | float) and not isinstance(value, bool) else None
