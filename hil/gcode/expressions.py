"""Values in RS-274/NGC: numbers, parameters, expressions in brackets, functions.

They are read from a line without blanks, in small letters.
"""

import math
import re
from collections.abc import Mapping
from typing import NamedTuple

from hil.gcode.state import ProgramState
from hil.vocab.near_words import did_you_mean, nearest

LAST_PARAMETER = 5601
"""The highest number of a parameter, as in LinuxCNC 2.9; RS-274/NGC asks for 5400."""

COMMENT = "("
"""Character that takes the place of a comment in a line."""

DEEPEST = 40
"""Brackets in brackets. Each needs up to nine frames of Python's stack, which has 1000."""

EQUAL = 1e-4
"""Values that are nearer count as equal in EQ and NE, as in LinuxCNC 2.9."""

WHOLE = 1e-4
"""A value that is nearer to a whole number is one, as in RS-274/NGC, 3.3.2.1."""

NUMBER = r"[-+]?(?:[0-9]++\.?[0-9]*+|\.[0-9]++)"
"""No part of it is tried twice: the time is that of its length."""

_NUMBER = re.compile(NUMBER)
_OPERATOR = re.compile(r"\*\*|[-*/+\]]|mod|and|xor|or|eq|ne|gt|ge|lt|le")
_NAME = re.compile(r"[a-z]+")
_PARAMETER = re.compile(r"[^\x00-\x20<=#\[\]\x7f-\U0010ffff]+")
"""Any name but one whose end is missing, or that cannot be printed."""

_STRENGTH = {
    **dict.fromkeys(("and", "xor", "or"), 1),
    **dict.fromkeys(("eq", "ne", "gt", "ge", "lt", "le"), 2),
    **dict.fromkeys(("+", "-"), 3),
    **dict.fromkeys(("*", "/", "mod"), 4),
    "**": 5,
}
FUNCTIONS: Mapping[str, str] = {
    "ABS": "absolute value",
    "ACOS": "degrees of a cosine",
    "ASIN": "degrees of a sine",
    "ATAN": "degrees of a direction: `ATAN[y]/[x]`",
    "COS": "cosine of degrees",
    "EXISTS": "1 if there is the parameter: `EXISTS[#<name>]`",
    "EXP": "e to a power",
    "FIX": "next whole number below",
    "FUP": "next whole number above",
    "LN": "natural logarithm",
    "ROUND": "nearest whole number, halves away from 0",
    "SIN": "sine of degrees",
    "SQRT": "square root",
    "TAN": "tangent of degrees",
}


class BadValue(Exception):
    """Mistake after which the rest of a line cannot be read. ``at`` is the index of a character."""

    def __init__(self, at: int, message: str, remedy: str) -> None:
        super().__init__(message)
        self.at = at
        self.message = message
        self.remedy = remedy


class Mistake(NamedTuple):
    """Mistake after which the rest of a line can be read. ``at`` is the index of a character."""

    at: int
    message: str
    remedy: str


class Values:
    """Reads values from one line, from left to right."""

    def __init__(self, text: str, parameters: ProgramState) -> None:
        self.text = text
        self.index = 0
        self.mistakes: list[Mistake] = []
        self._parameters = parameters
        self._depth = 0

    def peek(self) -> str:
        """Next character; empty at the end."""
        return self.text[self.index : self.index + 1]

    def value(self) -> float:
        """Read a value. A mistake counts as 0. Raises ``BadValue``."""
        is_negative = False
        while (character := self.peek()) in ("-", "+"):
            if _NUMBER.match(self.text, self.index):
                break
            is_negative ^= character == "-"
            self.index += 1
        value = self._unsigned()
        return -value if is_negative else value

    def whole(self, what: str) -> int:
        """Read a value that has to be a whole number; ``what`` names it."""
        begin = self.index
        value = self.value()
        whole = round(value)
        if abs(value - whole) > WHOLE:
            self.mistake(begin, f"{what} is {value:g}", "it must be a whole number")
        return whole

    def key(self) -> int | str:
        """Read what follows ``#``: a number from 1 on, or a name. Raises ``BadValue``."""
        begin = self.index
        if self.peek() == "<":
            end = self.text.find(">", begin)
            if end < 0:
                raise BadValue(begin, "the name of a parameter does not end", "write > behind it")
            self.index = end + 1
            name = self.text[begin + 1 : end]
            if not _PARAMETER.fullmatch(name):
                remedy = "write letters, digits and _ between < and >"
                raise BadValue(begin, "the name of a parameter is none", remedy)
            return name
        self._enter(begin)
        number = self.whole("the number of a parameter")
        self._depth -= 1
        if not 1 <= number <= LAST_PARAMETER:
            self.mistake(begin, f"there is no parameter #{number}", f"they are #1 to #{LAST_PARAMETER}")
            return 1
        return number

    def mistake(self, index: int, message: str, remedy: str) -> None:
        self.mistakes.append(Mistake(index, message, remedy))

    def _enter(self, index: int) -> None:
        self._depth += 1
        if self._depth > DEEPEST:
            raise BadValue(
                index, f"brackets are more than {DEEPEST} deep", "write the value in several lines"
            )

    def _unsigned(self) -> float:
        begin = self.index
        number = _NUMBER.match(self.text, begin)
        if number:
            self.index = number.end()
            if self.peek() == ".":
                raise BadValue(begin, "a number has two points", "write one")
            return float(number[0])
        character = self.peek()
        if character == "[":
            return self._bracket()
        if character == "#":
            self.index += 1
            return self._parameter(begin, self.key())
        name = _NAME.match(self.text, begin)
        if name and (name[0].upper() in FUNCTIONS or self.text[name.end() : name.end() + 1] == "["):
            self.index = name.end()
            return self._function(begin, name[0].upper())
        remedy = "write a number, #, or an expression in [ ]"
        if character == COMMENT:
            raise BadValue(begin, "a comment stands inside a word", "put comments between words")
        if not character:
            raise BadValue(begin, "a value is missing at the end of the line", remedy)
        raise BadValue(begin, f"a value is missing before {character!r}", remedy)

    def _parameter(self, begin: int, key: int | str) -> float:
        if isinstance(key, int):
            return self._parameters.numbered(key)
        value = self._parameters.named(key)
        if value is None:
            self.mistake(begin, f"there is no parameter #<{key}> yet", f"set it before: #<{key}> = 1")
            return 0.0
        return value

    def _bracket(self) -> float:
        begin = self.index
        if self.peek() != "[":
            raise BadValue(begin, "a [ is missing", "arguments of functions stand in [ ]")
        self._enter(begin)
        self.index += 1
        value = self._expression(1, begin)
        self.index += 1
        self._depth -= 1
        return value

    def _expression(self, weakest: int, bracket: int) -> float:
        """Read up to an operator that binds more weakly, or the ] of ``bracket``."""
        left = self.value()
        while True:
            begin = self.index
            found = _OPERATOR.match(self.text, begin)
            if not found:
                if not self.peek():
                    raise BadValue(bracket, "a [ has no ]", "write the ]")
                if self.peek() == COMMENT:
                    raise BadValue(begin, "a comment stands inside a word", "put comments between words")
                remedy = "operators are ** * / MOD + - EQ NE GT GE LT LE AND OR XOR"
                raise BadValue(begin, f"there is no operator {self.peek()!r}", remedy)
            operator = found[0]
            if operator == "]" or (strength := _STRENGTH[operator]) < weakest:
                return left
            self.index = found.end()
            left = self._applied(begin, operator, left, self._expression(strength + 1, bracket))

    def _applied(self, index: int, operator: str, left: float, right: float) -> float:
        try:
            value = applied(operator, left, right)
        except ZeroDivisionError:
            self.mistake(index, f"{left:g} {operator.upper()} {right:g} divides by 0", "change the divisor")
        except ValueError:
            self.mistake(
                index, f"{left:g} is below 0, and {right:g} is no whole power", "change the base or the power"
            )
        except OverflowError:
            self.mistake(index, f"{left:g} {operator.upper()} {right:g} is too large", "use smaller values")
        else:
            return value
        return 0.0

    def _function(self, begin: int, name: str) -> float:
        if name == "EXISTS":
            return self._exists()
        if name not in FUNCTIONS:
            near = did_you_mean(nearest(name, FUNCTIONS)) or f"functions are {' '.join(FUNCTIONS)}"
            raise BadValue(begin, f"there is no function {name}", near)
        x = self._bracket()
        if name == "ATAN":
            if self.peek() != "/":
                raise BadValue(self.index, "ATAN has one argument", "it takes two: ATAN[y]/[x]")
            self.index += 1
            return math.degrees(math.atan2(x, self._bracket()))
        try:
            return function(name, x)
        except (ValueError, OverflowError):
            self.mistake(begin, f"{name}[{x:g}] has no value", f"{FUNCTIONS[name]}: change the argument")
            return 0.0

    def _exists(self) -> float:
        begin = self.index
        if self.text[begin : begin + 2] != "[#":
            raise BadValue(begin, "EXISTS takes a parameter", "write EXISTS[#<name>]")
        self.index += 2
        key = self.key()
        if self.peek() != "]":
            raise BadValue(self.index, "EXISTS takes a parameter alone", "write EXISTS[#<name>]")
        self.index += 1
        return float(isinstance(key, int) or self._parameters.named(key) is not None)


def applied(operator: str, left: float, right: float) -> float:
    """Result of an operator. Raises ``ZeroDivisionError``, ``ValueError`` for a power that is no real number,
    ``OverflowError`` for what is too large."""
    result = _result(operator, left, right)
    if isinstance(result, complex):
        raise ValueError
    if not math.isfinite(result):
        raise OverflowError
    return result


def _result(operator: str, left: float, right: float) -> float | complex:
    match operator:
        case "**":
            power: float | complex = left**right
            return power
        case "*":
            return left * right
        case "/":
            return left / right
        case "mod":
            if right == 0:
                raise ZeroDivisionError
            rest = math.fmod(left, right)
            return rest + abs(right) if rest < 0 else rest
        case "+":
            return left + right
        case "-":
            return left - right
        case "eq":
            return float(abs(left - right) < EQUAL)
        case "ne":
            return float(abs(left - right) >= EQUAL)
        case "gt":
            return float(left > right)
        case "ge":
            return float(left >= right)
        case "lt":
            return float(left < right)
        case "le":
            return float(left <= right)
        case "and":
            return float(left != 0 and right != 0)
        case "or":
            return float(left != 0 or right != 0)
        case _:
            return float((left != 0) != (right != 0))


def function(name: str, x: float) -> float:
    """Value of a function of one argument. Raises ``ValueError`` and ``OverflowError``."""
    match name:
        case "ABS":
            return abs(x)
        case "ACOS":
            return math.degrees(math.acos(x))
        case "ASIN":
            return math.degrees(math.asin(x))
        case "COS":
            return math.cos(math.radians(x))
        case "EXP":
            return math.exp(x)
        case "FIX":
            return float(math.floor(x))
        case "FUP":
            return float(math.ceil(x))
        case "LN":
            return math.log(x)
        case "ROUND":
            return math.copysign(math.floor(abs(x) + 0.5), x)
        case "SIN":
            return math.sin(math.radians(x))
        case "SQRT":
            return math.sqrt(x)
        case _:
            return math.tan(math.radians(x))
