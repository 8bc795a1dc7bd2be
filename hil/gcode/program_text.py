"""The text of a program: bytes to lines, lines to what is left without blanks and comments."""

import re
from typing import NamedTuple

from hil.gcode.canonical import TextPlace
from hil.vocab.problem import Problem

LONGEST = 256
"""Characters of a line: RS-274/NGC, 3.3."""

_BLANK = " \t"
_TO_CODE = {ord(blank): None for blank in _BLANK} | {ord("A") + n: ord("a") + n for n in range(26)}
_COMMENT = re.compile(r"\((?P<text>[^()]*+)(?P<closed>.?)|;.*", re.DOTALL)
_UNCLOSED = {
    "": ("a comment has no )", "close it with )"),
    "(": ("a comment has a ( inside", "comments do not nest: remove one ("),
}
_MESSAGE = re.compile(r"\s*msg,", re.IGNORECASE)
_UTF_16 = (b"\xff\xfe", b"\xfe\xff")
_UTF_8_MARK = b"\xef\xbb\xbf"
_RESAVE = "save the file as UTF-8 text"


def lines_of(text: bytes, file: str) -> tuple[list[str], list[Problem]]:
    """Lines of a file, which may end with LF, CR LF or CR, or the one problem that it has as a whole.

    A byte that is not UTF-8 is a lone surrogate of its line: in a comment it does no harm.
    """
    if text.startswith(_UTF_16):
        return [], [Problem(file, 1, 1, "the file is UTF-16", _RESAVE)]
    if 0 in text:
        before = text[: text.index(0)]
        line = before.count(b"\n") + 1
        column = len(before[before.rfind(b"\n") + 1 :].decode(errors="replace")) + 1
        return [], [Problem(file, line, column, "the file has a byte 0: it is binary or UTF-16", _RESAVE)]
    decoded = text.removeprefix(_UTF_8_MARK).decode(errors="surrogateescape")
    lines = decoded.split("\n" if "\n" in decoded else "\r")
    return (lines if lines[-1].strip() else lines[:-1]), []


class Comment(NamedTuple):
    """Comment that is a message: ``text`` behind its comma, in the place of its bracket."""

    place: TextPlace
    text: str


class CodeLine:
    """A line: ``code`` is in small letters, without blanks, with a ( alone where a comment is.

    ``messages`` are its ``(MSG, ...)``.

    ``is_deletable``: it begins with a slash, which is not in ``code``. ``problem`` says what is wrong with
    its length or its comments, with a column from 1; ``code`` ends before it.
    """

    __slots__ = ("_comments", "_raw", "code", "is_deletable", "messages", "number", "problem")

    def __init__(self, number: int, raw: str) -> None:
        raw = raw.rstrip("\r")
        self.number = number
        self.messages: list[Comment] = []
        self.problem: tuple[int, str, str] | None = None
        self._raw = raw
        self._comments: list[tuple[int, int]] = []
        if len(raw) > LONGEST and len(raw.rstrip()) > LONGEST:
            self.problem = (LONGEST + 1, f"the line has {len(raw)} characters", f"{LONGEST} is the most")
            self.code = ""
        elif "(" in raw or ";" in raw:
            self.code = self._without_comments()
        else:
            self.code = raw.translate(_TO_CODE)
        self.is_deletable = self.code.startswith("/")
        self.code = self.code.removeprefix("/")

    def column(self, index: int) -> int:
        """Column of a character of ``code``, counted from 0; of the line's end for the index behind it."""
        left, at = index + self.is_deletable, 0
        comments = iter((*self._comments, (len(self._raw), len(self._raw))))
        begin, end = next(comments)
        while at < len(self._raw):
            if at == begin:
                at, (begin, end) = end, next(comments)
                continue
            if self._raw[at] not in _BLANK:
                if left == 0:
                    return at + 1
                left -= 1
            at += 1
        return len(self._raw.rstrip()) + 1

    def place(self, index: int) -> TextPlace:
        return TextPlace(self.number, self.column(index))

    def _without_comments(self) -> str:
        kept, at = [], 0
        while found := _COMMENT.search(self._raw, at):
            kept.append(self._raw[at : found.start()])
            at = found.end()
            if found["text"] is not None:
                kept.append("(")
            is_bracket = found["text"] is not None
            self._comments.append((found.start() + is_bracket, at))
            if is_bracket and found["closed"] != ")":
                self.problem = (found.start() + 1, *_UNCLOSED[found["closed"]])
                return "".join(kept).translate(_TO_CODE)
            if message := _MESSAGE.match(found["text"] or ""):
                place = TextPlace(self.number, found.start() + 1)
                self.messages.append(Comment(place, _printable(found["text"][message.end() :].strip())))
        return "".join((*kept, self._raw[at:])).translate(_TO_CODE)


def _printable(text: str) -> str:
    """A text without what terminals obey, and with a mark for bytes that are not UTF-8."""
    return "".join(each if each.isprintable() else "\ufffd" for each in text)
