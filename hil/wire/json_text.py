"""JSON: the one place that decides what is let in from outside; and what goes out, in pieces if it is long.

Beside what JSON forbids, nothing comes in that the rest of the program would have to fear: text that is no
UTF-8, ``NaN`` and ``Infinity``, numbers that no float or 64-bit integer holds, nesting without end, halves of
surrogate pairs.
"""

import json
from collections.abc import Iterator, Mapping
from math import isfinite
from typing import Any, NoReturn

DEEPEST = 32
"""Maximum nesting of objects and arrays; the deepest of the program's own is a log's header, with 10."""
LEAST, MOST = -(1 << 63), (1 << 64) - 1
"""Range of integers. Seeds have all 64 bits."""
ITEMS = 8
"""Items of a list in a piece: rows of devices take some 20 us each."""
_LONGEST_INTEGER = len(str(LEAST))
_LONG_NUMBERS = (b"0" * 19, b"e000", b"E000", b"e+000", b"E+000")
"""Patterns of numbers that need a closer look, with all digits made 0."""
_ZEROED = bytes.maketrans(b"123456789", b"000000000")
_SURROGATES = (b"\\ud", b"\\uD")
_CONTAINERS = (dict, list)
_TOO_DEEP = f"more than {DEEPEST} objects and arrays in each other"


class JsonError(ValueError):
    """Error of a text that is no JSON that is let in: ``str(error)`` says why."""


def read_json(text: str | bytes) -> Any:
    """Parse a JSON text. The caller bounds its length.

    Raises:
        JsonError: the text is no JSON that is let in.
    """
    try:
        data = text.encode() if isinstance(text, str) else text
        decoded = text if isinstance(text, str) else text.decode()
        if _has(data.translate(_ZEROED), _LONG_NUMBERS):
            value = json.loads(decoded, parse_constant=_no_constant, parse_int=_integer, parse_float=_finite)
        else:
            value = json.loads(decoded, parse_constant=_no_constant)
        if _has(data, _SURROGATES):
            json.dumps(value, ensure_ascii=False).encode()
    except RecursionError:
        raise JsonError(_TOO_DEEP) from None
    except UnicodeDecodeError as error:
        raise JsonError(f"byte {error.start} is no UTF-8") from None
    except UnicodeEncodeError:
        raise JsonError("half of a surrogate pair is no character") from None
    except json.JSONDecodeError as error:
        raise JsonError(f"{error.msg}, at character {error.pos + 1}") from None
    if data.count(b"[") + data.count(b"{") > DEEPEST:
        _check_depth(value)
    return value


def _has(data: bytes, marks: tuple[bytes, ...]) -> bool:
    return any(mark in data for mark in marks)


def _check_depth(value: Any) -> None:
    """Check the depth a level at a time, so that nesting is no recursion."""
    level = [value] if isinstance(value, _CONTAINERS) else []
    for _ in range(DEEPEST):
        children = (each.values() if isinstance(each, dict) else each for each in level)
        level = [child for some in children for child in some if isinstance(child, _CONTAINERS)]
    if level:
        raise JsonError(_TOO_DEEP)


def _no_constant(name: str) -> NoReturn:
    raise JsonError(f"{name} is no number")


def _integer(digits: str) -> int:
    if len(digits) > _LONGEST_INTEGER or not LEAST <= int(digits) <= MOST:
        raise JsonError(f"{digits[:24]}{'...' * (len(digits) > 24)} is no number of 64 bits")
    return int(digits)


def _finite(digits: str) -> float:
    number = float(digits)
    if not isfinite(number):
        raise JsonError(f"{digits[:24]} is more than a float holds")
    return number


def json_pieces(content: Any) -> Iterator[bytes]:
    """Encode an object of which some members may be long lists, or iterators of items: each of them is
    encoded when it comes, so that long ones are never whole in memory."""
    if not isinstance(content, Mapping):
        yield json_text(content).encode()
        return
    opening = "{"
    for name, value in content.items():
        yield f"{opening}{json.dumps(str(name))}:".encode()
        opening = ","
        if isinstance(value, list | tuple) and len(value) > ITEMS:
            for at in range(0, len(value), ITEMS):
                some = json_text(value[at : at + ITEMS])[1:-1]
                yield f"{',' if at else '['}{some}".encode()
            yield b"]"
        elif isinstance(value, Iterator):
            separator = "["
            for item in value:
                yield f"{separator}{json_text(item)}".encode()
                separator = ","
            yield b"]" if separator == "," else b"[]"
        else:
            yield json_text(value).encode()
    yield b"}" if content else b"{}"


def json_text(content: Any) -> str:
    """Encode as JSON. What is no number there, as NaN, is null."""
    try:
        return json.dumps(content, allow_nan=False, separators=(",", ":"))
    except ValueError:
        return json.dumps(_without_nan(content), allow_nan=False, separators=(",", ":"))


def _without_nan(content: Any) -> Any:
    if isinstance(content, float):
        return content if isfinite(content) else None
    if isinstance(content, Mapping):
        return {name: _without_nan(value) for name, value in content.items()}
    if isinstance(content, list | tuple):
        return [_without_nan(value) for value in content]
    return content
