"""Checks of wires and segments between devices, against what each kind of board has. The models check their
form. ``devices``: those whose profile is known; ``real``: those that are no twins."""

from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from typing import Any

from hil.config.catalogue import ProfileInfo
from hil.config.document import Finding, KeyPath
from hil.config.explain import shown, suggestion
from hil.config.level_findings import level_findings
from hil.config.station_names import station_uart
from hil.core.abi import WIRES
from hil.core.axis_kind import CLOCK_IN, CLOCK_OUT, AxisKind
from hil.vocab.address import DeviceParts, address_of, no_part, pin_of
from hil.vocab.firmware import NETWORK
from hil.vocab.near_words import meant

Devices = Mapping[str, ProfileInfo]


def joint_findings(value: Mapping[str, object], devices: Devices, real: Collection[str]) -> Iterator[Finding]:
    """Findings about the wires and segments of a configuration."""
    yield from _wire_findings(value.get("wires"), devices, real)
    yield from level_findings(value, devices, real)
    yield from _segment_findings(value, devices, real)


def no_twin_finding(
    path: KeyPath, device: str, devices: Devices, real: Collection[str], why: str
) -> Finding | None:
    """Finding of a device that is no twin, or None. ``why``: what to do if it is a real board."""
    if device not in devices:
        return Finding(path, f"there is no device {shown(device)}", suggestion(device, devices))
    return Finding(path, f"{device} is a real board", why) if device in real else None


def _wire_findings(wires: object, devices: Devices, real: Collection[str]) -> Iterator[Finding]:
    driven: dict[tuple[str, object], tuple[int, bool]] = {}
    begun: Counter[str] = Counter()
    wires = wires if isinstance(wires, list) else []
    for index, wire in enumerate(wires):
        if not isinstance(wire, dict) or not all(isinstance(wire.get(end), str) for end in ("from", "to")):
            continue
        path: KeyPath = ("wires", index)
        ends = [pin_finding(wire[end], (*path, end), end, devices, real) for end in ("from", "to")]
        if any(ends):
            yield from filter(None, ends)
            continue
        (source, output), (axis, pin) = (_pin(wire[end], devices) for end in ("from", "to"))
        if (output == CLOCK_OUT) != (pin == CLOCK_IN):
            remedy = f"wire {CLOCK_OUT} to {CLOCK_IN}, and other outputs to other inputs"
            yield Finding(path, f"{shown(output)} and {shown(pin)} do not fit", remedy)
            continue
        begun[source] += output != CLOCK_OUT
        if begun[source] == WIRES + 1:
            message = f"{source} has {WIRES} wires already"
            yield Finding((*path, "from"), message, "begin this one at another device")
        inputs = _kind(axis, devices).inputs
        is_shared = output in _kind(source, devices).open_outputs
        driver, shares = driven.setdefault((axis, inputs.get(pin, pin)), (index, is_shared))
        if driver != index and not (is_shared and shares):
            message = f"{wire['to']} is driven by {wires[driver]['from']} already"
            yield Finding((*path, "to"), message, "an input takes one wire: take one of them out")


def _pin(text: str, devices: Devices) -> tuple[str, str]:
    """Address of an axis, as hil writes it, and pin."""
    axis, pin = pin_of(text)
    device, part = address_of(axis)
    return DeviceParts(devices[device].axes).label(device, part), pin


def pin_number(text: str, devices: Devices) -> tuple[str, object]:
    """Axis and number of an input at an address that has no finding: two names of a pin have one."""
    axis, pin = _pin(text, devices)
    return axis, _kind(axis, devices).inputs.get(pin, pin)


def _kind(axis: str, devices: Devices) -> AxisKind:
    device, part = address_of(axis)
    profile = devices[device]
    return profile.kind(part or DeviceParts(profile.axes).first)


def pin_finding(
    text: str, path: KeyPath, end: str, devices: Devices, real: Collection[str]
) -> Finding | None:
    """Finding of an address that is no output (``end`` is "from") or no input ("to") of a twin, or None."""
    axis, pin = pin_of(text)
    if not axis:
        return Finding(path, f"{shown(text)} is no pin", "write the device and its pin, as in s1.clk")
    device, part = address_of(axis)
    if no_twin := no_twin_finding(path, device, devices, real, "wire it by hand; wires here join twins"):
        return no_twin
    axes = devices[device].axes
    if not axes or (part and part not in axes):
        return Finding(path, no_part(device, "axis", part, axes), "write the device, its axis and its pin")
    kind, device = _kind(axis, devices), axis
    wanted, other = (kind.inputs, kind.outputs) if end == "to" else (kind.outputs, kind.inputs)
    wanted_names = [*wanted, CLOCK_IN if end == "to" else CLOCK_OUT] if kind.has_clock else [*wanted]
    if pin in wanted_names:
        return None
    if pin in (*other, CLOCK_OUT if end == "to" else CLOCK_IN):
        what = "an output" if end == "to" else "an input"
        return Finding(path, f"{pin} of {device} is {what}", _choice(device, wanted_names))
    remedy = meant(pin, wanted_names) if wanted_names else _choice(device, [])
    return Finding(path, f"{device} has no pin {shown(pin)}", remedy)


def _choice(device: str, names: list[str]) -> str:
    return f"write one of {', '.join(names)}" if names else f"{device} has no pin that a wire can begin at"


def _segment_findings(
    value: Mapping[str, object], devices: Devices, real: Collection[str]
) -> Iterator[Finding]:
    taken: dict[tuple[str, str], str] = {}
    segments = value.get("segments")
    for name, segment in segments.items() if isinstance(segments, dict) else ():
        if name in devices:
            message = f"a device has the name {shown(name)} already"
            yield Finding(("segments", name), message, "give the segment another", at_key=True)
        stations = segment.get("stations") if isinstance(segment, dict) else None
        for index, station in enumerate(stations if isinstance(stations, list) else ()):
            if not isinstance(station, str):
                continue
            path = ("segments", name, "stations", index)
            device, part = address_of(station)
            if no_twin := no_twin_finding(path, device, devices, real, "stations here are twins"):
                yield no_twin
                continue
            profile = devices[device]
            uart = part or station_uart(profile.uarts) or ""
            is_usb = uart in profile.uarts and profile.baud(uart) is None
            if (is_usb and not part) or uart == NETWORK not in profile.uarts:
                yield Finding(path, f"a {profile.name} has no network", "leave it out")
            elif not profile.uarts:
                yield Finding(path, f"{device} has no serial interface", "leave it out")
            elif not uart:
                remedy = f"write {device}.UART, with one of {', '.join(profile.uarts)}"
                yield Finding(path, f"{device} has several serial interfaces", remedy)
            elif uart not in profile.uarts:
                message = f"{device} has no serial interface {shown(uart)}"
                yield Finding(path, message, suggestion(uart, profile.uarts))
            elif is_usb:
                message = f"the serial interface of a {profile.name} is USB"
                if len(profile.uarts) > 1:
                    message = f"the serial interface {uart} of a {profile.name} is USB"
                yield Finding(path, message, "leave it out")
            elif where := taken.get((device, uart)):
                yield Finding(path, f"{device}.{uart} is on segment {where} already", "take one of them out")
            else:
                taken[device, uart] = name
                yield from _no_speed(value.get("devices"), device, uart, profile)


def _no_speed(raws: Any, device: str, uart: str, profile: ProfileInfo) -> Iterator[Finding]:
    """Finding of a station whose bytes would take no time."""
    raw, is_first = raws[device], uart == profile.first_uart
    given = {uart: raw["baud"]} if is_first else raw.get("bauds")
    if isinstance(given, dict) and given.get(uart, 0) is None:
        path = ("devices", device, *(("baud",) if is_first else ("bauds", uart)))
        yield Finding(path, "a station of a segment needs a speed", "write it, or leave this key out")
