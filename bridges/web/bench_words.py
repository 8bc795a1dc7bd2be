"""A bench as pages are told of it: its devices with their verbs and fields, and what can be asked."""

import asyncio
from collections.abc import Iterable, Sequence
from secrets import token_hex
from typing import cast

from bridges.web.outbox import LongText
from bridges.web.page_rows import (
    BenchRow,
    DeviceRow,
    OperationRow,
    ParameterRow,
    RoleName,
    VerbRow,
)
from hil.vocab.desk_protocol import Description, Desk, DeviceInfo, Source
from hil.vocab.faults import FAULT_KINDS, TARGETS
from hil.vocab.operation import Operation
from hil.vocab.parameters import Parameter
from hil.vocab.verbs import Role, Verb
from hil.wire.json_text import json_text

PROTOCOL = 1
SLICE = 4
"""Devices between two turns of others: some 2 ms."""
SOCKETS_OWN = ("capture", "debug", "part", "samples", "unwatch", "watch")
"""Operations of the control socket's own kind: here `watch` and `open` are in their place, and benches lead
runs together over zenoh."""


def is_offered(operation: Operation) -> bool:
    """True if a page can ask for an operation."""
    return operation.answer is not None and operation.name not in SOCKETS_OWN


class BenchWords:
    """Description of a bench, made once for all its pages. ``version``: of the page's files;
    ``message_bytes``: limit of a page's messages."""

    def __init__(self, desk: Desk, version: str, message_bytes: int) -> None:
        self._desk, self._version = desk, version
        self._door = {"instance": token_hex(8), "message_bytes": message_bytes}
        self._text: Sequence[bytes] | None = None
        self._changes = 0
        self._making = asyncio.Lock()

    def changed(self) -> None:
        """Note that devices were added, removed or exchanged."""
        self._text, self._changes = None, self._changes + 1

    async def told(self, key: str, source: Source) -> LongText:
        """Message to a page of this user. ``key``: what it is, hello or changed."""
        user = json_text({"user": source.name, "role": _role(source.role)})
        shared = await self._shared()
        return LongText((f'{{"{key}":{user[:-1]},'.encode(), *shared), sum(map(len, shared)))

    async def _shared(self) -> Sequence[bytes]:
        """Rest of the message, which all users are told alike."""
        async with self._making:
            while self._text is None:
                changes, text = self._changes, await self._made()
                if changes == self._changes:
                    self._text = text
            return self._text

    async def _made(self) -> Sequence[bytes]:
        """Make it in slices: a large bench's boards do not wait for it."""
        here = self._desk.describe()
        devices: list[bytes] = []
        for number, (name, device) in enumerate(list(here.devices.items()), 1):
            devices.append(("," * (number > 1) + json_text(_device(name, device))).encode())
            if number % SLICE == 0:
                await asyncio.sleep(0)
        rest = json_text({**_bench(here, self._version), **self._door})
        return (f'{rest[1:-1]},"devices":['.encode(), *devices, b"]}}")


def _bench(here: Description, version: str) -> BenchRow:
    return {
        "protocol": PROTOCOL,
        "version": version,
        "bench": here.bench,
        "segments": [
            {"name": name, "framing": line.framing.name, "baud": line.baud, "format": line.line_format.name}
            for name, line in here.segments.items()
        ],
        "buses": list(here.buses),
        "ports": list(here.ports),
        "operations": {name: _operation(each) for name, each in here.operations.items() if is_offered(each)},
        "fault_kinds": [
            {
                "name": kind.name,
                "title": kind.title,
                "layer": kind.layer,
                "target": kind.target,
                "on": TARGETS[kind.target],
                "summary": kind.about,
                "is_once": kind.is_once,
                "parameters": _parameters(kind.parameters),
            }
            for kind in FAULT_KINDS.values()
        ],
    }


def _device(name: str, device: DeviceInfo) -> DeviceRow:
    return {
        "name": name,
        "profile": device.profile,
        "is_real": device.is_real,
        "is_seen": device.is_seen,
        "verbs": {verb.name: _verb(verb) for verb in device.verbs.values()},
        "fields": [
            {
                "name": field.name,
                "type": field.type,
                "unit": field.unit,
                "meaning": field.meaning,
                "is_settable": field.is_settable,
                "is_state": field.is_state,
            }
            for field in device.fields.values()
        ],
        "inputs": dict(device.inputs),
    }


def _role(role: Role) -> RoleName:
    return cast(RoleName, role.name.lower())


def _verb(verb: Verb) -> VerbRow:
    return {
        "summary": verb.about,
        "role": _role(verb.role),
        "parameters": _parameters(verb.parameters),
    }


def _operation(operation: Operation) -> OperationRow:
    return {
        "target": operation.target.name.lower(),
        "target_summary": operation.target.value[1],
        "summary": operation.about,
        "role": _role(operation.role),
        "takes_time": operation.takes_time,
        "parameters": _parameters(operation.parameters),
    }


def _parameters(parameters: Iterable[Parameter]) -> list[ParameterRow]:
    return [_parameter(each) for each in parameters]


def _parameter(parameter: Parameter) -> ParameterRow:
    told: ParameterRow = {
        "name": parameter.name,
        "summary": parameter.about,
        "unit": parameter.unit,
        "type": "whole" if parameter.is_whole else "number",
        "default": parameter.default,
        "is_optional": parameter.is_optional,
        "text": parameter.described(),
    }
    if parameter.form:
        told["type"], told["form"] = "other", parameter.form.about
    elif parameter.choices:
        told["type"], told["choices"] = "choice", list(parameter.choices)
    elif parameter.is_text:
        told["type"], told["maximum"] = "text", parameter.maximum
    else:
        told["minimum"], told["maximum"] = parameter.minimum, parameter.maximum
        told["limits"] = parameter.limits
    return told
