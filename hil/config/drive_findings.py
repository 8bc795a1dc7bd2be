"""Checks of a real drive against its profile: its address, its map or units, and keys that it has not."""

from collections.abc import Mapping
from typing import Any

from hil.config.catalogue import ProfileInfo
from hil.config.document import Finding, KeyPath

EMULATED_KEYS = (
    "network",
    "ports",
    "bauds",
    "flash",
    "hardware",
    "plant",
    "load",
    "axis",
    "registers",
    "axes",
    "setpoints",
    "spi_previous_command",
)
ONLY_OF_DRIVES = {
    "poll_interval_ms": "only a drive on Modbus or CAN is polled",
    "units": "only a CANopen drive has units of its own",
}
"""Keys that only real drives have, with what is said of others."""


def drive_findings(
    path: KeyPath, raw: dict[str, Any], profile: ProfileInfo, at: str, result: dict[str, Any]
) -> tuple[list[Finding], dict[str, Any]]:
    """Findings about a real drive, which has no terminal that programs could be at; and what it has, without
    the keys of others. ``at``: its address, perhaps of something else."""
    findings = []
    if (finding := _address(path, raw, profile, at)) is not None:
        findings.append(finding)
    has_not = ("port", "baud", "echo", *EMULATED_KEYS)
    for key in has_not:
        if raw.get(key) is not None:
            message = "a real drive has no such key: it has its own, and its address says how it is reached"
            findings.append(Finding((*path, key), message, "leave this key out", at_key=True))
    others = (
        ("map", "a CANopen drive says itself what is where")
        if profile.drive
        else ("units", "a drive with a map has them there, as scale")
    )
    if raw.get(others[0]) is not None:
        findings.append(Finding((*path, others[0]), others[1], "leave this key out", at_key=True))
    kept = {key: value for key, value in result.items() if key not in (*has_not, others[0])}
    kept |= {"hardware": profile.default_hardware}
    return findings, kept


def _address(path: KeyPath, raw: dict[str, Any], profile: ProfileInfo, at: str) -> Finding | None:
    """Finding about an address, or a map that is missing."""
    from bridges.can.drives.can_drive_address import EXAMPLES as CAN_EXAMPLES
    from bridges.can.drives.can_drive_address import is_can_address
    from bridges.modbus.drives.modbus_drive_address import EXAMPLES, is_drive_address

    here, name = (*path, "at"), profile.name
    if profile.drive:
        if is_can_address(at):
            return None
        return Finding(
            here, f"a real {name} is reached over CAN", f"write {' or '.join(CAN_EXAMPLES.values())}"
        )
    if profile.map is None:
        what = "CANopen" if is_can_address(at) else "Modbus"
        return Finding(
            here, f"a {name} is no {what} drive", "write its serial port, or the profile of a drive"
        )
    if not is_drive_address(at):
        return Finding(
            here, f"a real {name} is reached over Modbus", f"write {' or '.join(EXAMPLES.values())}"
        )
    if raw.get("map") is None:
        remedy = 'add the line "map: ...", the path of a file that says where its maker has put each value'
        message = "a real drive has registers of its own, and there is no map"
        return Finding((*path, "map"), message, remedy)
    return None


def _one_of(examples: Mapping[str, str]) -> str:
    return f"write {' or '.join(examples.values())}"
