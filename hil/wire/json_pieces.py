"""JSON of what may be long, piece by piece, so that between two of them others have their turn."""

import json
import math
from collections.abc import Iterator, Mapping
from typing import Any

ITEMS = 8
"""Items of a list in a piece: rows of devices take some 20 us each."""


def json_pieces(content: Any) -> Iterator[bytes]:
    """Encode an object of which some members may be long lists."""
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
        else:
            yield json_text(value).encode()
    yield b"}" if content else b"{}"


def json_text(content: Any) -> str:
    """Encode as JSON. What is no number there, as NaN, is null."""
    try:
        return json.dumps(content, allow_nan=False, separators=(",", ":"))
    except ValueError:
        return json.dumps(_finite(content), allow_nan=False, separators=(",", ":"))


def _finite(content: Any) -> Any:
    if isinstance(content, float):
        return content if math.isfinite(content) else None
    if isinstance(content, Mapping):
        return {name: _finite(value) for name, value in content.items()}
    if isinstance(content, list | tuple):
        return [_finite(value) for value in content]
    return content
