"""Expressions of a table, as in ``voltage_V / load_ohm if output else 0``: read once, computed without eval.

They have Python's form: numbers, texts in quotes, variables, ``relay[2]``, ``+ - * / // %``, comparisons,
``and or not``, ``a if b else c``, and the functions of ``FUNCTIONS``. Truth is 1 or 0. A division by 0 has
the value of ``INFINITE`` with its sign, or 0: a board goes on.
"""

import ast
import math
import operator
from collections.abc import Callable, Iterator
from typing import NamedTuple, Protocol

from hil.vocab.near_words import meant

Value = float | str
Look = Callable[[str, int | None], Value]
"""Answers the value of a variable; its number where there are several of the name, else None."""
INFINITE = 9.9e37
"""Number for what is beyond all numbers. Source: SCPI 1999, volume 1, 7.2.1.4."""
MOST_CHARACTERS = 400
"""Length of an expression: it bounds how deep Python's reader nests."""


class Meaning(Protocol):
    """Variable as an expression sees it."""

    @property
    def is_text(self) -> bool:
        """True if it has texts: also of a choice, whose words it has."""

    @property
    def unit(self) -> str: ...

    @property
    def many(self) -> int:
        """Number of variables of the name, as in ``relay[1]``; 0: it is one."""


class ExpressionRefused(ValueError):
    """Error of a text that is no expression: ``str(error)`` says why."""

    def __init__(self, message: str, remedy: str) -> None:
        super().__init__(message)
        self.remedy = remedy


class Expression(NamedTuple):
    """Expression, ready to be computed. ``unit``: its unit, empty where that is not known; ``names``:
    variables that it reads."""

    text: str
    is_text: bool
    unit: str
    names: frozenset[str]
    value: Callable[[Look], Value]


class _Part(NamedTuple):
    is_text: bool
    unit: str
    value: Callable[[Look], Value]


FUNCTIONS: dict[str, tuple[int, int, Callable[..., float]]] = {
    "abs": (1, 1, abs),
    "min": (2, 9, min),
    "max": (2, 9, max),
    "round": (1, 1, lambda value: math.floor(value + 0.5)),
    "sqrt": (1, 1, lambda value: math.sqrt(max(0.0, value))),
    "exp": (1, 1, lambda value: math.exp(min(value, 85.0))),
    "log": (1, 1, lambda value: math.log(value) if value > 0 else -INFINITE),
}
"""Functions by name: the least and most numbers that they take, and what they answer."""


def _divided(a: float, b: float) -> float:
    return a / b if b else math.copysign(INFINITE, a) if a else 0.0


_ARITHMETIC: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: _divided,
    ast.FloorDiv: lambda a, b: math.floor(_divided(a, b)),
    ast.Mod: lambda a, b: a % b if b else 0.0,
}
_COMPARISONS: dict[type[ast.cmpop], Callable[[Value, Value], bool]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}


def read_expression(text: str, known: dict[str, Meaning]) -> Expression:
    """Read an expression. ``known``: variables by name.

    Raises:
        ExpressionRefused: it is none, or names what is not there.
    """
    if len(text) > MOST_CHARACTERS:
        raise ExpressionRefused("this expression is too long", f"write at most {MOST_CHARACTERS} characters")
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ExpressionRefused(
            f"{text!r} is no expression", "write one as in voltage_V / load_ohm, or output and level > 2"
        ) from None
    reader = _Reader(known)
    part = reader.part(tree)
    return Expression(text, part.is_text, part.unit, frozenset(reader.names), part.value)


class _Reader:
    """Reader of one expression's tree."""

    def __init__(self, known: dict[str, Meaning]) -> None:
        self._known = known
        self.names: set[str] = set()

    def part(self, node: ast.expr) -> _Part:
        match node:
            case ast.Constant(value=bool(value)):
                return _fixed(float(value))
            case ast.Constant(value=int() | float() as value):
                return _fixed(_bounded(value))
            case ast.Constant(value=str(text)):
                return _Part(True, "", lambda look: text)
            case ast.Name(id=name):
                return self._variable(name, None)
            case ast.Subscript(value=ast.Name(id=name), slice=index):
                return self._variable(name, index)
            case ast.UnaryOp(op=ast.USub() | ast.UAdd() | ast.Not() as op, operand=operand):
                return self._unary(op, operand)
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _ARITHMETIC:
                return self._arithmetic(op, left, right)
            case ast.BoolOp(op=op, values=values):
                return self._both_or_either(isinstance(op, ast.And), values)
            case ast.Compare(left=left, ops=ops, comparators=others) if all(
                type(o) in _COMPARISONS for o in ops
            ):
                return self._comparison([left, *others], [_COMPARISONS[type(op)] for op in ops])
            case ast.IfExp(test=test, body=body, orelse=other):
                return self._choice(test, body, other)
            case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
                return self._call(name, arguments)
        what = ast.unparse(node)[:40]
        raise ExpressionRefused(
            f"{what} is not computed here",
            "numbers, variables, + - * / // %, comparisons, and or not, if else",
        )

    def _variable(self, name: str, index: ast.expr | None) -> _Part:
        if (meaning := self._known.get(name)) is None:
            raise ExpressionRefused(f'there is no variable "{name}"', meant(name, list(self._known)))
        if bool(meaning.many) != (index is not None):
            few = f"{name} is one variable: write it without [...]"
            many = f"there are {meaning.many} of {name}: write which, as in {name}[1]"
            raise ExpressionRefused(f"{name} does not stand so here", many if meaning.many else few)
        self.names.add(name)
        if index is None:
            return _Part(meaning.is_text, meaning.unit, lambda look: look(name, None))
        which, most = self._number(index).value, meaning.many
        if isinstance(index, ast.Constant) and not 1 <= _as_number(which(_nothing)) <= most:
            raise ExpressionRefused(f"there is no {ast.unparse(index)} of {name}", f"write 1 to {most}")
        return _Part(
            meaning.is_text,
            meaning.unit,
            lambda look: look(name, min(most, max(1, int(_as_number(which(look)))))),
        )

    def _number(self, node: ast.expr) -> _Part:
        part = self.part(node)
        if part.is_text:
            raise ExpressionRefused(
                f"{ast.unparse(node)[:40]} is a text, not a number", "compare texts with == or != alone"
            )
        return part

    def _unary(self, op: ast.unaryop, operand: ast.expr) -> _Part:
        part = self.part(operand) if isinstance(op, ast.Not) else self._number(operand)
        value = part.value
        if isinstance(op, ast.Not):
            return _Part(False, "", lambda look: float(not value(look)))
        sign = -1.0 if isinstance(op, ast.USub) else 1.0
        return _Part(False, part.unit, lambda look: sign * _as_number(value(look)))

    def _arithmetic(self, op: ast.operator, left: ast.expr, right: ast.expr) -> _Part:
        a, b = self._number(left), self._number(right)
        unit = _one_unit([a, b]) if isinstance(op, ast.Add | ast.Sub) else ""
        compute, first, second = _ARITHMETIC[type(op)], a.value, b.value
        return _Part(
            False,
            unit,
            lambda look: _bounded(compute(_as_number(first(look)), _as_number(second(look)))),
        )

    def _both_or_either(self, is_both: bool, nodes: list[ast.expr]) -> _Part:
        values = [self.part(node).value for node in nodes]
        if is_both:
            return _Part(False, "", lambda look: float(all(value(look) for value in values)))
        return _Part(False, "", lambda look: float(any(value(look) for value in values)))

    def _comparison(self, nodes: list[ast.expr], ops: list[Callable[[Value, Value], bool]]) -> _Part:
        parts = [self.part(node) for node in nodes]
        if len({part.is_text for part in parts}) > 1:
            raise ExpressionRefused("a text is compared with a number", "compare two texts, or two numbers")
        _one_unit(parts)
        values = [part.value for part in parts]

        def compared(look: Look) -> float:
            found = [value(look) for value in values]
            return float(all(op(found[i], found[i + 1]) for i, op in enumerate(ops)))

        return _Part(False, "", compared)

    def _choice(self, test: ast.expr, body: ast.expr, other: ast.expr) -> _Part:
        asked, yes, no = self.part(test).value, self.part(body), self.part(other)
        if yes.is_text != no.is_text:
            raise ExpressionRefused("one choice is a text, the other a number", "let both be of one kind")
        return _Part(
            yes.is_text,
            _one_unit([yes, no]),
            lambda look: yes.value(look) if asked(look) else no.value(look),
        )

    def _call(self, name: str, arguments: list[ast.expr]) -> _Part:
        if name not in FUNCTIONS:
            raise ExpressionRefused(f'there is no function "{name}"', meant(name, list(FUNCTIONS)))
        least, most, function = FUNCTIONS[name]
        if not least <= len(arguments) <= most:
            wanted = f"{least}" if least == most else f"{least} or more"
            raise ExpressionRefused(f"{name} takes {wanted} numbers", f"it has {len(arguments)} here")
        parts = [self._number(node) for node in arguments]
        unit = _one_unit(parts) if name in ("abs", "min", "max", "round") else ""
        return _Part(
            False, unit, lambda look: _bounded(function(*(_as_number(part.value(look)) for part in parts)))
        )


def _one_unit(parts: list[_Part]) -> str:
    """Unit that all parts have; one that has none goes with any. Raises ExpressionRefused: they differ."""
    units = list(dict.fromkeys(part.unit for part in parts if part.unit))
    if len(units) > 1:
        raise ExpressionRefused(
            f"{units[0]} and {units[1]} do not go together",
            "multiply one by its factor, as in 1000 * voltage_V",
        )
    return units[0] if units else ""


def _fixed(value: float) -> _Part:
    return _Part(False, "", lambda look: value)


def _nothing(name: str, index: int | None) -> Value:
    raise KeyError(name)


def _as_number(value: Value) -> float:
    return value if isinstance(value, float | int) else 0.0


def _bounded(value: float) -> float:
    """Value as a float within what a table computes with."""
    if value != value:
        return 0.0
    return float(min(max(value, -INFINITE), INFINITE))


def loop_in(reads: dict[str, frozenset[str]]) -> tuple[str, ...]:
    """First loop of variables that are computed from each other: their names, in order; empty: none.
    ``reads``: names that each reads."""
    done: set[str] = set()
    for first in reads:
        for found in _walked(first, reads, done):
            return found
    return ()


def _walked(first: str, reads: dict[str, frozenset[str]], done: set[str]) -> Iterator[tuple[str, ...]]:
    path, stack = [first], [iter(sorted(reads[first]))]
    while stack:
        name = next(stack[-1], None)
        if name is None:
            done.add(path.pop())
            stack.pop()
        elif name in path:
            yield tuple(path[path.index(name) :])
            return
        elif name in reads and name not in done:
            path.append(name)
            stack.append(iter(sorted(reads[name])))


def in_order(reads: dict[str, frozenset[str]]) -> tuple[str, ...]:
    """Names in an order in which each comes after those that it reads; there is no loop."""
    ordered: dict[str, None] = {}

    def visit(name: str) -> None:
        for other in sorted(reads[name]):
            if other in reads and other not in ordered:
                visit(other)
        ordered[name] = None

    for name in reads:
        visit(name)
    return tuple(ordered)
