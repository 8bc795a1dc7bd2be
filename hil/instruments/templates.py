"""Templates of answers: text with expressions in braces, as ``{voltage_V:.3f}`` or ``{output:OFF|ON}``."""

import math
from collections.abc import Callable
from typing import NamedTuple

from hil.instruments.patterns import PatternRefused, bytes_text, format_problem, pieces_of
from hil.instruments.scpi_status import ERROR
from hil.instruments.table_expressions import Expression, ExpressionRefused, Look, Value

MOST_LETTERS = 4096
"""Length of an answer; the rest is cut."""


class Blank(NamedTuple):
    """Place for an expression's value; ``write`` makes text of it."""

    expression: Expression
    write: Callable[[Value], str]


class Template(NamedTuple):
    """Template of an answer. ``takes_error``: a part of it is the next error of the queue."""

    text: str
    parts: tuple[str | Blank, ...]
    takes_error: bool = False

    def filled(self, look: Look) -> str:
        """Fill it in with the present values."""
        parts = (
            part if isinstance(part, str) else part.write(part.expression.value(look)) for part in self.parts
        )
        return "".join(parts)[:MOST_LETTERS]


def read_template(text: str, read: Callable[[str], Expression], *, is_hex: bool = False) -> Template:
    """Read a template. ``read``: reads an expression; ``is_hex``: what is between places is in base 16.

    Raises:
        PatternRefused, ExpressionRefused: it is none.
    """
    parts: list[str | Blank] = []
    takes_error = False
    for piece, is_place in pieces_of(text):
        if not is_place:
            parts.append(bytes_text(piece) if is_hex else piece)
            continue
        formula, _, form = piece.partition(":")
        expression = read(formula)
        takes_error |= ERROR in expression.names
        parts.append(Blank(expression, _writer(expression, form, is_hex)))
    return Template(text, tuple(parts), takes_error)


def _writer(expression: Expression, form: str, is_hex: bool) -> Callable[[Value], str]:
    if is_hex:
        return _bytes_writer(expression, form or "1")
    if "|" in form and not expression.is_text:
        words = form.split("|")
        return lambda value: words[max(0, min(len(words) - 1, int(_number(value))))]
    if expression.is_text:
        if form:
            raise PatternRefused(f"{expression.text} is a text: {form!r} is no format of it", "leave it out")
        return str
    if problem := format_problem(form):
        raise PatternRefused(f"{form!r} is no format", problem)
    if form[-1:] in ("d", "x", "X"):
        return lambda value: format(_whole(value), form)
    return lambda value: _plain(_number(value)) if not form else format(_number(value), form)


def _bytes_writer(expression: Expression, form: str) -> Callable[[Value], str]:
    count, is_low_first = form.removesuffix("le"), form.endswith("le")
    if expression.is_text or not (count.isdecimal() and 1 <= int(count) <= 8):
        raise PatternRefused(
            f"{expression.text}:{form} are no bytes", "write their number, as in {count:2}, or {count:2le}"
        )
    size = int(count)

    def written(value: Value) -> str:
        bits = _whole(value) & ((1 << 8 * size) - 1)
        return bits.to_bytes(size, "little" if is_low_first else "big").decode("latin-1")

    return written


def _number(value: Value) -> float:
    return value if isinstance(value, float | int) else 0.0


def _whole(value: Value) -> int:
    return math.floor(_number(value) + 0.5)


def _plain(value: float) -> str:
    """Number as people write it: whole ones without a point."""
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else f"{value:g}"


__all__ = ["Blank", "ExpressionRefused", "Template", "read_template"]
