"""Keys that are typed in a terminal: bytes for the board, and the few that are the monitor's own. Pure."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from hil.vocab.typed_bytes import typed
from hil.vocab.verbs import VerbRefused

QUIT, COMMAND = 0x1D, 0x14  # Ctrl-] as of telnet, Ctrl-T as of pyserial's miniterm has its menu
_ENTER, _HELP = 0x0D, ord("?")
LINE_ENDS = {"cr": b"\r", "lf": b"\n", "crlf": b"\r\n", "none": b""}
"""Bytes that Enter can send, by their names."""
_NAMES = {b"\r": "CR", b"\n": "LF", b"\r\n": "CR and LF", b"": "nothing"}


class MacroRefused(ValueError):
    """A macro that cannot be: what is wrong, and ``remedy``, what to write."""

    def __init__(self, why: str, remedy: str) -> None:
        super().__init__(why)
        self.remedy = remedy


@dataclass
class TypedKeys:
    """Outcome of some keys. ``data``: bytes for the board; ``is_end``: the monitor ends; ``asks_help``: the
    keys are to be listed; ``unknown``: key behind Ctrl-T that nobody has given a text."""

    data: bytes = b""
    is_end: bool = False
    asks_help: bool = False
    unknown: str = ""


@dataclass
class KeyReader:
    """Reader of a terminal's keys. ``enter``: bytes that Enter sends; ``macros``: texts by their keys."""

    enter: bytes = b"\r"
    macros: Mapping[str, bytes] = field(default_factory=dict)
    _is_command: bool = False

    def read(self, keys: bytes) -> TypedKeys:
        """Read what a terminal gave, a part of a text or of a command too. Nothing counts behind an end."""
        came, data = TypedKeys(), bytearray()
        for key in keys:
            if self._is_command:
                self._is_command = False
                data += self._command(key, came)
            elif key == QUIT:
                came.is_end = True
                break
            elif key == COMMAND:
                self._is_command = True
            else:
                data += self.enter if key == _ENTER else bytes((key,))
        came.data = bytes(data)
        return came

    def _command(self, key: int, came: TypedKeys) -> bytes:
        if key in (QUIT, COMMAND):
            return bytes((key,))
        if key == _HELP:
            came.asks_help = True
            return b""
        if (text := self.macros.get(chr(key))) is None:
            came.unknown = chr(key)
            return b""
        return text

    def help_lines(self) -> list[str]:
        """Say what the keys do, a line each."""
        lines = [
            "Ctrl-]  ends the monitor",
            f"Enter   sends {_NAMES.get(self.enter, ascii(self.enter))}",
            "Ctrl-T Ctrl-T, Ctrl-T Ctrl-]  send that key to the board",
        ]
        lines += [f"Ctrl-T {key}  types {ascii(text)[2:-1]}" for key, text in sorted(self.macros.items())]
        return lines if self.macros else [*lines, "Ctrl-T and a key types a text: --macro KEY=KEYS"]


def macro_in(said: str) -> tuple[str, bytes]:
    r"""Read a macro such as ``1=m3000v150\r``: its key, and what it types.

    Raises:
        MacroRefused: it is none.
    """
    key, equals, text = said.partition("=")
    if not equals:
        raise MacroRefused(f"{said!r} is no macro", r"write KEY=KEYS, as 1=p\r")
    return _checked_key(key), _text(text)


_LINE = re.compile(r"\s*(\S+?):(?: (.*))?")


def macros_in(lines: Sequence[str]) -> tuple[dict[str, bytes], list[tuple[int, int, str]]]:
    r"""Read a file's lines ``key: text``; empty lines and those that begin with # say nothing. A text goes
    to the line's end, blanks too. Answers texts by keys, and every problem with line and column, from 1."""
    macros: dict[str, bytes] = {}
    problems = []
    for number, line in enumerate(lines, 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        if not (found := _LINE.fullmatch(line)):
            problems.append((number, 1, "no macro is here (write KEY: KEYS, as 1: p\\r)"))
            continue
        at = 1
        try:
            key = _checked_key(found[1])
            if key in macros:
                raise MacroRefused(f"key {key} has a text above already", "take another key")
            at = max(found.start(2), 0) + 1
            macros[key] = _text(found[2] or "")
        except MacroRefused as error:
            problems.append((number, at, f"{error} ({error.remedy})"))
    return macros, problems


def _checked_key(key: str) -> str:
    if len(key) != 1 or not "!" <= key <= "~" or key == "?":
        raise MacroRefused(f"{key!r} is no key", "take one letter, digit or sign, and not ?")
    return key


def _text(text: str) -> bytes:
    if not text:
        raise MacroRefused("the macro types nothing", "write a text behind its key")
    try:
        return typed(text)
    except VerbRefused as error:
        why, _, remedy = str(error).partition("; ")
        raise MacroRefused(why, remedy) from None
