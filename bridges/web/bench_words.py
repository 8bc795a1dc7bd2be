"""A bench as a page is told of it: its devices with their verbs and fields, and what can be asked."""

from collections.abc import Iterable
from typing import Any

from hil.vocab.desk_protocol import Description, DeviceInfo, Source
from hil.vocab.faults import FAULT_KINDS, TARGETS
from hil.vocab.operation import Operation
from hil.vocab.parameters import Parameter
from hil.vocab.verbs import Verb

PROTOCOL = 1
SOCKETS_OWN = ("capture", "part", "samples", "unwatch", "watch")
"""Operations of the control socket's own kind: here `watch` and `open` are in their place, and benches lead
runs together over zenoh."""


def is_offered(operation: Operation) -> bool:
    """True if a page can ask for an operation."""
    return operation.answer is not None and operation.name not in SOCKETS_OWN


def bench_told(here: Description, source: Source, version: str) -> dict[str, Any]:
    """Describe a bench to a page of this user. ``version``: of the page's files."""
    return {
        "protocol": PROTOCOL,
        "version": version,
        "bench": here.bench,
        "user": source.name,
        "role": source.role.name.lower(),
        "devices": [_device(name, device) for name, device in here.devices.items()],
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


def _device(name: str, device: DeviceInfo) -> dict[str, Any]:
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


def _verb(verb: Verb) -> dict[str, Any]:
    return {
        "summary": verb.about,
        "role": verb.role.name.lower(),
        "parameters": _parameters(verb.parameters),
    }


def _operation(operation: Operation) -> dict[str, Any]:
    return {
        "target": operation.target.name.lower(),
        "target_summary": operation.target.value[1],
        "summary": operation.about,
        "role": operation.role.name.lower(),
        "takes_time": operation.takes_time,
        "parameters": _parameters(operation.parameters),
    }


def _parameters(parameters: Iterable[Parameter]) -> list[dict[str, Any]]:
    return [_parameter(each) for each in parameters]


def _parameter(parameter: Parameter) -> dict[str, Any]:
    told: dict[str, Any] = {"name": parameter.name, "summary": parameter.about, "unit": parameter.unit}
    if parameter.form:
        told |= {"type": "other", "form": parameter.form.about}
    elif parameter.choices:
        told |= {"type": "choice", "choices": list(parameter.choices)}
    elif parameter.is_text:
        told |= {"type": "text", "maximum": parameter.maximum}
    else:
        bounds = {"minimum": parameter.minimum, "maximum": parameter.maximum, "limits": parameter.limits}
        told |= {"type": "whole" if parameter.is_whole else "number", **bounds}
    return told | {
        "default": parameter.default,
        "is_optional": parameter.is_optional,
        "text": parameter.described(),
    }
