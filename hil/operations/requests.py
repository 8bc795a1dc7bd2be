"""A request at the control socket, read and checked before anything is done about it."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from hil.net.control_client import ControlError
from hil.sim.inputs import MAX_BURSTS
from hil.wire.json_text import JsonError, read_json
from hil.wire.step_dir import MAX_ROWS

NAME_CHARACTERS = 256
HEX_BYTES = 65536
"""Of one burst, or of what is typed at once."""
LIST_NAMES = 1024
_SHOWN = 80


class Kind(NamedTuple):
    """What an argument can be."""

    about: str
    fits: Callable[[Any], bool]


def _is_whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _is_name(value: Any) -> bool:
    return isinstance(value, str) and len(value) <= NAME_CHARACTERS


def _is_hex(value: Any) -> bool:
    if not isinstance(value, str) or len(value) > 2 * HEX_BYTES:
        return False
    try:
        bytes.fromhex(value)
    except ValueError:
        return False
    return True


def _are(value: Any, fits: Callable[[Any], bool]) -> bool:
    return isinstance(value, list) and all(map(fits, value))


def _is_edge(row: Any) -> bool:
    return (
        isinstance(row, list)
        and len(row) == 5
        and isinstance(row[1], str)
        and all(_is_whole(row[i]) for i in (0, 2, 3, 4))
    )


def _is_burst(row: Any) -> bool:
    return isinstance(row, list) and len(row) == 2 and _is_whole(row[0]) and _is_hex(row[1])


NAME = Kind(f"a text of at most {NAME_CHARACTERS} characters", _is_name)
NAMES = Kind("a list of texts", lambda value: _are(value, _is_name) and len(value) <= LIST_NAMES)
TEXT = Kind("a text", lambda value: isinstance(value, str))
HEX = Kind(f"hexadecimal digits of at most {HEX_BYTES} bytes", _is_hex)
WHOLE = Kind("a whole number", _is_whole)
NUMBER = Kind("a number", lambda value: _is_whole(value) or isinstance(value, float))
FLAG = Kind("true or false", lambda value: isinstance(value, bool))
OBJECT = Kind("an object", lambda value: isinstance(value, dict))
EDGES = Kind(
    f"at most {MAX_ROWS:,} rows of at_ns, pin, level, steps, duration_ns",
    lambda value: _are(value, _is_edge) and len(value) <= MAX_ROWS,
)
BURSTS = Kind(
    f"at most {MAX_BURSTS:,} rows of nanoseconds and hexadecimal digits of at most {HEX_BYTES} bytes",
    lambda value: _are(value, _is_burst) and len(value) <= MAX_BURSTS,
)


def read_request(line: bytes, verbs: Mapping[str, Mapping[str, Kind]]) -> tuple[str, dict[str, Any]]:
    """The verb of a request and its arguments, all there and of their kinds. ``verbs``: arguments by verb.

    Raises:
        ControlError: it is no such request.
    """
    try:
        request = read_json(line)
    except JsonError as error:
        raise ControlError(f"not a request: {error}; write a line of JSON") from None
    if not isinstance(request, dict) or not isinstance(name := request.pop("verb", None), str):
        raise ControlError('not a request: write an object with a verb, as in {"verb": "status"}')
    if name not in verbs:
        raise ControlError(f"there is no verb {_shown(name)}; verbs are {', '.join(verbs)}")
    kinds = verbs[name]
    if set(kinds) ^ set(request):
        raise ControlError(f"arguments of {name} are {', '.join(kinds) or 'none'}")
    for argument, kind in kinds.items():
        if not kind.fits(request[argument]):
            raise ControlError(f"{argument} of {name}: write {kind.about}")
    return name, request


def _shown(text: str) -> str:
    return repr(text[:_SHOWN]) + "..." * (len(text) > _SHOWN)
