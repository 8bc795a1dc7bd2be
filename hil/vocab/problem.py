"""Mistake in a file that a user wrote, with its place and its remedy."""

from collections.abc import Sequence

from hil.vocab.late_dataclass import dataclass


@dataclass(frozen=True)
class Problem:
    """Mistake with its place. Line and column count from 1; both are 0 where there is no text."""

    file: str
    line: int
    column: int
    message: str
    remedy: str

    def __str__(self) -> str:
        place = f":{self.line}:{self.column}" if self.line else ""
        return f"{self.file}{place}: {self.message} ({self.remedy})"


def not_text(file: str, error: UnicodeDecodeError) -> Problem:
    """Problem of a file that is no text: where its first wrong byte is."""
    before = error.object[: error.start]
    begin = before.rfind(b"\n") + 1
    line, column = before.count(b"\n") + 1, len(before[begin:].decode(errors="replace")) + 1
    if b"\0" in error.object:
        return Problem(file, line, column, "this is no text file", "give a text, saved as UTF-8")
    message = f"the byte {error.object[error.start]:#04x} is not UTF-8 text"
    return Problem(file, line, column, message, "save the file as UTF-8")


class ConfigError(Exception):
    """Error of a configuration, or of a board that it names, that cannot be used. ``problems`` has every
    mistake found, in file order."""

    def __init__(self, problems: Sequence[Problem]) -> None:
        super().__init__("\n".join(str(problem) for problem in problems))
        self.problems = list(problems)


class Unusable(Exception):
    """Error of a kind of port or bridge that exists and cannot be used: ``str(error)`` says why."""

    def __init__(self, why: str, remedy: str) -> None:
        super().__init__(why)
        self.remedy = remedy
