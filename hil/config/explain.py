"""pydantic's errors in the words of a configuration file's author."""

import json
import re
from collections.abc import Callable, Collection, Iterable
from types import NoneType
from typing import Annotated, Any, get_args, get_origin

from pydantic import (
    BaseModel,
    ConfigDict,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    SerializerFunctionWrapHandler,
    ValidationError,
    model_serializer,
    model_validator,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, ErrorDetails
from pydantic_core.core_schema import ErrorType, no_info_plain_validator_function

from hil.config.document import Document, Finding, KeyPath
from hil.config.shape_words import for_keys, for_list
from hil.config.yaml_words import missing_space
from hil.vocab.address import NAME_PATTERN
from hil.vocab.near_words import did_you_mean, meant, nearest_or_longer
from hil.vocab.typed_numbers import number_problem, typed_number, unit_in


class LazyModel:
    """Metadata of an annotation whose model ``load`` imports: errors, their places and what the JSON Schema
    takes are as if the model stood there."""

    def __init__(self, load: Callable[[], type[BaseModel]]) -> None:
        self.load = load

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return no_info_plain_validator_function(lambda value: self.load().model_validate(value))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        model = self.load()
        model.model_rebuild()
        return handler(model.__pydantic_core_schema__)


class StrictModel(BaseModel):
    """Frozen model that refuses unknown keys and values of another type."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)


class _OrNull:
    """Mark of a key of a ``DefaultsModel`` at which null means the default."""

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"anyOf": [handler(schema), {"type": "null"}]}


OR_NULL = _OrNull()


class DefaultsModel(StrictModel):
    """Model with keys whose default depends on nothing, but which some of its kinds must not have: null is as
    good as the key left out, and that is what a key left out is dumped as."""

    @model_validator(mode="before")
    @classmethod
    def _without_nulls(cls, value: Any) -> Any:
        if not isinstance(value, dict):
            return value
        return {key: each for key, each in value.items() if each is not None or not cls._is_marked(key)}

    @model_serializer(mode="wrap")
    def _as_given(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        dumped: dict[str, Any] = handler(self)
        left_out = {key for key in dumped if self._is_marked(key) and key not in self.model_fields_set}
        return dumped | dict.fromkeys(left_out)

    @classmethod
    def _is_marked(cls, key: str) -> bool:
        field = cls.model_fields.get(key)
        return field is not None and OR_NULL in field.metadata


_BOUNDS = {
    "greater_than_equal": ("too small", "write {ge} or more"),
    "greater_than": ("too small", "write more than {gt}"),
    "less_than_equal": ("too large", "write {le} or less"),
    "less_than": ("too large", "write less than {lt}"),
}
_NUMBERS = {
    "int_type": "a whole number",
    "int_parsing": "a whole number",
    "int_from_float": "a whole number",
    "int_parsing_size": "a whole number",
    "finite_number": "a finite number",
    "float_type": "a number",
    "float_parsing": "a number",
}
_MAPPINGS = {"model_type", "model_attributes_type", "dict_type", "mapping_type"}
_TEXTS = {"string_type", "path_type"}
_LISTS = {"list_type", "tuple_type", "set_type", "frozen_set_type", "iterable_type"}
_OTHER_WORDS = {
    "fault": ("kind", "type", "name"),
    "target": ("at", "on", "device", "axis", "port", "where"),
    "profile": ("board", "type", "kind", "model"),
    "bench": ("name",),
    "run": ("name",),
    "stations": ("devices", "nodes"),
    "asks": ("command", "pattern", "receives"),
}
"""Words that people write for a key that is missing then."""
_ITEMS = re.compile(r"[\w./-]+(?:, *[\w./-]+)*")
"""Names without the brackets of a list around them."""
_NO_ITEMS = {"none", "None", "no", "off", "all"}
_OF_PYDANTIC = frozenset(get_args(ErrorType))
"""Kinds of errors with a text of pydantic's; other kinds come with a text of a model's own."""


def unknown_key(path: KeyPath, known: Iterable[str], present: Collection[str]) -> Finding:
    """Finding of a key that nothing reads. ``present``: the keys beside it, which cannot be the one meant."""
    known = list(known)
    free = [key for key in known if key not in present]
    remedy = suggestion(str(path[-1]), free or known) if known else "remove it"
    if spaced := missing_space(str(path[-1])):
        remedy = f'write a space after the colon: "{spaced}"'
    return Finding(path, "unknown key", remedy, at_key=True)


def suggestion(word: str, known: Collection[str]) -> str:
    """Question for the nearest known word, else all of them."""
    if near := did_you_mean(*nearest_or_longer(word, known)):
        return near
    return f"known are: {', '.join(sorted(known))}" if known else "there are none"


def not_allowed(path: KeyPath, value: object, problem: str) -> Finding:
    """Finding of a value, from an error text that has what is wrong and, behind a semicolon, the remedy."""
    what, _, remedy = problem.partition("; ")
    return (
        Finding(path, what, remedy) if remedy else Finding(path, f"{shown(value)} is not allowed here", what)
    )


def no_such(path: KeyPath, what: str, name: str, known: Collection[str]) -> Finding:
    """Finding of a name that does not exist."""
    remedy = meant(name, known, f"known are: {', '.join(sorted(known)) or 'none'}")
    return Finding(path, f"there is no {what} {shown(name)}", remedy)


def findings_of(
    error: ValidationError, model: type[BaseModel], prefix: KeyPath, document: Document
) -> list[Finding]:
    """Findings of every error, with key paths; ``prefix`` is where the model's data stand in the document."""
    findings: list[Finding] = []
    missing: list[Finding] = []
    for detail in error.errors(include_url=False):
        path = (*prefix, *detail["loc"], *detail.get("ctx", {}).get("at", ()))
        if detail["type"] == "missing":
            present = _keys_in(document, path[:-1])
            if "<<" in present:
                continue  # what was to be merged in has it
            remedy = f'add the line "{path[-1]}: ..."'
            if other := next((each for each in _OTHER_WORDS.get(str(path[-1]), ()) if each in present), None):
                remedy = did_you_mean(str(path[-1]))
                findings.append(Finding((*path[:-1], other), "unknown key", remedy, at_key=True))
                continue
            missing.append(Finding(path, "this key is missing", remedy))
        elif detail["type"] == "extra_forbidden":
            known = _keys_of(_model_at(model, detail["loc"][:-1]))
            findings.append(unknown_key(path, known, _keys_in(document, path[:-1])))
        elif path[-1:] == ("[key]",):
            findings.append(_explain(detail, path[:-1], document, at_key=True))
        else:
            wanted = _annotation_at(model, detail["loc"]) if detail["type"] in _MAPPINGS else None
            findings.append(_explain(detail, document.known(path), document, wanted=wanted))
    # A mistyped key is also a missing one: the first is enough to say.
    remedies = {(f.path[:-1], f.remedy) for f in findings}
    unspaced = {(*f.path[:-1], str(f.path[-1]).partition(":")[0]) for f in findings if f.path}
    return findings + [
        f
        for f in missing
        if (f.path[:-1], did_you_mean(str(f.path[-1]))) not in remedies and f.path not in unspaced
    ]


def _explain(
    detail: ErrorDetails, path: KeyPath, document: Document, at_key: bool = False, wanted: object = None
) -> Finding:
    message, remedy = words_of(detail, document.raw.get(path), wanted)
    return Finding(path, message, remedy, at_key)


def words_of(detail: ErrorDetails, raw: str | None, wanted: object = None) -> tuple[str, str]:
    """Message and remedy for an error of pydantic; ``raw``: the value as it was written; ``wanted``: the
    annotation of what is meant, where keys are."""
    kind, value, context = detail["type"], detail["input"], detail.get("ctx", {})
    if "remedy" in context:
        return detail["msg"], str(context["remedy"])
    if kind in _BOUNDS:
        size, remedy = _BOUNDS[kind]
        return f"{shown(value)} is {size}", remedy.format_map(context)
    if kind in _TEXTS:
        if isinstance(value, bool | int | float):
            written = raw if raw is not None else str(value)
            return (
                f"YAML takes this for {shown(value)}; text is wanted",
                f'write it in quotes: "{written}"',
            )
        return f"text is wanted here, not {shown(value)}", "write one word or text in quotes"
    if kind in _NUMBERS:
        quoted = isinstance(value, str) and re.fullmatch(r"[-+]?[0-9.]+", value)
        wanted = f"write {_NUMBERS[kind]}"
        if isinstance(value, str) and isinstance(typed_number(value.strip()), str):
            what, wanted = number_problem(
                value, unit_in(str((detail.get("loc") or [""])[-1])), _NUMBERS[kind]
            )
            if "is no number" not in what:
                return what, wanted
        remedy = "write it without quotes" if quoted else wanted
        return f"{_NUMBERS[kind]} is wanted here, not {shown(value)}", remedy
    if kind in _MAPPINGS:
        if isinstance(value, str) and (spaced := missing_space(value)):
            return "there is no space after the colon", f'write "{spaced}"'
        remedy = for_keys(value, wanted)
        return f"keys are wanted here, not {shown(value)}", remedy
    if kind in ("bool_type", "bool_parsing"):
        return f"true or false is wanted here, not {shown(value)}", "write true or false"
    if kind in ("literal_error", "enum"):
        return f"{shown(value)} is none of the choices", f"write {context.get('expected', 'one of them')}"
    if kind == "string_pattern_mismatch" and context.get("pattern") == NAME_PATTERN:
        remedy = "a name is a letter a-z and up to 31 more of a-z, 0-9, _ and -"
        plain = re.sub(r"[^a-z0-9_-]+", "_", str(value).strip(" '\"“”„‘’").lower())[:32].strip("_")
        if re.match(NAME_PATTERN, plain):
            remedy = f"write {plain}: {remedy}"
        if spaced := missing_space(str(value)):
            remedy = f'write a space after the colon: "{spaced}"'
        return f"{shown(value)} is not a name", remedy
    if kind == "string_pattern_mismatch":
        return f"{shown(value)} has the wrong form", f"the form is {context.get('pattern')}"
    if kind in _LISTS:
        is_item = isinstance(value, str) and _ITEMS.fullmatch(value) and value not in _NO_ITEMS
        remedy = f"write [{value}]" if is_item else "write [] for none, or leave the key out"
        remedy = for_list(value) or remedy
        return f"a list is wanted here, not {shown(value)}", remedy
    if kind in ("too_short", "string_too_short"):
        return "there is nothing in it", "add one at least" if kind == "too_short" else "write what it is"
    if kind == "too_long":
        many = f"{context.get('actual_length')}, and at most {context.get('max_length')} can be"
        return f"there are {many}", "take some out"
    if kind == "string_too_long":
        return f"{shown(value)} is too long", f"write at most {context.get('max_length')} characters"
    if kind in ("value_error", "assertion_error"):  # a check of a model of ours, or of a plug-in's
        return detail["msg"].partition(", ")[2] or detail["msg"], "see the key in the configuration reference"
    if isinstance(kind, str) and kind not in _OF_PYDANTIC:
        return detail["msg"], "see the key in the configuration reference"
    return f"{shown(value)} does not fit here", "see the key in the configuration reference"


def shown(value: object) -> str:
    """Format a value for a message: short, on one line."""
    if value is None:
        return "nothing"
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list):
        return "a list"
    if isinstance(value, int) and not isinstance(value, bool):
        return f"the number {value}"
    text = json.dumps(value, default=ascii, ensure_ascii=not str(value).isprintable())
    return text if len(text) <= 60 else text[:56] + "..."


def _keys_in(document: Document, path: KeyPath) -> Collection[str]:
    value: Any = document.value
    try:
        for part in path:
            value = value[part]
    except (LookupError, TypeError):  # a check has completed it
        return ()
    return value if isinstance(value, dict) else ()


def _keys_of(model: type[BaseModel] | None) -> list[str]:
    return [] if model is None else [field.alias or name for name, field in model.model_fields.items()]


def _model_at(model: type[BaseModel], loc: tuple[str | int, ...]) -> type[BaseModel] | None:
    annotation = _annotation_at(model, loc)
    return annotation if isinstance(annotation, type) and issubclass(annotation, BaseModel) else None


def _annotation_at(model: type[BaseModel], loc: tuple[str | int, ...]) -> Any:
    annotation: Any = model
    for part in loc:
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            field = annotation.model_fields.get(str(part))
            annotation = None if field is None else _needed(field.annotation)
        else:
            annotation = _needed(next(iter(get_args(annotation)[-1:]), None))
    return annotation


def _needed(annotation: Any) -> Any:
    """Type beside ``None`` in an annotation, where that is one thing."""
    if get_origin(annotation) is Annotated:
        annotation, *metadata = get_args(annotation)
        if later := next((each for each in metadata if isinstance(each, LazyModel)), None):
            return later.load()
    others = [each for each in get_args(annotation) if each is not NoneType]
    return _needed(others[0]) if len(others) == 1 and NoneType in get_args(annotation) else annotation
