"""Writes what the page knows of the door: ``make web-types``.

Rows come from ``bridges/web/page_rows.py``, operations from the one table, their answers from
``hil/net/answers.py``. ``bridges/web/tests/test_web_types.py`` holds the written file fresh.
"""

import json
import re
from collections.abc import Iterable
from inspect import getdoc
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, NotRequired, get_args, get_origin, get_type_hints, is_typeddict

import write_web_words
from bridges.web import page_rows
from bridges.web.bench_words import is_offered
from bridges.web.page_rows import RoleName
from bridges.web.web_messages import SAMPLES, SAMPLES_HEAD, TERMINAL, TERMINAL_HEAD, TIMED, TIMED_HEAD
from bridges.web.web_watches import KINDS
from hil.net.answers import ABSENT
from hil.operations import table
from hil.operations.table import OPERATIONS
from hil.vocab.operation import Operation
from hil.vocab.parameters import Parameter

FILE = Path(__file__).parent / "web/src/model/door.ts"
_HEAD = """/** Types of what the door tells and takes. Written by `make web-types` from page_rows.py of the
 * door, the table of operations and hil/net/answers.py: change those. */
"""
_PLAIN: dict[Any, str] = {
    str: "string",
    int: "number",
    float: "number",
    bool: "boolean",
    NoneType: "null",
    list: "unknown[]",
    dict: "Record<string, unknown>",
}
_FORMS = (
    (table.TEXT, "string"),
    (table.WHOLE, "number"),
    (table.NAMES, "string[]"),
    (table.FLAG, "boolean"),
    (table.OBJECT, "Record<string, unknown>"),
    (table.WHICH, 'number | "all"'),
    (table.FRAMES, "string[]"),
    (table.HEX, "string"),
)
"""Types of forms; of others unknown."""
_NAME = re.compile(r"[A-Za-z_]\w*")


def written() -> str:
    """Text of the file."""
    parts = [
        _HEAD,
        f"export const SAMPLES = {SAMPLES};\nexport const SAMPLES_HEAD = {SAMPLES_HEAD.size};",
        f"export const TERMINAL = {TERMINAL};\nexport const TERMINAL_HEAD = {TERMINAL_HEAD.size};\n"
        f"export const TIMED = {TIMED};\nexport const TIMED_HEAD = {TIMED_HEAD.size};\n",
        f"export type Role = {_words(get_args(RoleName))};\nexport type WatchKind = {_words(KINDS)};\n",
    ]
    rows = [row for row in vars(page_rows).values() if is_typeddict(row)]
    parts += map(_interface, rows)
    parts.append(
        "/** Operations by name: what each is given, and what it answers. */\nexport interface Operations {"
    )
    parts += [_operation(each) for each in OPERATIONS.values() if is_offered(each)]
    return "\n".join([*parts, "}\n"])


def _interface(row: Any) -> str:
    lines = (getdoc(row) or "").split("\n")
    about = "\n * ".join(line for line in lines if line)
    hints = get_type_hints(row, include_extras=True)
    members = "".join(f"  {_member(name, kind)};\n" for name, kind in hints.items())
    return f"/** {about} */\nexport interface {row.__name__} {{\n{members}}}\n"


def _member(name: str, kind: Any) -> str:
    if get_origin(kind) is NotRequired:
        return f"{name}?: {_type(get_args(kind)[0])}"
    return f"{name}: {_type(kind)}"


def _type(kind: Any) -> str:
    if kind == RoleName:
        return "Role"
    if get_origin(kind) is Literal:
        return _words(get_args(kind))
    if isinstance(kind, UnionType):
        return " | ".join(map(_type, get_args(kind)))
    if get_origin(kind) is list:
        return f"{_type(get_args(kind)[0])}[]"
    if get_origin(kind) is dict:
        return f"Record<string, {_type(get_args(kind)[1])}>"
    return _PLAIN.get(kind) or str(kind.__name__)


def _words(words: Iterable[str]) -> str:
    return " | ".join(f'"{word}"' for word in words)


def _operation(operation: Operation) -> str:
    given = _object(_given(each) for each in operation.parameters)
    answer = _answer(operation.answer)
    return f"  /** {operation.about} */\n  {operation.name}: {{ given: {given}; answer: {answer} }};"


def _object(members: Iterable[str]) -> str:
    listed = "; ".join(members)
    return f"{{ {listed} }}" if listed else "Record<string, never>"


def _given(parameter: Parameter) -> str:
    kind = "number"
    if parameter.form:
        kind = next((text for form, text in _FORMS if form is parameter.form), "unknown")
    elif parameter.choices:
        kind = _words(parameter.choices)
    elif parameter.is_text:
        kind = "string"
    mark = "?" if parameter.is_optional or parameter.default is not None else ""
    return f"{parameter.name}{mark}: {kind}"


def _answer(form: Any) -> str:
    if isinstance(form, tuple):
        return " | ".join(dict.fromkeys(map(_answer, form)))
    if isinstance(form, list):
        item = _answer(form[0])
        return f"({item})[]" if " | " in item else f"{item}[]"
    if isinstance(form, dict):
        if str in form:
            return f"Record<string, {_answer(form[str])}>"
        return _object(_told(key, each) for key, each in form.items())
    if isinstance(form, type):
        return _PLAIN[form]
    return "null" if form is None else json.dumps(form)


def _told(key: str, form: Any) -> str:
    name = key if _NAME.fullmatch(key) else json.dumps(key)
    return f"{name}?: undefined" if form is ABSENT else f"{name}: {_answer(form)}"


if __name__ == "__main__":
    FILE.write_text(written())
    write_web_words.FILE.write_text(write_web_words.written())
