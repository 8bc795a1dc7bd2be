"""Conditions on numbers that have names, as in ``position_deg > 89 and loop_on == 1``: comparisons with
``and``, and ``or`` between those."""

import operator
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import NamedTuple

from hil.vocab.near_words import meant

_OPERATORS: dict[str, Callable[[float, float], bool]] = {
    "<=": operator.le,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
}
_SIGNS = " ".join(_OPERATORS)
_WORD = re.compile(
    r"\s*(?:(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?P<unit>[^\W\d]\w*)?"
    r"|(?P<name>[^\W\d]\w*)|(?P<operator>[<>=!]+)|(?P<other>\S))"
)
_EXAMPLE = "write it as in `position_deg > 89`"


class ConditionError(ValueError):
    """Error of a condition: ``str(error)`` says what is wrong with it, and what to write."""


class Comparison(NamedTuple):
    """Comparison of two operands, each a field's name or a number."""

    left: str | float
    sign: str
    right: str | float

    def holds(self, values: Mapping[str, float | None]) -> bool:
        """True if it does; never with a field that is not told."""
        left, right = (each if isinstance(each, float) else values[each] for each in (self.left, self.right))
        return left is not None and right is not None and _OPERATORS[self.sign](left, right)


class Condition(NamedTuple):
    """Condition that holds if all comparisons of one of its groups do."""

    groups: tuple[tuple[Comparison, ...], ...]

    @property
    def fields(self) -> tuple[str, ...]:
        """Names of its fields, each once, in their order."""
        both = (side for group in self.groups for each in group for side in (each.left, each.right))
        return tuple(dict.fromkeys(side for side in both if isinstance(side, str)))

    def holds(self, values: Mapping[str, float | None]) -> bool:
        """True if it does with these values of its fields."""
        return any(all(each.holds(values) for each in group) for group in self.groups)

    def check(self, device: str, known: Collection[str]) -> None:
        """Check its fields. Raises ConditionError: the device has one of them not."""
        for name in self.fields:
            if name not in known:
                raise ConditionError(f"{device} has no field {name!r}; {meant(name, known)}")


def parse_condition(text: str) -> Condition:
    """Read a condition; ``and`` binds more than ``or``.

    Raises:
        ConditionError: it is none.
    """
    words = list(_words(text))
    groups: list[list[Comparison]] = [[]]
    while True:
        groups[-1].append(_comparison(words))
        if not words:
            break
        _, joint = words.pop(0)
        if joint not in ("and", "or"):
            raise ConditionError(f"{joint!r} is too much: write `and` or `or` between two comparisons")
        if joint == "or":
            groups.append([])
    condition = Condition(tuple(map(tuple, groups)))
    if not condition.fields:
        raise ConditionError(f"{text!r} has no field; {_EXAMPLE}")
    return condition


def _comparison(words: list[tuple[str, str]]) -> Comparison:
    left = _operand(words, f"a field or a number is missing; {_EXAMPLE}")
    kind, sign = words.pop(0) if words else ("", "")
    if kind != "operator":
        there = f", not {sign!r}" if sign else ""
        raise ConditionError(f"write one of {_SIGNS} behind {_spelled(left)}{there}")
    return Comparison(left, sign, _operand(words, f"behind {sign} a field or a number is missing"))


def _operand(words: list[tuple[str, str]], missing: str) -> str | float:
    kind, word = words.pop(0) if words else ("", "")
    if kind not in ("name", "number"):
        there = f" where {word!r} stands" if word else ""
        raise ConditionError(missing.replace(" is missing", f" is missing{there}", 1))
    return float(word) if kind == "number" else word


def _spelled(operand: str | float) -> str:
    return operand if isinstance(operand, str) else f"{operand:g}"


def _words(text: str) -> Iterator[tuple[str, str]]:
    """Words of a condition, each with its kind."""
    for found in _WORD.finditer(text):
        kind, word = str(found.lastgroup), found[0].strip()
        if kind == "unit":
            raise ConditionError(f"write {found['number']}, not {word}: a field's name says its unit")
        if kind == "other":
            raise ConditionError(f"{word!r} means nothing here; {_EXAMPLE}")
        if kind == "operator" and word not in _OPERATORS:
            near = {"=": "==", "=>": ">=", "=<": "<=", "<>": "!=", "===": "=="}.get(word)
            raise ConditionError(f"write {near or f'one of {_SIGNS}'}, not {word}")
        if kind == "name" and word.lower() in ("and", "or", "not"):
            if word.lower() == "not":
                raise ConditionError("`not` means nothing here: write the opposite comparison")
            yield "joint", word.lower()
            continue
        yield kind, word
