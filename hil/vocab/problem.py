"""Mistake in a file that a user wrote, with its place and its remedy."""

from collections.abc import Sequence
from dataclasses import dataclass


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


class ConfigError(Exception):
    """Error of a configuration, or of a board that it names, that cannot be used. ``problems`` has every
    mistake found, in file order."""

    def __init__(self, problems: Sequence[Problem]) -> None:
        super().__init__("\n".join(str(problem) for problem in problems))
        self.problems = list(problems)
