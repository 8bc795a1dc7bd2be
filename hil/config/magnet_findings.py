"""Checks of magnets: which device reads one, and on whose shaft it is."""

from collections.abc import Collection, Iterator, Mapping

from hil.config.catalogue import ProfileInfo
from hil.config.document import Finding, KeyPath
from hil.config.explain import shown
from hil.config.joint_findings import no_twin_finding
from hil.core.kinds import KINDS
from hil.vocab.address import DeviceParts, address_of, no_part

MAGNET = "magnet"

Devices = Mapping[str, ProfileInfo]


def magnet_findings(
    value: Mapping[str, object], devices: Devices, real: Collection[str]
) -> Iterator[Finding]:
    """Findings about the magnets of a configuration."""
    given = value.get("devices")
    for name, raw in given.items() if isinstance(given, dict) else ():
        magnet = raw.get(MAGNET) if isinstance(raw, dict) else None
        if magnet is None or name in real:
            continue
        path: KeyPath = ("devices", name, MAGNET)
        if not any(KINDS[axis.law].reads_magnet for axis in devices[name].axes.values()):
            message = f"a {devices[name].name} reads no magnet"
            yield Finding(path, message, "leave this key out", at_key=True)
            continue
        if isinstance(magnet, dict):
            path, magnet = (*path, "of"), magnet.get("of")
        if isinstance(magnet, str) and (
            finding := shaft_finding(path, magnet, devices, real, "that a magnet could be on")
        ):
            yield finding


def shaft_finding(
    path: KeyPath, of: str, devices: Devices, real: Collection[str], what: str
) -> Finding | None:
    """Finding of an address that is no shaft of a twin, or None. ``what``: what the shaft is wanted for."""
    device, part = address_of(of)
    why = "only the shafts of twins are known to the core"
    if no_twin := no_twin_finding(path, device, devices, real, why):
        return no_twin
    axes = devices[device].axes
    if part and part not in axes:
        return Finding(path, no_part(device, "axis", part, axes), "write the device and its axis")
    if axes and KINDS[DeviceParts(axes)[part].law].has_motor:
        return None
    message = f"{shown(of)} has no motor, and so no shaft {what}"
    return Finding(path, message, _with_motors(devices, real))


def _with_motors(devices: Devices, real: Collection[str]) -> str:
    names = [
        DeviceParts(profile.axes).label(name, axis)
        for name, profile in devices.items()
        for axis, info in profile.axes.items()
        if name not in real and KINDS[info.law].has_motor
    ]
    return f"write one of {', '.join(names)}" if names else "add a device with a motor"
