"""Reloads of a bench in its input log: what was removed, what began, and the configuration from then on."""

import base64
import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from hil.sim.input_reading import taken, text, texts, time_ns, whole
from hil.sim.inputs import InputLogError

Memories = Mapping[str, Mapping[str, bytes]]
"""Non-volatile sections of each device, by name."""


@dataclass(frozen=True)
class Begun:
    """Device that begins at a reload. ``seed``: of its first axis; ``opened_ns``: when its group was made;
    ``memory``: its sections as it begins."""

    device: str
    seed: int
    opened_ns: int
    memory: Mapping[str, bytes]


@dataclass(frozen=True)
class Reloaded:
    """Reload. ``removed``: devices that ended, those that start again among them."""

    at_ns: int
    config: Mapping[str, Any]
    removed: tuple[str, ...]
    begun: tuple[Begun, ...]

    @property
    def names(self) -> frozenset[str]:
        """Devices of which another one is there from now on, or none."""
        return frozenset({*self.removed, *(each.device for each in self.begun)})


def memories_text(memories: Memories) -> dict[str, dict[str, str]]:
    """Convert memories for the log."""
    return {
        device: {name: base64.b64encode(data).decode() for name, data in sections.items()}
        for device, sections in memories.items()
    }


def memories_of(value: object) -> dict[str, dict[str, bytes]]:
    """Convert memories back. Raises InputLogError: they are none."""
    if not isinstance(value, dict):
        raise InputLogError("nvm has to be an object")
    memories = {}
    for device, sections in value.items():
        if not isinstance(sections, dict):
            raise InputLogError(f"nvm of {device[:40]!r} is no object")
        memories[device] = {section: _memory(content) for section, content in sections.items()}
    return memories


def _memory(content: object) -> bytes:
    with suppress(ValueError):
        if isinstance(content, str):
            return base64.b64decode(content, validate=True)
    raise InputLogError("the content of a memory has to be base64")


def encode_reload(reload: Reloaded) -> str:
    """Encode the line of a reload, without its end."""
    begun = [[each.device, each.seed, each.opened_ns] for each in reload.begun]
    values = {"at_ns": reload.at_ns, "reload": reload.config, "removed": reload.removed, "begun": begun}
    nvm = memories_text({each.device: each.memory for each in reload.begun})
    return json.dumps(values | {"nvm": nvm}, separators=(",", ":"))


def decode_reload(values: dict[str, Any]) -> Reloaded:
    """Decode a line's values, the reverse of ``encode_reload``. Raises InputLogError: they are none."""
    config, begun = values.get("reload"), values.get("begun")
    memories = memories_of(values.get("nvm"))
    if not isinstance(config, dict) or not isinstance(begun, list):
        raise InputLogError("a reload has to have reload, an object, and begun, rows")
    rows = []
    for row in begun:
        if not isinstance(row, list) or len(row) != 3:
            raise InputLogError("begun: write rows of 3")
        of = dict(zip(("device", "seed", "opened_ns"), row, strict=True))
        device, seed = taken(of, "device", text), taken(of, "seed", whole)
        rows.append(Begun(device, seed, taken(of, "opened_ns", time_ns), memories.get(device, {})))
    removed = taken(values, "removed", texts)
    return Reloaded(taken(values, "at_ns", time_ns), config, removed, tuple(rows))
