"""Messages of a page: requests in JSON, and bytes for a terminal. Pure.

What comes from a page is read here alone; nothing else of the bridge sees a text that was not checked.
"""

import struct
from collections.abc import Mapping
from typing import Any, NamedTuple

from hil.vocab.desk_protocol import Done
from hil.vocab.parameters import Form
from hil.vocab.verbs import OF_TEXTS, VerbRefused
from hil.wire.json_text import JsonError, json_text, read_json

SAMPLES, TERMINAL, TIMED = 1, 2, 3
"""Kinds of binary messages, their first byte."""
MOST_ID = 1 << 53
"""Numbers of requests are below it: those that JavaScript has exactly."""
NAME_CHARACTERS = 256
MOST_FIELDS = 64
TERMINAL_HEAD = struct.Struct("<BBHI")
TIMED_HEAD = struct.Struct("<BBHId")
SAMPLES_HEAD = struct.Struct("<BBHIII")


class PageRequest(NamedTuple):
    """Request of a page: its number, what to do, and what is given with it. ``until_ms``: time of the door's
    clock by which it has to begin; None: any."""

    id: int
    do: str
    given: Mapping[str, Any]
    until_ms: float | None = None


class BadMessage(VerbRefused):
    """Refusal of a message that is no request. ``id``: its number, if it has one."""

    def __init__(self, why: str, id: int | None = None) -> None:
        super().__init__("bad_request", why)
        self.id = id


def read_request(text: str) -> PageRequest:
    """Read a request; ``given`` is checked by those who take it.

    Raises:
        BadMessage: it is none.
    """
    try:
        content = read_json(text)
    except JsonError as error:
        raise BadMessage(f"no JSON: {error}") from None
    if not isinstance(content, dict):
        raise BadMessage("write an object, with id and do")
    number = content.pop("id", None)
    if not isinstance(number, int) or isinstance(number, bool) or not 0 <= number < MOST_ID:
        raise BadMessage("id: write a whole number, 0 or more")
    if not isinstance(do := content.pop("do", None), str) or len(do) > NAME_CHARACTERS:
        raise BadMessage("do: write what to do, as ask or watch", number)
    until_ms = content.pop("until_ms", None)
    if until_ms is not None and not _is_number(until_ms):
        raise BadMessage("until_ms: write a number, a time of the watch clock", number)
    return PageRequest(number, do, content, until_ms)


def read_terminal(data: bytes) -> tuple[int, bytes]:
    """Read a terminal's number and what is typed at it.

    Raises:
        BadMessage: it is no such message.
    """
    if len(data) < TERMINAL_HEAD.size or data[0] != TERMINAL:
        raise BadMessage(
            "a binary message is for a terminal: 2, 0, 0, 0, its number in four bytes, its bytes"
        )
    return TERMINAL_HEAD.unpack_from(data)[3], data[TERMINAL_HEAD.size :]


def terminal_message(number: int, data: bytes) -> bytes:
    """Encode what a terminal says."""
    return TERMINAL_HEAD.pack(TERMINAL, 0, 0, number) + data


def timed_message(number: int, at_ns: int, data: bytes) -> bytes:
    """Encode what a terminal says, with the simulated time at which hil had it."""
    return TIMED_HEAD.pack(TIMED, 0, 0, number, at_ns / 1e9) + data


def samples_head(fields: int, watch: int, lost: int, rows: int) -> bytes:
    """Encode the head of a block of samples. ``lost``: of all of the watch so far."""
    return SAMPLES_HEAD.pack(SAMPLES, fields, 0, watch, lost & 0xFFFFFFFF, rows)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


NAME = Form(
    f"a text of at most {NAME_CHARACTERS} characters",
    lambda value: isinstance(value, str) and len(value) <= NAME_CHARACTERS,
)
TEXT = Form("a text", lambda value: isinstance(value, str))
OBJECT = Form("an object", lambda value: isinstance(value, dict))
NUMBER = Form("a number", _is_number)
FLAG = Form("true or false", lambda value: isinstance(value, bool))
WHOLE = Form("a whole number", lambda value: isinstance(value, int) and not isinstance(value, bool))
NAMES = Form(
    f"a list of 1 to {MOST_FIELDS} texts",
    lambda value: (
        isinstance(value, list)
        and 0 < len(value) <= MOST_FIELDS
        and all(isinstance(each, str) and len(each) <= NAME_CHARACTERS for each in value)
    ),
)


def taken(given: Mapping[str, Any], forms: Mapping[str, Form], defaults: Mapping[str, Any]) -> dict[str, Any]:
    """Check what a request gives against the forms of all that it may give.

    Raises:
        VerbRefused: something is missing, unknown, or of another form.
    """
    problems = [f"{name}: there is no such thing here" for name in given if name not in forms]
    for name, form in forms.items():
        if name not in given:
            problems += [] if name in defaults else [f"{name}: this one is missing"]
        elif not form.fits(given[name]):
            problems.append(f"{name}: write {form.about}")
    if problems:
        raise VerbRefused("bad_parameter", "; ".join(problems)[:4000])
    return {**defaults, **given}


def answer_text(number: int, answer: Any) -> str:
    """Encode the answer of a request."""
    if isinstance(answer, Done):
        answer = {"effective_at_ns": answer.effective_at_ns, **answer.answer}
    return json_text({"id": number, "answer": answer})


def refusal_text(number: int | None, refusal: VerbRefused) -> str:
    """Encode why a request was refused; with the problems of a text one by one, where it is about one."""
    error: dict[str, Any] = {"code": refusal.code, "message": str(refusal)}
    if refusal.code in OF_TEXTS:
        error["problems"] = [_problem(line) for line in str(refusal).splitlines()]
    return json_text({"id": number, "error": error})


def _problem(line: str) -> dict[str, Any]:
    """Split ``FILE:LINE:COLUMN: message``; line and column are 0 where there is none."""
    place, _, message = line.partition(": ")
    _, *numbers = place.rsplit(":", 2)
    if len(numbers) == 2 and all(each.isascii() and each.isdigit() for each in numbers):
        return {"line": int(numbers[0]), "column": int(numbers[1]), "message": message}
    return {"line": 0, "column": 0, "message": line}
