"""What a reload would do: which devices go on, which start anew, and because of which keys."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

from hil.config.model import BenchConfig, DeviceConfig


@dataclass(frozen=True)
class Change:
    """What happens to one device, or to the whole core (``device`` None) and so to every device.

    ``why`` has a line for each key that differs, ``key: old -> new``; empty for keep.
    """

    device: str | None
    action: Literal["keep", "restart", "add", "remove"]
    why: tuple[str, ...] = ()


def diff(old: BenchConfig, new: BenchConfig) -> list[Change]:
    """The changes in the order in which to make them: the core, removals, then the new file's order."""
    changes: list[Change] = []
    core = _why(
        _flat(old.model_dump(mode="json", by_alias=True, exclude={"devices"})),
        _flat(new.model_dump(mode="json", by_alias=True, exclude={"devices"})),
    )
    if core:
        changes.append(Change(None, "restart", core))
    changes += [
        Change(name, "remove", ("it is no longer in the configuration",))
        for name in old.devices
        if name not in new.devices
    ]
    for name, device in new.devices.items():
        if name not in old.devices:
            changes.append(Change(name, "add", ("it is new in the configuration",)))
        else:
            why = _why(_keys(old.devices[name]), _keys(device))
            changes.append(Change(name, "restart" if why else "keep", why))
    return changes


def _keys(device: DeviceConfig) -> dict[str, str]:
    dump = device.model_dump(mode="json")
    for key in ("port", "network"):
        if dump[key]:
            dump[key] = {"kind": dump[key]["kind"], **dump[key]["options"]}
    return _flat(dump)


def _flat(value: dict[str, Any]) -> dict[str, str]:
    return dict(_leaves(value, ""))


def _leaves(value: dict[str, Any], prefix: str) -> Iterator[tuple[str, str]]:
    for key, item in value.items():
        if isinstance(item, dict):
            yield from _leaves(item, f"{prefix}{key}.")
        else:
            yield prefix + key, json.dumps(item)


def _why(old: dict[str, str], new: dict[str, str]) -> tuple[str, ...]:
    return tuple(
        f"{key}: {old.get(key, 'unset')} -> {new.get(key, 'unset')}"
        for key in old | new
        if old.get(key) != new.get(key)
    )
