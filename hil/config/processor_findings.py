"""Checks of what is around a board's processor: voltages at its pins, and the driver of its line."""

from collections.abc import Collection, Iterator, Mapping

from hil.config.catalogue import ProfileInfo
from hil.config.document import Finding, KeyPath
from hil.config.explain import shown
from hil.config.joint_findings import no_twin_finding
from hil.core import AxisKind
from hil.vocab.address import DeviceParts, address_of, no_part, pin_of
from hil.vocab.near_words import meant

VOLTAGES, RS485 = KEYS = ("voltages", "rs485")

Devices = Mapping[str, ProfileInfo]


def processor_findings(
    value: Mapping[str, object], devices: Devices, real: Collection[str]
) -> Iterator[Finding]:
    """Findings about processors of a configuration, against what each kind of board has."""
    given = value.get("devices")
    for name, raw in given.items() if isinstance(given, dict) else ():
        if not isinstance(raw, dict) or name in real:
            continue
        keys = [key for key in KEYS if raw.get(key)]
        if devices[name].processor is None:
            for key in keys:
                message = f"a {devices[name].name} has no processor that runs a user's program"
                yield Finding(("devices", name, key), message, "leave this key out", True)
            continue
        path = ("devices", name, VOLTAGES)
        yield from _pins(path, raw.get(VOLTAGES), devices[name])
        yield from _voltages(path, raw.get(VOLTAGES), devices, real)
        yield from _driver(("devices", name, RS485, "de"), raw.get(RS485), devices[name])


def _pins(path: KeyPath, given: object, profile: ProfileInfo) -> Iterator[Finding]:
    analog = _kind(profile).analog
    for pin in given if isinstance(given, dict) else ():
        if pin not in analog:
            remedy = meant(str(pin), list(analog))
            yield Finding((*path, pin), f"a {profile.name} has no analogue pin {shown(pin)}", remedy, True)


def _kind(profile: ProfileInfo, part: str = "") -> AxisKind:
    return profile.kind(part or DeviceParts(profile.axes).first)


def _voltages(path: KeyPath, given: object, devices: Devices, real: Collection[str]) -> Iterator[Finding]:
    for pin, voltage in given.items() if isinstance(given, dict) else ():
        of = voltage.get("of") if isinstance(voltage, dict) else None
        if not isinstance(of, str):
            continue
        if finding := _field((*path, pin, "of"), of, devices, real):
            yield finding
        elif voltage.get("rc_s") is not None and not _is_mean(of, devices):
            message = f"{of} is no mean voltage of a processor's pin, which alone an RC low-pass can follow"
            remedy = "leave this key out, or write a field as u2.d9_V above"
            yield Finding((*path, pin, "rc_s"), message, remedy, True)


def _is_mean(of: str, devices: Devices) -> bool:
    axis, field = pin_of(of)
    device, part = address_of(axis)
    return field in _kind(devices[device], part).means


def _field(path: KeyPath, of: str, devices: Devices, real: Collection[str]) -> Finding | None:
    axis, field = pin_of(of)
    if not axis:
        return Finding(path, f"{shown(of)} is no field", "write a device and a field, as in m1.current_a_A")
    device, part = address_of(axis)
    if no_twin := no_twin_finding(path, device, devices, real, "only what twins do is known to the core"):
        return no_twin
    axes = devices[device].axes
    if not axes or (part and part not in axes):
        return Finding(path, no_part(device, "axis", part, axes), "write the device, its axis and a field")
    fields = _kind(devices[device], part).fields
    if field in fields:
        return None
    return Finding(path, f"{axis} has no field {shown(field)}", meant(field, list(fields)))


def _driver(path: KeyPath, given: object, profile: ProfileInfo) -> Iterator[Finding]:
    pin = given.get("de") if isinstance(given, dict) else None
    outputs = _kind(profile).outputs
    if isinstance(pin, str) and pin not in outputs:
        yield Finding(path, f"a {profile.name} has no pin {shown(pin)}", meant(pin, list(outputs)))
