"""Difference of two configurations as a reload sees it: which devices go on, which start again, and by which
keys.

Devices that are joined to others, by wires, a segment or a CAN bus, share one simulated time: a change of one
of them is a change of the whole bench, which only a restart of the daemon makes. Keys of the bench are such a
change too, except faults, which belong to their targets.
"""

import json
from collections.abc import Iterator
from hashlib import sha256
from typing import Any, Literal

from hil.config.device_program import PROGRAM_KEYS
from hil.config.model import BenchConfig, DeviceConfig
from hil.vocab.address import owner_of
from hil.vocab.late_dataclass import dataclass

_SHOWN, _BEGINNING = 400, 40
"""Characters of a value up to which it is shown whole, and of the beginning of a longer one, as of a file's
text."""


def _digest(text: str) -> str:
    return sha256(text.encode()).hexdigest()[:12]


@dataclass(frozen=True)
class Change:
    """Change of one device, or of the whole core (``device`` None) and so of every device. ``why`` has a line
    for each key that differs, ``key: old -> new``; empty for keep.
    """

    device: str | None
    action: Literal["keep", "restart", "add", "remove"]
    why: tuple[str, ...] = ()


def diff(old: BenchConfig, new: BenchConfig) -> list[Change]:
    """List the changes in the order in which to make them: the core, removals, then the new file's order."""
    joined = set().union(*old.joints(), *new.joints())
    core = list(_why(_bench_keys(old), _bench_keys(new)))
    core += _why(_faults_elsewhere(old), _faults_elsewhere(new))
    changes = [
        Change(name, "remove", ("it is no longer in the configuration",))
        for name in old.devices
        if name not in new.devices
    ]
    for name, device in new.devices.items():
        if name not in old.devices:
            changes.append(Change(name, "add", ("it is new in the configuration",)))
        else:
            why = _why(_keys(old.devices[name]), _keys(device)) + _why(_faults(old, name), _faults(new, name))
            changes.append(Change(name, "restart" if why else "keep", why))
    core += [
        f"{change.device}, which is joined to others: {line}"
        for change in changes
        if change.device in joined
        for line in change.why
    ]
    return ([Change(None, "restart", tuple(core))] if core else []) + changes


def _bench_keys(bench: BenchConfig) -> dict[str, str]:
    without = {"devices", "faults", "recordings", "commands", "labels"}
    return _flat(bench.model_dump(mode="json", by_alias=True, exclude=without))


def _faults(bench: BenchConfig, device: str) -> dict[str, str]:
    found = [fault for fault in bench.faults if owner_of(fault.target) == device]
    return {"faults": json.dumps([fault.model_dump(mode="json") for fault in found])} if found else {}


def _faults_elsewhere(bench: BenchConfig) -> dict[str, str]:
    """Faults of segments, buses and taps; those of joined devices are among the devices' own."""
    places = bench.bus_wires()
    return {f"faults of {place}": text for place in places for text in _faults(bench, place).values()}


def _keys(device: DeviceConfig) -> dict[str, str]:
    dump = device.model_dump(mode="json")
    for key in ("port", "network"):
        if dump[key]:
            dump[key] = _port(dump[key])
    for key in PROGRAM_KEYS:
        if file := getattr(device, key):
            dump[key] = f"{file} ({file.digest[:12]})"
    dump["ports"] = {uart: _port(port) for uart, port in dump["ports"].items()}
    return _flat(dump)


def _port(dump: dict[str, Any]) -> dict[str, Any]:
    return {"kind": dump["kind"], **dump["options"]}


def _flat(value: dict[str, Any]) -> dict[str, str]:
    return dict(_leaves(value, ""))


def _leaves(value: dict[str, Any], prefix: str) -> Iterator[tuple[str, str]]:
    for key, item in value.items():
        if isinstance(item, dict):
            yield from _leaves(item, f"{prefix}{key}.")
        else:
            text = json.dumps(item)
            yield prefix + key, text if len(text) <= _SHOWN else f"{text[:_BEGINNING]}... ({_digest(text)})"


def changed_keys(old: dict[str, Any], new: dict[str, Any]) -> tuple[str, ...]:
    """Lines for the keys in which two configurations as they are dumped differ, ``key: old -> new``."""
    return _why(_flat(old), _flat(new))


def _why(old: dict[str, str], new: dict[str, str]) -> tuple[str, ...]:
    return tuple(
        f"{key}: {old.get(key, 'unset')} -> {new.get(key, 'unset')}"
        for key in old | new
        if old.get(key) != new.get(key)
    )
