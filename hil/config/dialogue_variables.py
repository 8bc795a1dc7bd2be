"""Variables of a table: the fields that they are, and what is wrong with one of them."""

from collections.abc import Iterator
from typing import Any

from hil.config.dialogue_model import DialogueInfo, ParameterInfo, VariableInfo
from hil.config.document import Finding, KeyPath
from hil.config.explain import suggestion
from hil.instruments.instrument_table import Variable, field_name
from hil.instruments.patterns import CHOICE, NUMBER, SWITCH, TEXT
from hil.instruments.scpi_status import ERROR
from hil.instruments.table_expressions import FUNCTIONS
from hil.vocab.own_fields import MOST
from hil.vocab.parameters import plain

UNITS = frozenset(
    {
        "V",
        "mV",
        "uV",
        "kV",
        "A",
        "mA",
        "uA",
        "W",
        "mW",
        "kW",
        "ohm",
        "kohm",
        "Hz",
        "kHz",
        "MHz",
        "degC",
        "degF",
    }
    | {
        "K",
        "s",
        "ms",
        "us",
        "min",
        "h",
        "m",
        "mm",
        "um",
        "deg",
        "rpm",
        "N",
        "Nm",
        "Pa",
        "kPa",
        "bar",
        "g",
        "kg",
    }
)
"""Units that a name ends in, where it ends in one."""
RESERVED = frozenset({ERROR, "and", "or", "not", "if", "else", *FUNCTIONS})


def field_keys(info: DialogueInfo) -> dict[str, dict[str, Any]]:
    """Fields that the variables are, as ``fields`` of a ``profile.yaml`` has them."""
    fields: dict[str, dict[str, Any]] = {}
    for name, each in info.variables.items():
        if each.type == TEXT:
            continue
        made = made_variable(name, each)
        keys: dict[str, Any] = {
            "about": each.about,
            "unit": each.unit,
            "input": each.input,
            "value": made.start,
        }
        if each.type == CHOICE:
            words = ", ".join(f"{index} {word}" for index, word in enumerate(made.words))
            keys |= {"about": f"{each.about}: {words}", "type": "whole"}
            keys |= {"minimum": 0.0, "maximum": max(1.0, made.high)}
        else:
            keys |= {"type": each.type, "minimum": each.minimum, "maximum": each.maximum}
        for number in made.numbers:
            said = f"{keys['about']}, number {number}" if number else keys["about"]
            fields[field_name(name, number)] = keys | {"about": said}
    return fields


def names_of(info: DialogueInfo) -> dict[str, str]:
    """Name of the variable that a field is, by the field's."""
    return {
        field_name(name, number): name
        for name, each in info.variables.items()
        for number in made_variable(name, each).numbers
    }


def made_parameter(name: str, info: ParameterInfo) -> Variable:
    """Make a value that a command takes."""
    words = tuple(info.choices or ()) if info.type == CHOICE else ()
    most = {SWITCH: 1.0, CHOICE: float(len(words) - 1)}.get(info.type, MOST)
    low = (0.0 if info.type in (SWITCH, CHOICE) else -MOST) if info.minimum is None else info.minimum
    high = most if info.maximum is None else info.maximum
    return Variable(name, info.type, info.unit, low=low, high=high, words=words)


def made_variable(name: str, info: VariableInfo) -> Variable:
    """Make a variable, without what it follows or is computed from."""
    made = made_parameter(name, info)
    start: float | str = info.value
    if info.type == TEXT:
        start = "" if "value" not in info.model_fields_set else str(info.value)
    elif isinstance(start, str):
        start = float(made.words.index(start)) if start in made.words else 0.0
    return Variable(
        name,
        made.kind,
        made.unit,
        info.many or 0,
        made.low,
        made.high,
        info.step or 0.0,
        made.words,
        start,
        info.longest,
        info.kept,
        info.input,
    )


def variable_findings(path: KeyPath, name: str, info: ParameterInfo) -> Iterator[Finding]:
    """Findings about a variable, or a value that a command takes, beside those of fields."""
    if name in RESERVED:
        yield Finding(path, f"{name} is a word of expressions", "give it another name", at_key=True)
    if info.type == CHOICE:
        words = info.choices or []
        if not words:
            yield Finding(path, "a choice needs its words", "write choices: [OFF, LOW, HIGH]", at_key=True)
        elif len(set(words)) < len(words) or "" in words:
            yield Finding(
                (*path, "choices"), "two words are alike, or one is empty", "give each value a word"
            )
    elif info.choices is not None:
        yield Finding((*path, "choices"), f"a {info.type} has no choices", "write type: choice", at_key=True)
    for key in ("minimum", "maximum", "unit") if info.type in (CHOICE, TEXT, SWITCH) else ():
        if key in info.model_fields_set:
            yield Finding((*path, key), f"a {info.type} has no {key}", "leave this key out", at_key=True)
    if info.minimum is not None and info.maximum is not None and info.minimum > info.maximum:
        message = f"the limits are reversed: {plain(info.minimum)} to {plain(info.maximum)}"
        yield Finding((*path, "minimum"), message, "write the smaller one as minimum")
    ending = name.rpartition("_")[2]
    if "_" in name and ending in UNITS and info.unit and info.unit != ending:
        message = f"the name says {ending}, and this {info.unit}"
        yield Finding((*path, "unit"), message, f"write unit: {ending}, or another name")
    if isinstance(info, VariableInfo):
        yield from _variable_findings(path, info)


def _variable_findings(path: KeyPath, info: VariableInfo) -> Iterator[Finding]:
    ways = [key for key in ("computed", "follows") if getattr(info, key) is not None] + ["input"] * info.input
    if len(ways) > 1:
        message = f"{ways[0]} and {ways[1]} both say its value"
        yield Finding((*path, ways[1]), message, "leave one of them out", at_key=True)
    if info.kept and ways:
        yield Finding((*path, "kept"), f"{ways[0]} says its value", "leave kept out", at_key=True)
    if (
        info.type == CHOICE
        and info.choices
        and "value" in info.model_fields_set
        and info.value not in info.choices
    ):
        remedy = suggestion(str(info.value), info.choices)
        yield Finding((*path, "value"), f"{info.value!r} is none of the choices", remedy)
    elif info.type not in (TEXT, CHOICE) and isinstance(info.value, str):
        yield Finding((*path, "value"), f"{info.value!r} is no number", f"a {info.type} has a number")
    if info.type == TEXT and (info.follows or info.many):
        key = "follows" if info.follows else "many"
        yield Finding((*path, key), f"a text has no {key}", "leave this key out", at_key=True)
    if info.follows and info.type != NUMBER:
        yield Finding((*path, "type"), f"a {info.type} follows nothing", "write type: number")
    if info.follows and (info.follows.time_constant_s is None) == (info.follows.rate_per_s is None):
        remedy = "write time_constant_s: or rate_per_s:, one of the two"
        yield Finding((*path, "follows"), "nothing says how fast it follows, or two keys do", remedy)
    if info.step is not None and info.type != NUMBER:
        yield Finding((*path, "step"), f"a {info.type} has no step", "leave this key out", at_key=True)
