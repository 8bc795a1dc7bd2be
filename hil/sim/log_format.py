"""Table of the input log's lines and their fields, of which the reference is written; tests hold it against
what is written and read."""

import re
from collections.abc import Iterator
from dataclasses import fields
from typing import Any, NamedTuple, get_type_hints

from hil.sim.input_reading import LEFT_OUT, LOGGED_NAMES
from hil.sim.inputs import KINDS, LOG_FORMAT, LOG_VERSION, OLD_VERSIONS
from hil.sim.log_checks import ENDS
from hil.vocab.path import PathPiece
from hil.wire.step_dir import Train


class LogField(NamedTuple):
    """Field of a line. ``since``: first version that has it."""

    name: str
    type: str
    meaning: str
    is_optional: bool = False
    since: int = 1


_AT = LogField("at_ns", "integer", "simulated time in ns; for an input, when it took effect")
_DEVICE = LogField("device", "text", "address of what it is of: a device, an axis, a tap, a segment")
HEADER = (
    LogField("format", "text", f"`{LOG_FORMAT}`"),
    LogField("version", "integer", f"{', '.join(map(str, OLD_VERSIONS))} or {LOG_VERSION}"),
    LogField("program", "text", "what wrote it"),
    LogField("begun", "text or null", "the wall's date of time 0, UTC; null: there was none", since=3),
    LogField("speed", "number", "simulated seconds in one of the wall's", since=3),
    LogField("config", "object", "the configuration, without ports"),
    LogField("nvm", "object", "each device's memory at the start: sections in base64"),
    LogField("ports", "object", "kind of each port of a daemon's bench, by its label", True, 3),
    LogField("forked_from", "text", "of a fork: the recording that it went on from, and when", True, 3),
)
SENT = (
    _AT,
    _DEVICE,
    LogField("sent", "hexadecimal text", "bytes that the device sent"),
    LogField("state", "integer or null", "CRC-32 of its axes' snapshots then; null: it was not kept"),
    LogField("port", "text", "name of the UART or card; left out: the first UART", is_optional=True),
)
RELOAD = (
    LogField("at_ns", "integer", "simulated time in ns of the reload", since=3),
    LogField("reload", "object", "the configuration from then on, without ports", since=3),
    LogField("removed", "list of texts", "devices that ended, also those that start again", since=3),
    LogField(
        "begun", "rows", "devices that began: name, seed of the first axis, time in ns of its making", since=3
    ),
    LogField("nvm", "object", "their memories as they began: sections in base64", since=3),
)
EVENT = (
    LogField("at_ns", "integer", "simulated time in ns", since=3),
    LogField("event", "text", "its kind: verbs, typed, faults, runs, refusals, clients, …", since=3),
    LogField("number", "integer", "of two lines with one number the later counts", since=3),
    LogField("to_ns", "integer", "time of the last that it stands for", since=3),
    LogField("of", "text", "address that it is of; empty: the bench", since=3),
    LogField("who", "text", "who asked: a user, a door, `bench`; empty in a bundle", since=3),
    LogField("text", "text", "what it was, in words", since=3),
    LogField("count", "integer", "how many it stands for", since=3),
)
CHECK = (
    LogField("at_ns", "integer", "the bench's time, in ns, when this was written", since=3),
    LogField("check", "integer", "CRC-32 of all bytes of the text before this line", since=3),
    LogField("lines", "integer", "number of lines before this one", since=3),
    LogField("inputs", "integer", "how many of them are inputs", since=3),
    LogField("faults", "object", "faults begun, by kind; `stopped`: boards that the guard stopped", True, 3),
    LogField("wall", "text", "the wall's date then, UTC", True, 3),
)
END = (
    LogField("end", "true", "the log ends here", since=2),
    LogField("why", "text", f"one of {', '.join(f'`{why}`' for why in ENDS)}", since=3),
    *CHECK,
)
LINES = {
    "header, the first line": HEADER,
    "what a device sent": SENT,
    "reload": RELOAD,
    "event": EVENT,
    "check": CHECK,
    "end, the last line": END,
}
"""Lines that are no inputs, each with its fields."""
_TYPES: dict[Any, str] = {
    int: "integer",
    float: "number",
    str: "text",
    bool: "true or false",
    bytes: "hexadecimal text",
    int | None: "integer or null",
    tuple[tuple[int, int], ...]: "rows of 2 integers",
    tuple[tuple[int, str], ...]: "rows of integer, text",
    tuple[tuple[str, float | str], ...]: "rows of name, value",
    tuple[tuple[str, int | None, str], ...]: "rows of text, integer or null, hexadecimal text",
    tuple[str, ...]: "list of texts",
    tuple[PathPiece, ...]: "rows of integer and up to 4 numbers",
    Train: "rows of integer, pin and up to 3 integers",
}


def input_lines() -> Iterator[tuple[str, str, list[LogField]]]:
    """Inputs in the order of the code: the name, the meaning, and the fields beside ``at_ns``, ``device`` and
    ``input``."""
    for name, kind in KINDS.items():
        types = get_type_hints(kind)
        found = [
            LogField(
                LOGGED_NAMES.get((kind, each.name), each.name),
                _TYPES[types[each.name]],
                "",
                (kind, each.name) in LEFT_OUT,
            )
            for each in fields(kind)
        ]
        yield name, re.sub(r"\s+", " ", (kind.__doc__ or "").replace("``", "`")), found


def log_reference() -> str:
    """Write the section of the reference."""
    parts = [
        "## Input log",
        f"Lines of the log of a run, version {LOG_VERSION}, each a JSON object;"
        " [the page on its format](log-format.md) says how they belong together.",
    ]
    for line, table in LINES.items():
        parts += [f"### Line: {line}", "| field | type | since version | meaning |\n|---|---|---|---|"]
        parts[-1] += "".join(
            f"\n| `{each.name}` | {each.type} | {each.since} | {each.meaning}"
            f"{'; may be left out' if each.is_optional else ''} |"
            for each in table
        )
    parts += [
        "### Line: an input",
        "`at_ns`, `device`, `input` (the name below) and its fields; those in brackets may be left out.",
        "| input | fields | meaning |\n|---|---|---|",
    ]
    for name, meaning, found in input_lines():
        cells = [f"`{each.name}` {each.type}" for each in found]
        shown = ", ".join(
            f"[{cell}]" if each.is_optional else cell for cell, each in zip(cells, found, strict=True)
        )
        parts[-1] += f"\n| `{name}` | {shown or '-'} | {meaning} |"
    return "\n\n".join(parts) + "\n"
