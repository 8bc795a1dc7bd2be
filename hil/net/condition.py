"""Conditions on what has a name, as in ``position_deg > 89 and loop_on == 1`` or ``m1.sent has "Error"``.

From weak to strong: ``or``, ``and``, ``not``, comparisons, ``+ -``, ``* /``, a minus before a number; around
all of them parentheses, and the functions of ``FUNCTIONS``. A comparison is of numbers, or of a text with
words in quotes: ``has`` finds them anywhere in it, ``==`` and ``!=`` compare the whole. Of what is not told
neither a comparison holds, nor its opposite.
"""

import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from hil.net.axis_states import CODED
from hil.vocab.near_words import meant

_OPPOSITES = {"<=": ">", ">=": "<", "==": "!=", "!=": "==", "<": ">=", ">": "<="}
_SIGNS = " ".join(_OPPOSITES)
_MEANT = {"=": "==", "=>": ">=", "=<": "<=", "<>": "!=", "===": "=="}
_WORD = re.compile(
    r"\s*(?:(?P<hex>0[xX][0-9a-fA-F]+(?!\w))"
    r"|(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?P<unit>[^\W\d]\w*)?"
    r"|(?P<name>(?:[^\W\d][\w-]*\.)*[^\W\d]\w*)|(?P<operator>[<>=!]+)"
    r"|(?P<text>\"(?:[^\"\\]|\\.)*\"|'(?:[^'\\]|\\.)*')|(?P<mark>[-+*/(),])|(?P<other>\S))"
)
_ESCAPE = re.compile(rb"\\(x[0-9a-fA-F]{2}|.)")
_ESCAPES = {b"r": b"\r", b"n": b"\n", b"t": b"\t", b"0": b"\0"}
_EXAMPLE = "position_deg > 89"
_MOST_WORDS, _DEEPEST = 500, 50


def _least(*values: float) -> float:
    return math.nan if any(map(math.isnan, values)) else min(values)


def _most(*values: float) -> float:
    return math.nan if any(map(math.isnan, values)) else max(values)


def _over(upper: float, lower: float) -> float:
    return upper / lower if lower else math.nan


FUNCTIONS: dict[str, tuple[int, Callable[..., float]]] = {
    "abs": (1, abs),
    "max": (2, _most),
    "min": (2, _least),
}
"""Functions by their names, each with its least number of operands: ``abs`` takes no more."""
_CALLED = {name: function for name, (_, function) in FUNCTIONS.items()} | {"over": _over}


class ConditionError(ValueError):
    """Error of a condition: ``str(error)`` says what is wrong with it, and what to write."""


class TextTest(NamedTuple):
    """Comparison of a text that has a name: ``has`` finds ``data`` in it, ``==`` compares the whole."""

    name: str
    sign: str
    data: bytes


@dataclass(frozen=True)
class Condition:
    """Condition as it was read. ``expression``: in Python, of ``f0``, ``f1`` ..., values of ``fields``, nan
    where one is not told, and ``t0``, ``t1`` ..., for ``tests`` True or False, None: there is no text."""

    fields: tuple[str, ...]
    """Names of its numbers, each once, in their order."""
    tests: tuple[TextTest, ...]
    expression: str

    @property
    def operands(self) -> list[str]:
        """Names that ``expression`` has for its fields, and behind them for its tests."""
        tests = (f"t{at}" for at in range(len(self.tests)))
        return [*(f"f{at}" for at in range(len(self.fields))), *tests]

    @cached_property
    def function(self) -> Callable[..., bool]:
        """Function of all operands."""
        function: Callable[..., bool] = compiled(f"lambda {', '.join(self.operands)}: {self.expression}")
        return function

    def holds(self, values: Mapping[str, float | None]) -> bool:
        """True if it does with these values of its fields, and without texts."""
        told = (values[name] for name in self.fields)
        numbers = (math.nan if value is None else value for value in told)
        return self.function(*numbers, *(None for _ in self.tests))

    def check(self, device: str, known: Collection[str]) -> None:
        """Check that it is of fields of a device alone. Raises ConditionError: it has one of them not."""
        for name in self.fields:
            if name not in known:
                beside = next((field for field in self.fields if field in known), "")
                words = "".join(f", {word}" for word in CODED.get(beside, ()) if len(word) > 1)
                what = f" to compare {beside} with; write a number{words}, or a field:" if beside else ";"
                raise ConditionError(f"{device} has no field {name!r}{what} {meant(name, known)}")
        for test in self.tests:
            raise ConditionError(f"{test.name}: `hil find` looks for words in quotes, in a recording")


def compiled(text: str) -> Any:
    """Compile a lambda around ``Condition.expression``, whose words are all of this module."""
    return eval(text, {"__builtins__": {}, **_CALLED})


def parse_condition(text: str, example: str = _EXAMPLE) -> Condition:
    """Read a condition. ``example``: one for messages, as those have it who give it here.

    Raises:
        ConditionError: it is none.
    """
    words = [*_words(text, example)]
    if len(words) > _MOST_WORDS:
        raise ConditionError(f"this condition has {len(words)} words; write at most {_MOST_WORDS}")
    return _Reader(text, words, f"write it as in `{example}`").condition()


class _Word(NamedTuple):
    kind: str
    text: str
    begin: int = 0
    end: int = 0


class _Part(NamedTuple):
    """Part of a condition in Python, and its opposite, which a number has not."""

    python: str
    opposite: str = ""


_END = _Word("end", "")


class _Reader:
    """Reader of a condition from its words, from the weakest of signs down to the strongest.

    Long because each strength has a method.
    """

    def __init__(self, text: str, words: list[_Word], remedy: str) -> None:
        self._text, self._words, self._remedy = text, words, remedy
        self._at = self._depth = 0
        self._fields: dict[str, str] = {}
        self._tests: dict[TextTest, str] = {}

    def condition(self) -> Condition:
        """Read all of it."""
        whole = self._truth(self._either)
        if comma := re.search(r"\d+,\d+", self._text) if self._next.text == "," else None:
            point = comma[0].replace(",", ".")
            raise ConditionError(f'"{comma[0]}" has a comma; write a point before decimals, as {point}')
        if left := self._next.text:
            raise ConditionError(f"{left!r} is too much: write `and` or `or` between two comparisons")
        if not self._fields and not self._tests:
            raise ConditionError(f"{self._text!r} has no field; {self._remedy}")
        return Condition(tuple(self._fields), tuple(self._tests), whole.python)

    # ---- words ----

    @property
    def _next(self) -> _Word:
        return self._words[self._at] if self._at < len(self._words) else _END

    def _dropped(self, kind: str, *texts: str) -> str:
        """Text of the next word, if it is of this kind and one of these, behind which it goes on."""
        word = self._next
        if word.kind != kind or (texts and word.text not in texts):
            return ""
        self._at += 1
        return word.text

    def _spelled(self, begin: int) -> str:
        return self._text[self._words[begin].begin : self._words[self._at - 1].end]

    def _here(self) -> str:
        return f" where {self._next.text!r} stands" if self._next.text else ""

    # ---- what holds or does not ----

    def _truth(self, read: Callable[[], _Part]) -> _Part:
        begin = self._at
        return self._checked(read(), begin)

    def _checked(self, part: _Part, begin: int) -> _Part:
        if not part.opposite:
            there = f", not {self._next.text!r}" if self._next.text else ""
            spelled = self._spelled(begin)
            example = f", as in `{spelled} == 1`" if self._words[begin].text == spelled else ""
            raise ConditionError(f"write one of {_SIGNS} behind {spelled}{there}{example}")
        return part

    def _either(self) -> _Part:
        return self._joined(self._both, "or", "and")

    def _both(self) -> _Part:
        return self._joined(self._not, "and", "or")

    def _joined(self, read: Callable[[], _Part], joint: str, opposite: str) -> _Part:
        begin, parts = self._at, [read()]
        while self._next.kind == "joint" and self._next.text == joint:
            self._checked(parts[0], begin)
            self._at += 1
            parts.append(self._truth(read))
        if len(parts) == 1:
            return parts[0]
        held, not_held = zip(*parts, strict=True)
        return _Part(f"({f' {joint} '.join(held)})", f"({f' {opposite} '.join(not_held)})")

    def _not(self) -> _Part:
        if not self._dropped("joint", "not"):
            return self._comparison()
        part = self._deeper(lambda: self._truth(self._not))
        return _Part(part.opposite, part.python)

    def _comparison(self) -> _Part:
        if test := self._test():
            return test
        begin = self._at
        left = self._sum(f"a field or a number is missing; {self._remedy}")
        if left.opposite or not (sign := self._dropped("operator")):
            return left
        if self._next.kind == "text":
            example = f"m1.sent has {self._next.text}"
            raise ConditionError(f"words in quotes stand behind a name that has a text, as in `{example}`")
        missing = f"behind {sign} a field or a number is missing"
        remedy = f"write it as in `{self._spelled(begin)} 5`"
        right = self._code(begin) or self._number(lambda: self._sum(f"{missing}; {remedy}"))
        return _Part(*(_compared(left.python, each, right.python) for each in (sign, _OPPOSITES[sign])))

    def _code(self, begin: int) -> _Part | None:
        """Read a word for a value of the field before the sign, as in ``mode == position``."""
        field, word = self._words[begin], self._next
        if self._at != begin + 2 or field.kind != "name" or word.kind != "name":
            return None
        code = CODED.get(field.text.rpartition(".")[2], {}).get(word.text.lower())
        if code is None:
            return None
        self._at += 1
        return _Part(repr(float(code)))

    def _test(self) -> _Part | None:
        """Read a comparison of a text."""
        name, sign, data = (*self._words[self._at : self._at + 3], _END, _END, _END)[:3]
        is_has = sign.kind == "has"
        if name.kind != "name" or not (is_has or (sign.kind == "operator" and data.kind == "text")):
            return None
        if data.kind not in ("text", "hex"):
            there = f", not {data.text!r}" if data.text else ""
            raise ConditionError(
                f"write words in quotes, or bytes as in 0x1b5b, behind {name.text} has{there}"
            )
        if not is_has and sign.text not in ("==", "!="):
            raise ConditionError(f"{name.text} {sign.text} {data.text}: of words write has, == or !=")
        self._at += 3
        test = TextTest(name.text, sign.text if is_has else "==", _data(data))
        if not test.data and is_has:
            raise ConditionError(f"{name.text} has {data.text}: write what to look for")
        called = self._tests.setdefault(test, f"t{len(self._tests)}")
        part = _Part(f"({called} is True)", f"({called} is False)")
        return _Part(part.opposite, part.python) if sign.text == "!=" else part

    # ---- numbers ----

    def _number(self, read: Callable[[], _Part]) -> _Part:
        begin = self._at
        if (part := read()).opposite:
            raise ConditionError(f"{self._spelled(begin)} is no number, and one is wanted there")
        return part

    def _sum(self, missing: str) -> _Part:
        return self._chain(lambda missing: self._product(missing), "+-", missing)

    def _product(self, missing: str) -> _Part:
        return self._chain(self._signed, "*/", missing)

    def _chain(self, read: Callable[[str], _Part], signs: str, missing: str) -> _Part:
        begin, whole = self._at, read(missing)
        while sign := self._dropped("mark", *signs):
            if whole.opposite:
                raise ConditionError(
                    f"{self._spelled(begin)[:-1].strip()} is no number, and one is wanted there"
                )
            right = self._number(lambda: read(f"behind {sign} a field or a number is missing"))
            text = (
                f"over({whole.python},{right.python})"
                if sign == "/"
                else f"{whole.python}{sign}{right.python}"
            )
            whole = _Part(text)
            if text.count("over(") > _DEEPEST:
                raise ConditionError(f"this condition divides too often; write at most {_DEEPEST} /")
        return whole

    def _signed(self, missing: str) -> _Part:
        if sign := self._dropped("mark", "-", "+"):
            number = self._deeper(
                lambda: self._number(lambda: self._signed(f"behind {sign} a field or a number is missing"))
            )
            return _Part(f"({sign}{number.python})")
        return self._operand(missing)

    def _operand(self, missing: str) -> _Part:
        if self._dropped("mark", "("):
            part = self._deeper(self._either)
            self._close()
            return part if part.opposite else _Part(f"({part.python})")
        if number := self._dropped("number"):
            return _Part(repr(float(number)) if math.isfinite(float(number)) else "1e999")
        if digits := self._dropped("hex"):
            return _Part(str(int(digits, 16)))
        name = self._dropped("name")
        if not name:
            raise ConditionError(missing.replace(" is missing", f" is missing{self._here()}", 1))
        if self._dropped("mark", "("):
            return self._deeper(lambda: self._called(name))
        return _Part(self._fields.setdefault(name, f"f{len(self._fields)}"))

    def _called(self, name: str) -> _Part:
        if name not in FUNCTIONS:
            raise ConditionError(f"there is no function {name!r}; {meant(name, FUNCTIONS)}")
        missing = f"in {name}() a field or a number is missing"
        operands = [self._number(lambda: self._sum(missing)).python]
        while self._dropped("mark", ","):
            operands.append(self._number(lambda: self._sum(missing)).python)
        self._close()
        least = FUNCTIONS[name][0]
        if len(operands) < least or (least == 1 and len(operands) > 1):
            raise ConditionError(
                f"{name}() takes {least}{'' if least == 1 else ' or more'}, not {len(operands)}"
            )
        return _Part(f"{name}({','.join(operands)})")

    def _close(self) -> None:
        if not self._dropped("mark", ")"):
            raise ConditionError(f"a ) is missing{self._here()}")

    def _deeper(self, read: Callable[[], _Part]) -> _Part:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise ConditionError(f"this condition is too deep; write at most {_DEEPEST} in one another")
        part = read()
        self._depth -= 1
        return part


def _compared(left: str, sign: str, right: str) -> str:
    """Comparison that does not hold if one of the two is nan."""
    return f"({left}<{right} or {left}>{right})" if sign == "!=" else f"({left}{sign}{right})"


def _data(word: _Word) -> bytes:
    if word.kind == "hex":
        if len(word.text) % 2:
            raise ConditionError(f"{word.text} is half a byte too long; write two digits for each byte")
        return bytes.fromhex(word.text[2:])
    return _ESCAPE.sub(
        lambda found: (
            bytes.fromhex(found[1][1:].decode()) if len(found[1]) == 3 else _ESCAPES.get(found[1], found[1])
        ),
        word.text[1:-1].encode(),
    )


def _words(text: str, example: str) -> Iterator[_Word]:
    """Words of a condition, each with its kind."""
    for found in _WORD.finditer(text):
        kind, word = str(found.lastgroup), found[0].strip()
        if kind == "unit":
            raise ConditionError(
                f'"{word}" has a unit; write {found["number"]}: a field\'s name says its unit'
            )
        if kind == "other":
            is_quote = word in "\"'"
            raise ConditionError(
                f"the words behind {word} have no end"
                if is_quote
                else f"{word!r} means nothing here; write it as in `{example}`"
            )
        if kind == "operator" and word not in _OPPOSITES:
            raise ConditionError(f"write {_MEANT.get(word) or f'one of {_SIGNS}'}, not {word}")
        if kind == "name" and word.lower() in ("and", "or", "not", "has"):
            word = word.lower()
            kind = "has" if word == "has" else "joint"
        yield _Word(kind, word, found.end() - len(found[0].lstrip()), found.end())
