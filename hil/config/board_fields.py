"""Fields of a board's own, as ``profile.yaml`` describes them: name, unit, range, what they start with."""

import re
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from hil.config.document import Finding, KeyPath
from hil.config.explain import no_such, shown
from hil.core.axis_kind import NoRoom
from hil.core.fields import FIELDS
from hil.core.kinds import FIELDS_LAW, kind_of
from hil.vocab.axis_plan import ProcessorPlan
from hil.vocab.own_fields import MOST_FIELDS, OwnField
from hil.vocab.parameters import plain

if TYPE_CHECKING:
    from hil.config.own_field_model import FieldInfo

FIELDS_KEY = "fields"
_NAME = re.compile(r"[a-z][A-Za-z0-9_]{0,31}")
_WORDS = {
    *("and", "or", "not", "has", "abs", "max", "min"),
    *("as", "assert", "async", "await", "break", "class", "continue", "def", "del", "elif", "else", "except"),
    *("finally", "for", "from", "global", "if", "import", "in", "is", "lambda", "nonlocal", "pass", "raise"),
    *("return", "try", "while", "with", "yield"),
}
"""Words of conditions (``hil.net.condition``), and of Python, whose tests read a field as an attribute."""


def with_fields_axis(value: Any) -> Any:
    """Complete a profile's mapping that has fields, and neither a motor nor a processor: with the axis that
    has them."""
    if not isinstance(value, dict) or not value.get(FIELDS_KEY) or value.get("processor") is not None:
        return value
    return value if value.get("axes") or value.get("law") else {"law": FIELDS_LAW} | value


def made_fields(
    fields: Mapping[str, "FieldInfo"], starts: Mapping[str, float] | None = None
) -> tuple[OwnField, ...]:
    """Make the fields of a board, in their order. ``starts``: first values that a device has instead."""
    given = starts or {}
    return tuple(info.made(name, given.get(name)) for name, info in fields.items())


def field_findings(
    fields: Mapping[str, "FieldInfo"], law: str, processor: ProcessorPlan | None
) -> Iterator[Finding]:
    """Findings about fields, beside those of the model. ``law``: of the axis that has them."""
    for name, info in fields.items():
        path = (FIELDS_KEY, name)
        if not _NAME.fullmatch(name):
            remedy = "write a small letter, and up to 31 more of letters, digits and _"
            yield Finding(path, f"{shown(name)} is no name of a field", remedy, at_key=True)
        elif name in FIELDS:
            message = f"{name} is the name of a field of hil's: {FIELDS[name].meaning}"
            yield Finding(path, message, "give the field another name", at_key=True)
        elif name in _WORDS:
            yield Finding(
                path,
                f"{name} is a word of conditions, or of Python",
                "give the field another name",
                at_key=True,
            )
        yield from _value_findings(name, info)
    if len(fields) > MOST_FIELDS:
        message = f"{len(fields)} fields are too many"
        yield Finding((FIELDS_KEY,), message, f"a board has {MOST_FIELDS} at most", at_key=True)
        return
    try:
        kind_of(law, processor, made_fields(fields))
    except NoRoom as error:
        what = fields[error.name].type
        remedy = f"the axis leaves room for {error.room} of type {what}; move others to a second board"
        yield Finding((FIELDS_KEY, error.name), "there is no room for this field", remedy, at_key=True)
    except KeyError:
        return  # there is no such law, which is said elsewhere


def start_findings(path: KeyPath, given: Any, fields: Mapping[str, "FieldInfo"]) -> Iterator[Finding]:
    """Findings about the first values that a device at a path gives to its board's fields."""
    for name, value in given.items() if isinstance(given, dict) else ():
        if name not in fields:
            yield no_such((*path, FIELDS_KEY, name), "field of this board's own", str(name), fields)
        elif isinstance(value, bool) or not isinstance(value, int | float):
            continue  # the model says so
        elif problem := fields[name].made(name).refusal(value):
            own = fields[name].made(name)
            remedy = f"write {plain(own.low)} to {plain(own.high)}{', a whole number' * own.is_whole}"
            yield Finding((*path, FIELDS_KEY, name), problem, remedy)


def _value_findings(name: str, info: "FieldInfo") -> Iterator[Finding]:
    own = info.made(name)
    if info.type == "switch" and not {info.minimum, info.maximum} <= {None, 0.0, 1.0}:
        yield Finding((FIELDS_KEY, name, "type"), "a switch is 0 or 1", "leave minimum and maximum out")
    elif own.low >= own.high:
        message = f"the range is empty: {plain(own.low)} to {plain(own.high)}"
        yield Finding((FIELDS_KEY, name), message, "write a maximum above the minimum", at_key=True)
    elif problem := own.refusal(own.start):
        key = "value" if "value" in info.model_fields_set else None
        path = (FIELDS_KEY, name, key) if key else (FIELDS_KEY, name)
        yield Finding(path, f"its first value: {problem}", "write `value:` within the range", not key)
