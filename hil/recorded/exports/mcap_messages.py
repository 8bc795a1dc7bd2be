"""Messages of a recorded run for MCAP: topics, schemas and texts in JSON.

Topics are the keys of the zenoh bridge with a / in front, fields are called as the page calls them. Plotting
programs take numbers as they stand: so each field is a number, and one that JSON has not, as NaN, is left
out.
"""

import json
from collections.abc import Iterable, Sequence
from math import isfinite
from typing import Any

from hil.compose.decoded_item import DecodedItem
from hil.core.fields import described
from hil.recorded.exports.csv_table import NUMBERS
from hil.recorded.run_events import RunEvent
from hil.vocab.shown_text import printable
from hil.wire.pcapng import Interface, Record, RecordKind

Schema = dict[str, Any]
_NUMBER, _INTEGER, _TEXT, _TRUTH = ({"type": each} for each in ("number", "integer", "string", "boolean"))
_AT_NS = {"type": "integer", "description": "simulated ns since the run's start"}


def _schema(title: str, properties: Schema, required: Iterable[str] = ("at_ns",)) -> Schema:
    return {
        "title": title,
        "type": "object",
        "properties": {"at_ns": _AT_NS} | properties,
        "required": [*required],
    }


def axis_schema(names: Sequence[str]) -> Schema:
    """Schema of an axis with these fields, each with its unit and meaning."""
    properties = {}
    for name in names:
        field = described(name)
        about = f"{field.meaning} [{field.unit}]" if field.unit else field.meaning
        properties[name] = (_INTEGER if field.type.startswith("i") else _NUMBER) | {"description": about}
    return _schema("hil.state", properties)


class AxisTexts:
    """Encoder of samples of an axis with these fields."""

    def __init__(self, names: Sequence[str]) -> None:
        self._names = ("at_ns", *names)
        parts = [f'"{name}":{NUMBERS[described(name).type]}' for name in self._names]
        self._format = "{" + ",".join(parts) + "}"

    def texts(self, rows: Iterable[tuple[float, ...]], since_ns: int) -> list[tuple[int, bytes]]:
        """Encode rows, each with its time: ``since_ns`` and the row's own."""
        text_of = self._format
        return [
            (since_ns + int(row[0]), (text_of % row).encode() if isfinite(sum(row)) else self._finite(row))
            for row in rows
        ]

    def _finite(self, row: tuple[float, ...]) -> bytes:
        named = zip(self._names, row, strict=True)
        return json.dumps({name: value for name, value in named if isfinite(value)}).encode()


BYTES_SCHEMA = _schema(
    "hil.port", {"text": _TEXT, "data": _TEXT | {"description": "hexadecimal digits"}, "bytes": _INTEGER}
)
PACKET_SCHEMA = _schema(
    "hil.packet",
    {
        "kind": _TEXT | {"description": "packet, frame, bytes or event"},
        "from": _TEXT,
        "to": _TEXT,
        "text": _TEXT,
        "error": _TEXT,
        "data": _TEXT | {"description": "hexadecimal digits"},
        "can_id": _INTEGER,
    },
)
FAULT_SCHEMA = _schema(
    "hil.fault",
    {"at": _TEXT, "number": _INTEGER, "kind": _TEXT, "parameters": _TEXT, "is_on": _TRUTH},
)
INPUT_SCHEMA = _schema("hil.input", {"at": _TEXT, "input": _TEXT, "text": _TEXT})
VERB_SCHEMA = _schema(
    "hil.verb",
    {
        "at": _TEXT,
        "verb": _TEXT,
        "parameters": _TEXT,
        "refused": _TEXT | {"description": "why; empty: it was not"},
    },
)
LOG_SCHEMA: Schema = {
    "title": "foxglove.Log",
    "type": "object",
    "properties": {
        "timestamp": {
            "type": "object",
            "title": "time",
            "properties": {
                "sec": {"type": "integer", "minimum": 0},
                "nsec": {"type": "integer", "minimum": 0},
            },
        },
        "level": {"type": "integer", "description": "1 debug, 2 info, 3 warning, 4 error, 5 fatal"},
        "message": _TEXT,
        "name": _TEXT,
        "file": _TEXT,
        "line": {"type": "integer", "minimum": 0},
    },
    "required": ["timestamp", "level", "message", "name"],
}
INFO, WARNING, ERROR = 2, 3, 4


def bytes_text(record: Record) -> bytes:
    """Text of bytes at a port."""
    text = record.data.decode("ascii", "backslashreplace")
    return _json(record.at_ns, {"text": text, "data": record.data.hex(), "bytes": len(record.data)})


def port_topic(line: Interface, event: int) -> str:
    """Topic of bytes at a port: ``rx`` is what the board receives."""
    return f"/port/{line.name}/{'rx' if event == RecordKind.TX else 'tx'}"


def item_text(item: DecodedItem) -> bytes:
    """Text of a packet or frame."""
    told = item.as_dict(0)
    values = {name: told[name] for name in ("kind", "text", "data")} | {"error": told["error"] or ""}
    values |= {name: str(told[name]) for name in ("from", "to") if told[name] is not None}
    if item.can_id is not None:
        values["can_id"] = item.can_id
    return _json(item.at_ns, values)


def fault_text(event: RunEvent, kinds: dict[int, str]) -> bytes:
    """Text of a fault that begins or ends. ``kinds``: those that have begun, by number."""
    number = event.values["number"]
    if event.what == "inject":
        kinds[number] = event.values["kind"]
    parameters = json.dumps(dict(event.values.get("parameters", ())))
    is_on = event.what == "inject"
    kind = kinds.get(number, "")
    return _json(
        event.at_ns,
        {"at": event.at, "number": number, "kind": kind, "parameters": parameters, "is_on": is_on},
    )


def verb_text(event: RunEvent, refusal: str = "") -> bytes:
    """Text of a verb. ``refusal``: why it was refused."""
    parameters = json.dumps(dict(event.values["parameters"]))
    values = {"at": event.at, "verb": event.values["verb"], "parameters": parameters, "refused": refusal}
    return _json(event.at_ns, values)


def input_text(event: RunEvent) -> bytes:
    """Text of any other input."""
    return _json(event.at_ns, {"at": event.at, "input": event.what, "text": event.words()})


def log_text(at_ns: int, level: int, name: str, message: str) -> bytes:
    """Line of the log, for Foxglove's log panel; ``at_ns`` as of the message."""
    sec, nsec = divmod(at_ns, 10**9)
    values = {
        "timestamp": {"sec": sec, "nsec": nsec},
        "level": level,
        "message": printable(message),
        "name": name,
        "file": "",
        "line": 0,
    }
    return json.dumps(values).encode()


def _json(at_ns: int, values: dict[str, Any]) -> bytes:
    return json.dumps({"at_ns": at_ns} | values).encode()
