"""Lines of files under the problems that were found in them, with a caret at the place."""

import os
import re
import shlex
import stat
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TextIO

from hil.host.journal import say
from hil.host.shown_stream import own
from hil.vocab.shown_text import printable_lines

_PROBLEM = re.compile(r"(?P<file>[^\n:]+):(?P<line>[1-9]\d{0,6}):(?P<column>[1-9]\d{0,6}): (?P<message>.*)")
_MOST_BYTES = 1 << 20
_WIDTH = 100
"""Characters of a line that are shown."""
_BOLD, _RED, _DIM, _PLAIN = "\x1b[1m", "\x1b[1;31m", "\x1b[2m", "\x1b[0m"


def has_colours(stream: TextIO) -> bool:
    """True on a terminal that shows colours, unless NO_COLOR is set (https://no-color.org)."""
    if os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb":
        return False
    return stream.isatty()


_REMEDIES = (
    (re.compile(r".*/dev/\S+: No such file or directory"), "`ls /dev/tty*` shows which ports there are"),
    (re.compile(r".*: Is a directory"), "write a file in it"),
    (re.compile(r".*: Not a directory"), "write a path whose folders are there"),
    (re.compile(r".*: there is no folder \S+"), "make it with mkdir, or write another path"),
    (re.compile(r".*: the folder \S+ cannot be written to"), "take another one, or get the right to it"),
    (re.compile(r".*: Permission denied"), "get the right to it (`ls -l`), or take another place"),
    (re.compile(r".*: Read-only file system"), "take another place"),
)
"""Remedies for what Linux says of a path, where a message ends with it."""
_ABSENT = re.compile(r"(?:hil: )?(?:--\S+ )?((?!/dev/|\[)[^\n]*): No such file or directory")
_CLOSED = re.compile(r"(?:hil: )?(?:--\S+ )?([^\n]*): Permission denied")


def with_remedy(message: str) -> str:
    """Message with what to do where it ends in words of Linux alone."""
    if found := _ABSENT.fullmatch(message):
        return f"{message}; write a path that is there{_looked_for(Path(found[1]))}"
    if (found := _CLOSED.fullmatch(message)) and _is_closed_file(Path(found[1])):
        return f"{message}; `chmod u+r {shlex.quote(found[1])}` lets you read it"
    for pattern, remedy in _REMEDIES:
        if pattern.fullmatch(message):
            return f"{message}; {remedy}"
    return message


def _looked_for(path: Path) -> str:
    """Whole path of a relative one; empty for others."""
    try:
        return "" if path.is_absolute() else f" (it was looked for at {Path.cwd() / path})"
    except OSError:  # the working folder has gone
        return ""


def _is_closed_file(path: Path) -> bool:
    """True for a file of this user that he may not read."""
    try:
        state = path.stat()
    except (OSError, ValueError):
        return False
    return stat.S_ISREG(state.st_mode) and state.st_uid == os.geteuid() and not state.st_mode & stat.S_IRUSR


def headed(message: str) -> str:
    """Message with `hil:` before it: before a list of problems, in a line of its own that counts them."""
    if message.startswith("hil: "):
        return message
    lines = message.split("\n")
    if not _PROBLEM.fullmatch(lines[0]):
        return f"hil: {message}"
    places = [place for line in lines if (place := _PROBLEM.fullmatch(line))]
    problems = "1 problem" if len(places) == 1 else f"{len(places)} problems"
    files = ", ".join(dict.fromkeys(place["file"] for place in places))
    in_brackets = all(place["message"].endswith(")") for place in places)  # else behind a semicolon
    remedies = "; what to do stands in brackets" if in_brackets else ""
    return f"hil: {problems} in {files}{remedies}\n{message}"


def with_lines(message: str, sources: Mapping[str, str], colours: bool) -> str:
    """Add to each line ``file:line:column: problem`` of a message the file's line and a caret. ``sources``:
    texts of files that cannot be read again, as a pipe's, by their names."""
    texts = dict(sources)
    return "\n".join(part for line in message.split("\n") for part in _shown(line, texts, colours))


def tell_problems(message: str, sources: Mapping[str, str] | None = None) -> None:
    """Write the same to the standard error, with its colours."""
    say(with_lines(printable_lines(message), sources or {}, has_colours(sys.stderr)), own(sys.stderr))


def _shown(said: str, texts: dict[str, str], colours: bool) -> Iterator[str]:
    if not (found := _PROBLEM.fullmatch(said)):
        yield said
        return
    file, line, column = found["file"], int(found["line"]), int(found["column"])
    place = said[: found.start("message") - 2]
    yield f"{_BOLD}{place}:{_PLAIN} {found['message']}" if colours else said
    lines = texts.setdefault(file, _content(file)).split("\n")
    if line > len(lines) or column > len(lines[line - 1]) + 1 or not "".join(lines[line - 1 :]).strip():
        return
    text = "".join(each if each.isprintable() else " " for each in lines[line - 1].rstrip("\r"))
    first = 0 if column <= _WIDTH else column - _WIDTH // 2
    number, caret = f"{line:5} | ", " " * (column - 1 - first) + "^"
    gap = " " * (len(number) - 2) + "| "
    if colours:
        number, gap, caret = f"{_DIM}{number}{_PLAIN}", f"{_DIM}{gap}{_PLAIN}", f"{_RED}{caret}{_PLAIN}"
    yield number + text[first : first + _WIDTH].rstrip()
    yield gap + caret


def _content(file: str) -> str:
    """Text of a regular file; nothing if there is none."""
    path = Path(file)
    try:
        if path.is_file() and path.stat().st_size <= _MOST_BYTES:
            return path.read_text(errors="replace")
    except (OSError, ValueError):
        pass
    return ""
