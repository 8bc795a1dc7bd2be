"""Checks of the switches along axes: whose shaft actuates each, which pin it is wired to, and whether the
axis comes there."""

from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from math import inf
from typing import Any

from hil.config.catalogue import ProfileInfo
from hil.config.document import Finding, KeyPath
from hil.config.joint_findings import pin_finding, pin_number
from hil.config.magnet_findings import shaft_finding
from hil.config.shaft_load import EndStopsLoad
from hil.config.station_names import CANOPEN
from hil.core.abi import SWITCHES as MOST_SWITCHES
from hil.vocab.address import DeviceParts, address_of, owner_of

SWITCHES = "switches"
_NODES = (CANOPEN, "modbus")
"""Names of nodes behind a device's."""

Devices = Mapping[str, ProfileInfo]


def switch_findings(
    value: Mapping[str, object], devices: Devices, real: Collection[str]
) -> Iterator[Finding]:
    """Findings about the switches of a configuration."""
    given = value.get(SWITCHES)
    wired = dict(_wired(value.get("wires"), devices, real))
    count: Counter[str] = Counter()
    for name, raw in given.items() if isinstance(given, dict) else ():
        if not isinstance(raw, dict):
            continue
        path: KeyPath = (SWITCHES, name)
        axis, to = raw.get("axis"), raw.get("to")
        if isinstance(axis, str):
            if finding := shaft_finding((*path, "axis"), axis, devices, real, "that could hold a switch"):
                yield finding
            else:
                label = _label(axis, devices)
                yield from _taken(path, str(name), owner_of(axis), devices)
                count[label] += 1
                if count[label] == MOST_SWITCHES + 1:
                    message = f"{label} has {MOST_SWITCHES} switches already"
                    yield Finding((*path, "axis"), message, "take one of them out")
                yield from _beyond_stops(path, raw, label, value)
        yield from _placeless(path, raw)
        if isinstance(to, str):
            here = (*path, "to")
            if finding := pin_finding(to, here, "to", devices, real):
                yield finding
            elif (
                by := wired.setdefault(pin_number(to, devices), f"the switch {name}")
            ) != f"the switch {name}":
                yield Finding(here, f"{to} is driven by {by} already", "give each a pin of its own")


def switch_axes(value: Mapping[str, object], devices: Devices) -> dict[str, str]:
    """Addresses of the axes that actuate the switches of a configuration, as hil writes them, by name."""
    given = value.get(SWITCHES)
    axes = {
        str(name): raw.get("axis")
        for name, raw in (given.items() if isinstance(given, dict) else ())
        if isinstance(raw, dict)
    }
    return {
        name: _label(axis, devices)
        for name, axis in axes.items()
        if isinstance(axis, str) and address_of(axis).owner in devices
    }


def _taken(path: KeyPath, name: str, device: str, devices: Devices) -> Iterator[Finding]:
    """Finding of a switch whose address is that of another part of the device."""
    parts = {*devices[device].axes, *devices[device].uarts, *_NODES}
    if name in parts:
        remedy = "give the switch another name"
        yield Finding(path, f"{device}.{name} is another part of {device} already", remedy, at_key=True)


def _placeless(path: KeyPath, raw: Mapping[str, Any]) -> Iterator[Finding]:
    """Finding of a switch that is never held, or never let go."""
    from_deg, to_deg = raw.get("from_deg"), raw.get("to_deg")
    if from_deg is None and to_deg is None:
        remedy = "write from_deg, to_deg or both"
        yield Finding(path, "the switch has no place", remedy, at_key=True)
        return
    width_deg = _number(to_deg, inf) - _number(from_deg, -inf)
    if width_deg < 0:
        remedy = "write an angle that is not less than from_deg"
        yield Finding((*path, "to_deg"), "the switch ends where it has not begun", remedy)
    elif (every_deg := _number(raw.get("every_deg"), inf)) <= width_deg + 2 * _number(
        raw.get("hysteresis_deg"), 0.0
    ):
        remedy = "write from_deg and to_deg, with more than what lies between them here"
        if raw.get("every_deg") is not None:
            message = f"with {every_deg:g} deg the switch is never let go"
            yield Finding((*path, "every_deg"), message, remedy)


def _label(axis: str, devices: Devices) -> str:
    device, part = address_of(axis)
    return DeviceParts(devices[device].axes).label(device, part)


def _wired(
    wires: object, devices: Devices, real: Collection[str]
) -> Iterator[tuple[tuple[str, object], str]]:
    for wire in wires if isinstance(wires, list) else ():
        to = wire.get("to") if isinstance(wire, dict) else None
        if isinstance(to, str) and not pin_finding(to, (), "to", devices, real):
            yield pin_number(to, devices), str(wire.get("from"))


def _beyond_stops(
    path: KeyPath, raw: Mapping[str, Any], label: str, value: Mapping[str, object]
) -> Iterator[Finding]:
    """Finding of a switch that lies behind a hard stop."""
    stops = stops_of(value, label)
    if stops is None:
        return
    from_deg, to_deg = _number(raw.get("from_deg"), -inf), _number(raw.get("to_deg"), inf)
    if raw.get("every_deg") is not None or not (from_deg > stops.max_deg or to_deg < stops.min_deg):
        return
    key = "from_deg" if from_deg > stops.max_deg else "to_deg"
    message = (
        f"{label} stops at {stops.max_deg if key == 'from_deg' else stops.min_deg:g} deg, before the switch"
    )
    remedy = f"write an angle from {stops.min_deg:g} to {stops.max_deg:g}, or put the stop behind the switch"
    yield Finding((*path, key), message, remedy)


def stops_of(value: Mapping[str, object], label: str) -> EndStopsLoad | None:
    """End stops of the axis at an address, as hil writes it, in a completed configuration."""
    name, part = address_of(label)
    devices = value.get("devices")
    device = devices.get(name) if isinstance(devices, dict) else None
    if not isinstance(device, dict):
        return None
    axes = device.get("axes")
    own = axes.get(part) if part and isinstance(axes, dict) else None
    load = own.get("load") if isinstance(own, dict) else None if part else device.get("load")
    return load if isinstance(load, EndStopsLoad) else None


def _number(value: object, otherwise: float) -> float:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return float(value) if is_number else otherwise  # type: ignore[arg-type]
