"""Remedies for values of another shape than their key has: a list for keys, keys for a list, one word for
several keys. They show how the value that was given is written there."""

import re
from collections.abc import Mapping
from typing import Any, get_args, get_origin

from pydantic import BaseModel

KEYS_BELOW = 'write "key: value" lines, indented below'
_EQUALS = re.compile(r"(?P<key>[A-Za-z_][\w.-]*) *= *\S")
_WORD = re.compile(r"[\w./+-]{1,40}")
_NAME = re.compile(r"[a-z][a-z0-9_-]*")
_COMPLETED = {"hardware"}
"""Keys that the checks add before a model reads them."""
_MANY = 12
"""Keys of a model that are too many to be listed."""
_MOST = 4
"""Names that are written out in a remedy."""


def for_keys(value: object, wanted: object) -> str:
    """Remedy for a value where keys are meant. ``wanted``: the annotation of a model or of names with values,
    or None if it is not known."""
    if isinstance(value, str) and (found := _EQUALS.match(value)):
        return f'write a colon in place of "=": "{found["key"]}: ..."'
    if isinstance(wanted, type) and issubclass(wanted, BaseModel):
        return KEYS_BELOW if isinstance(value, list) else _keys_of_model(value, wanted)
    if get_origin(wanted) not in (dict, Mapping):
        return KEYS_BELOW
    inner = _example(get_args(wanted)[1])
    if isinstance(value, list) and value and all(isinstance(each, dict) for each in value):
        return 'leave out the "- " before each name: names with colons stand here, not a list'
    words = value if isinstance(value, list) else [value]
    if words and all(isinstance(each, str) and _NAME.fullmatch(each) for each in words):
        some = ", ".join(f"{each}: {inner}" for each in words[:_MOST])
        return f"write {{{some}{', ...' if len(words) > _MOST else ''}}}"
    if isinstance(value, int | float) and not isinstance(value, bool):
        return f"write names before the values, as in {{m1: {value}}}"
    if value is None and inner.startswith("{") and len(inner) > 2:
        return f'write "NAME: {inner}" lines, indented below'
    return KEYS_BELOW


def for_list(value: object) -> str:
    """Remedy for a value where a list is meant; empty if it shows none."""
    if isinstance(value, dict):
        return 'begin it with "- ", as an item of a list, or write [ ] around it'
    if isinstance(value, str) and re.match(r"-[^\s-]", value):
        return f'write a space after the dash: "- {value[1:][:40]}"'
    return ""


def _keys_of_model(value: object, model: type[BaseModel]) -> str:
    needed = _needed(model)
    if len(needed) == 1 and not isinstance(value, bool | None) and _WORD.fullmatch(str(value)):
        return f"write {{{needed[0]}: {value}}}"
    if needed:
        return f"write {_example(model)}" + ("" if len(needed) > 1 else ", with what it is to be")
    known = [field.alias or name for name, field in model.model_fields.items()]
    if not known:
        return KEYS_BELOW
    begun = value.split()[0] if isinstance(value, str) and value.split() else ""
    first = begun if begun in known else known[0]
    if first != begun and len(known) >= _MANY:
        return KEYS_BELOW
    return f"write {{{first}: ...}}; its keys are {', '.join(known)}"


def _needed(model: type[BaseModel]) -> list[str]:
    fields = {field.alias or name: field for name, field in model.model_fields.items()}
    return [name for name, field in fields.items() if field.is_required() and name not in _COMPLETED]


def _example(annotation: object) -> str:
    """Value as it is written, of a model with its required keys."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return "{" + ", ".join(f"{name}: ..." for name in _needed(annotation)) + "}"
    inner: Any = get_args(annotation)
    if inner and get_origin(annotation) not in (dict, Mapping, list, tuple):
        return _example(inner[0])
    return "..."
