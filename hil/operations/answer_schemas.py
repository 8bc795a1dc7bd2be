"""JSON Schemas of answers (draft 2020-12), made of their forms in ``hil.net.answers``."""

from typing import Any

from hil.net.answers import ABSENT

_TYPES = {str: "string", int: "integer", float: "number", dict: "object", list: "array"}


def answer_schema(form: Any) -> dict[str, Any]:
    """Schema of a form; other keys of an object than those it names may be there."""
    if isinstance(form, tuple):
        return _one_of(form)
    if isinstance(form, list):
        return {"type": "array", "items": answer_schema(form[0])}
    if isinstance(form, dict):
        return _object(form)
    if isinstance(form, type):
        return {"type": _TYPES[form]}
    return {"type": "null"} if form is None else {"const": form}


def _one_of(forms: tuple[Any, ...]) -> dict[str, Any]:
    values = [form for form in forms if isinstance(form, str | int)]
    kinds = [answer_schema(form) for form in forms if not isinstance(form, str | int)]
    if set(map(type, values)) == {bool}:
        values, kinds = [], [*kinds, {"type": "boolean"}]
    if values and all(kind == {"type": "null"} for kind in kinds):
        return {"enum": [*values, *(None for _ in kinds)]}
    if not values and all(list(kind) == ["type"] for kind in kinds):
        types = [kind["type"] for kind in kinds]
        return {"type": types if len(types) > 1 else types[0]}
    return {"anyOf": [*kinds, *([{"enum": values}] if values else [])]}


def _object(form: dict[Any, Any]) -> dict[str, Any]:
    if str in form:
        return {"type": "object", "additionalProperties": answer_schema(form[str])}
    there = {key: answer_schema(each) for key, each in form.items() if each is not ABSENT}
    schema: dict[str, Any] = {"type": "object", "properties": there, "required": list(there)}
    if absent := [key for key, each in form.items() if each is ABSENT]:
        schema["not"] = {"anyOf": [{"required": [key]} for key in absent]}
    return schema
