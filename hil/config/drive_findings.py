"""Checks of a real drive against its profile: its address, its map or units, and keys that it has not."""

from typing import Any

from hil.config.catalogue import Catalogue, ProfileInfo
from hil.config.document import Finding, KeyPath
from hil.config.real_places import kind_at
from hil.vocab.bus import DriveKind

EMULATED_KEYS = (
    "network",
    "ports",
    "bauds",
    "flash",
    "firmware",
    "bootloader",
    "voltages",
    "fields",
    "parameters",
    "sketch",
    "rs485",
    "magnet",
    "hardware",
    "plant",
    "motor",
    "load",
    "axis",
    "registers",
    "axes",
    "setpoints",
    "spi_previous_command",
)
ONLY_OF_DRIVES = {"poll_interval_ms": "only a drive on Modbus or CAN is polled"}
"""Keys that all real drives have and no other board has, with what is said of others."""


def drive_findings(
    path: KeyPath,
    raw: dict[str, Any],
    profile: ProfileInfo,
    at: str,
    result: dict[str, Any],
    catalogue: Catalogue,
) -> tuple[list[Finding], dict[str, Any]]:
    """Findings about a real drive, which has no terminal that programs could be at; and what it has, without
    the keys of others. ``at``: its address, perhaps of something else."""
    findings = []
    kind = catalogue.drive_kind(profile)
    if (finding := _address(path, raw, profile, at, catalogue, kind)) is not None:
        findings.append(finding)
    has_not = ("port", "baud", "echo", *EMULATED_KEYS)
    for key in has_not:
        if raw.get(key) is not None:
            message = "a real drive has no such key: it has its own, and its address says how it is reached"
            findings.append(Finding((*path, key), message, "leave this key out", at_key=True))
    others = kind.no_keys if kind else {}
    for key, why in others.items():
        if raw.get(key) is not None:
            findings.append(Finding((*path, key), why, "leave this key out", at_key=True))
    kept = {key: value for key, value in result.items() if key not in (*has_not, *others)}
    kept |= {"hardware": profile.default_hardware}
    return findings, kept


def _address(
    path: KeyPath,
    raw: dict[str, Any],
    profile: ProfileInfo,
    at: str,
    catalogue: Catalogue,
    kind: DriveKind | None,
) -> Finding | None:
    """Finding about an address, or a map that is missing. ``kind``: the drive's, by its profile."""
    here, name = (*path, "at"), profile.name
    there = kind_at(at, catalogue.drive_kinds)
    if kind is None:
        what = there.protocol if there else "real"
        remedy = "write its serial port, or the profile of a drive"
        return Finding(here, f"a {name} is no {what} drive", remedy)
    if there is not kind:
        return Finding(
            here, f"a real {name} is reached over {kind.over}", f"write {' or '.join(kind.examples())}"
        )
    if profile.map is not None and raw.get("map") is None:
        remedy = 'add the line "map: ...", the path of a file that says where its maker has put each value'
        message = "a real drive has registers of its own, and there is no map"
        return Finding((*path, "map"), message, remedy)
    return None
