"""A block: the words of one line, read and sorted, before anything is done with them."""

import re
from typing import NamedTuple

from hil.gcode.expressions import COMMENT, BadValue, Mistake, Values
from hil.gcode.state import ProgramState
from hil.gcode.words import AXES, G_WORDS, M_WORDS, PLAIN, REFUSED_LETTERS, Group, Word
from hil.vocab.near_words import did_you_mean

LIMIT = 1e9
"""Numbers of words are smaller: 1000 kilometres, in millimetres."""

LARGEST = 1e30
"""Values of parameters are smaller, so that sums of offsets are finite."""

MOST_M_WORDS = 4
"""M words of a line: RS-274/NGC, 3.4."""

_TENTH = 1e-3
"""A G word's number may miss a whole tenth by this, counted in tenths: as in LinuxCNC 2.9."""

_LINE_NUMBER = re.compile(r"n[0-9]+(?:\.[0-9]+)?(?!\.)")
_NOT_NEGATIVE = {"f": "a feed", "s": "a speed of the spindle", "t": "the number of a tool"}
_OTHERWISE = {
    ",": "write a point in numbers: 1.5",
    "\r": "end lines with LF, or all with CR LF, or all with CR",
}
_WHOLE = {"t": "the number of a tool", "l": "L"}
_NAMES_OF_G = {word.name: word for word in G_WORDS.values() if word.use != "refused"}
_NAMES_OF_M = {word.name: word for word in M_WORDS.values() if word.use != "refused"}


class CodeWord(NamedTuple):
    """A G or M word of a line, and the index of its letter."""

    word: Word
    at: int


class Block:
    """Words of a line by letter and by modal group, and what is wrong with them.

    ``numbers`` and ``indices`` are of the letters that stand once: value, and where the letter is.
    ``settings`` are parameters, their new values and where they are set, in order.
    """

    __slots__ = ("codes", "indices", "mistakes", "numbers", "settings")

    def __init__(self) -> None:
        self.numbers: dict[str, float] = {}
        self.indices: dict[str, int] = {}
        self.codes: dict[Group, CodeWord] = {}
        self.settings: list[tuple[int | str, float, int]] = []
        self.mistakes: list[Mistake] = []

    def has(self, name: str) -> CodeWord | None:
        """The word of this name, for example ``G53``, if the line has it."""
        return next((code for code in self.codes.values() if code.word.name == name), None)

    @property
    def axes(self) -> str:
        """Letters of axes that the line has, in the order of a ``Point``."""
        return "".join(letter for letter in AXES if letter in self.numbers)


def read_block(code: str, parameters: ProgramState) -> Block:
    """Read a line without blanks, comments and its ``/``."""
    block = Block()
    values = Values(code, parameters)
    try:
        _number_of_line(values)
        while values.index < len(code):
            _word(block, values)
    except BadValue as wrong:
        values.mistake(wrong.at, wrong.message, wrong.remedy)
    block.mistakes = values.mistakes
    return block


def _number_of_line(values: Values) -> None:
    if values.peek() != "n":
        return
    number = _LINE_NUMBER.match(values.text)
    if number is None:
        raise BadValue(0, "N has no number", "write digits behind N, or remove it")
    values.index = number.end()


def _word(block: Block, values: Values) -> None:
    begin = values.index
    letter = values.peek()
    values.index += 1
    if letter == COMMENT:
        return
    if letter == "g":
        _g_word(block, values, begin)
    elif letter == "m":
        _m_word(block, values, begin)
    elif letter == "#":
        key = values.key()
        if values.peek() != "=":
            raise BadValue(
                values.index, "a parameter stands alone", "set it with =, or use it behind a letter"
            )
        values.index += 1
        try:
            value = values.value()
        except BadValue:
            block.settings.append((key, 0.0, begin))  # it is there for the lines that follow
            raise
        if not -LARGEST < value < LARGEST:
            values.mistake(begin, f"the parameter becomes {value:.3g}", f"the most is {LARGEST:.0e}")
            value = 0.0
        block.settings.append((key, value, begin))
    elif letter in PLAIN:
        _plain_word(block, values, begin, letter)
    elif letter == "o":
        if (
            not (block.indices or block.codes or block.settings)
            and values.text[values.index :].rstrip(COMMENT).isdecimal()
        ):
            values.index = len(values.text)  # the number of a program, as other controls have it
            return
        raise BadValue(
            begin, "O words (subroutines, loops) are not read", "have the CAM program write them out"
        )
    elif letter == "n":
        raise BadValue(begin, "N is not the first word", "the number of a line stands at its beginning")
    elif letter == "%":
        raise BadValue(
            begin, "% is not where a program begins or ends", "write % in a line of its own, first and last"
        )
    elif "\udc80" <= letter <= "\udcff":
        byte = ord(letter) - 0xDC00
        raise BadValue(
            begin, f"the byte {byte:#04x} is not UTF-8 text", "save the file as UTF-8; use letters A to Z"
        )
    else:
        remedy = _OTHERWISE.get(letter, "words are a letter and a number: X1.5")
        raise BadValue(begin, f"no word begins with {letter!r}", remedy)


def _plain_word(block: Block, values: Values, begin: int, letter: str) -> None:
    name = letter.upper()
    value = values.value() if letter not in _WHOLE else float(values.whole(_WHOLE[letter]))
    if letter in REFUSED_LETTERS:
        values.mistake(begin, f"{name} has no meaning here", REFUSED_LETTERS[letter])
        return
    if letter in block.numbers:
        values.mistake(begin, f"{name} stands twice in the line", "keep one, or make two lines")
        return
    if not -LIMIT < value < LIMIT:
        values.mistake(
            begin, f"{name} is {value:.4g}, which is too large", "numbers are below a thousand million"
        )
        value = 0.0
    if value < 0 and letter in _NOT_NEGATIVE:
        values.mistake(begin, f"{_NOT_NEGATIVE[letter]} is {value:g}", "it must not be below 0")
        value = 0.0
    block.numbers[letter] = value
    block.indices[letter] = begin


def _g_word(block: Block, values: Values, begin: int) -> None:
    mistakes = len(values.mistakes)
    value = values.value()
    if len(values.mistakes) > mistakes:
        return
    tenths = 10 * min(max(value, -LIMIT), LIMIT)
    number = round(tenths)
    word = G_WORDS.get(number) if abs(tenths - number) <= _TENTH else None
    if word is None:
        name = f"G{value:g}"
        values.mistake(begin, f"there is no word {name}", _near(name, _NAMES_OF_G))
    else:
        _add(block, values, begin, word)


def _m_word(block: Block, values: Values, begin: int) -> None:
    mistakes = len(values.mistakes)
    number = values.whole("the number behind M")
    if len(values.mistakes) > mistakes:
        return
    word = M_WORDS.get(number)
    if word is None:
        values.mistake(begin, f"there is no word M{number}", _near(f"M{number}", _NAMES_OF_M))
    else:
        _add(block, values, begin, word)
        if sum(code.word.name[0] == "M" for code in block.codes.values()) > MOST_M_WORDS:
            values.mistake(begin, f"the line has more than {MOST_M_WORDS} M words", "make two lines")


def _add(block: Block, values: Values, begin: int, word: Word) -> None:
    if word.use == "refused":
        values.mistake(begin, f"{word.name} ({word.meaning}) is not done", word.remedy)
        return
    other = block.codes.get(word.group)
    # M7 and M8 exclude each other in a line, as in RS-274/NGC: they are one group.
    if other:
        both = f"{other.word.name} and {word.name}" if other.word is not word else f"{word.name} twice"
        values.mistake(begin, f"the line has {both}", f"both are of the group {word.group!r}: make two lines")
    else:
        block.codes[word.group] = CodeWord(word, begin)


def _near(name: str, known: dict[str, Word]) -> str:
    near = [other for other in known if other.partition(".")[0] == name.partition(".")[0]]
    return did_you_mean(*near) or "remove it, or write what it stands for in other words"
