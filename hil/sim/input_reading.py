"""Reader of an input log's lines: each field is checked for its type.

Whether a bench can take such an input is another question (``hil.sim.input_check``).
"""

from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any, get_type_hints

from hil.sim.inputs import KINDS, Bytes, CommitDone, Do, Follow, InputLogError, LineOpened, Logged
from hil.vocab.path import PathPiece
from hil.vocab.time import SimTimeNs
from hil.wire.json_text import JsonError, read_json
from hil.wire.step_dir import Edges, Train

LATEST_NS = 1 << 62
"""Maximum time: a bench in real time stops there, after 146 years."""
_INT64 = range(-(1 << 63), 1 << 63)


class _Wrong(Exception):
    """Error of a value that is not what it has to be: ``str(error)`` says what that is."""


def whole(value: Any, within: range = _INT64) -> int:
    """Read an integer, by default of 64 bits."""
    if isinstance(value, bool) or not isinstance(value, int) or value not in within:
        raise _Wrong(f"write a whole number from {within.start} to {within.stop - 1}")
    return value


def time_ns(value: Any) -> int:
    return whole(value, range(LATEST_NS + 1))


def number(value: Any) -> float:
    """Read a number, integers too; ``read_json`` lets in none that is not finite."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise _Wrong("write a number")
    return value


def text(value: Any) -> str:
    if not isinstance(value, str):
        raise _Wrong("write a text")
    return value


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise _Wrong("write true or false")
    return value


def hexadecimal(value: Any) -> bytes:
    try:
        return bytes.fromhex(text(value))
    except ValueError:
        raise _Wrong("write hexadecimal digits") from None


def _digits(value: Any) -> str:
    hexadecimal(value)
    return text(value)


def _whole_or_none(value: Any) -> int | None:
    return None if value is None else whole(value)


def _value(value: Any) -> float | str:
    return value if isinstance(value, str) else number(value)


def _rows(*columns: Callable[[Any], Any], least: int = 0) -> Callable[[Any], tuple[tuple[Any, ...], ...]]:
    """Make a reader of rows; the columns after the first ``least`` may be left out, 0: all are needed."""

    def read(value: Any) -> tuple[tuple[Any, ...], ...]:
        if not isinstance(value, list) or not all(isinstance(row, list) for row in value):
            raise _Wrong("write rows")
        if any(not (least or len(columns)) <= len(row) <= len(columns) for row in value):
            raise _Wrong(f"write rows of {len(columns)}")
        return tuple(tuple(column(each) for column, each in zip(columns, row, strict=False)) for row in value)

    return read


def texts(value: Any) -> tuple[str, ...]:
    if not isinstance(value, list):
        raise _Wrong("write a list of texts")
    return tuple(map(text, value))


_PIECES = _rows(whole, number, number, number, number, least=2)
_EDGES = _rows(whole, text, whole, whole, whole, least=1)
_READERS: Mapping[Any, Callable[[Any], Any]] = {
    int: whole,
    float: number,
    str: text,
    bool: _flag,
    bytes: hexadecimal,
    int | None: _whole_or_none,
    tuple[tuple[int, int], ...]: _rows(whole, whole),
    tuple[tuple[int, str], ...]: _rows(whole, _digits),
    tuple[tuple[str, float | str], ...]: _rows(text, _value),
    tuple[tuple[str, int | None, str], ...]: _rows(text, _whole_or_none, _digits),
    tuple[str, ...]: texts,
    tuple[PathPiece, ...]: lambda value: tuple(PathPiece(*row) for row in _PIECES(value)),
    Train: lambda value: tuple(Edges(*row) for row in _EDGES(value)),
}
"""Readers by the type of an input's field."""
_TYPES = {kind: get_type_hints(kind) for kind in KINDS.values()}
LOGGED_NAMES = {(Do, "at_ns"): "later_ns"}
"""Fields that have another name in the log: an input's own ``at_ns`` is when it took effect."""
LEFT_OUT = {
    (Bytes, "port"): "",
    (Bytes, "client_format"): "",
    (LineOpened, "port"): "",
    (Do, "at_ns"): None,
    (CommitDone, "at_once"): False,
    (Follow, "is_joined"): False,
}
"""Values of fields that are left out of the log."""


def read_field(kind: type, name: str, value: Any) -> Any:
    """Read a value from outside for a field of a kind of input.

    Raises:
        InputLogError: it is not what the field has to be.
    """
    return taken({name: value}, name, _READERS[_TYPES[kind][name]])


def read_line(line: str | bytes) -> dict[str, Any]:
    """Read a line of a log as an object.

    Raises:
        InputLogError: the line is no object.
    """
    try:
        values = read_json(line)
    except JsonError:
        raise InputLogError("this line is damaged: it is no JSON") from None
    if not isinstance(values, dict):
        raise InputLogError("this line is damaged: it is no object")
    return values


def taken(values: dict[str, Any], name: str, read: Callable[[Any], Any]) -> Any:
    """Take a field out of its line.

    Raises:
        InputLogError: it is missing, or not what it has to be.
    """
    if name not in values:
        raise InputLogError(f"this line is damaged: it has no {name}")
    try:
        return read(values.pop(name))
    except _Wrong as error:
        raise InputLogError(f"{name}: {error}") from None


def decode(values: dict[str, Any]) -> Logged:
    """Decode a line's values, the reverse of ``inputs.encode_line``; takes its fields out.

    Raises:
        InputLogError: they are none of an input.
    """
    at_ns, device = taken(values, "at_ns", time_ns), taken(values, "device", text)
    name = taken(values, "input", text)
    if name not in KINDS:
        raise InputLogError(f"there is no input {name[:40]!r}; there are {', '.join(KINDS)}")
    kind = KINDS[name]
    read: dict[str, Any] = {}
    for field in fields(kind):
        logged = LOGGED_NAMES.get((kind, field.name), field.name)
        if logged not in values and (kind, field.name) in LEFT_OUT:
            read[field.name] = LEFT_OUT[kind, field.name]
        else:
            read[field.name] = taken(values, logged, _READERS[_TYPES[kind][field.name]])
    if values:
        raise InputLogError(f"an input {name} has no {next(iter(values))[:40]!r}")
    return Logged(SimTimeNs(at_ns), device, kind(**read))
