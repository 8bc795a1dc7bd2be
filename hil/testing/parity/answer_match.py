"""Comparison of two answers to one command: the board's and its twin's."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from itertools import zip_longest

from hil.testing.parity.typed_session import MeasuredNumber

_LINES = re.compile(r"[^\n]*\n|[^\n]+")
_NUMBER = r"-?\d+(?:\.\d+)?"
_SHOWN = 60


@dataclass(frozen=True, kw_only=True)
class Parting:
    """First difference of two answers: ``at`` bytes into the board's; None: there is nothing."""

    at: int
    board: str | None
    twin: str | None


@dataclass(frozen=True, kw_only=True)
class AnswerMatch:
    """Result of a comparison. ``percent``: bytes that are the same. ``lines``: those of board and twin that
    belong together, "" where one has none, and whether they are the same."""

    percent: float
    parting: Parting | None
    lines: Sequence[tuple[str, str, bool]]


class AnswerMatcher:
    """Matcher of the answers of one session, in their order.

    A number behind a text of ``measured`` may differ as far as that says. A line of the twin's that is
    explanation in the project's own words stands for any line.
    """

    def __init__(
        self, measured: Mapping[str, MeasuredNumber], is_own_words: Callable[[str], bool] = lambda line: False
    ) -> None:
        self._measured, self._is_own_words = measured, is_own_words
        self._firsts: dict[str, tuple[float, float]] = {}
        labels = "|".join(re.escape(label) if label else "^" for label in measured)
        self._numbers = re.compile(f"({labels})({_NUMBER})") if measured else None

    @property
    def origins(self) -> Mapping[str, tuple[float, float]]:
        """First numbers of board and twin, of those that count from there."""
        return self._firsts

    def match(self, board: str, twin: str) -> AnswerMatch:
        """Compare two answers."""
        parting: Parting | None = None
        lines: list[tuple[str, str, bool]] = []
        same = total = at = 0
        for ours, theirs in self._pairs(_LINES.findall(board), _LINES.findall(twin)):
            as_twin = self._as_twin(ours, theirs)
            length = max(len(as_twin), len(theirs))
            total += length
            same += length if as_twin == theirs else _common(as_twin, theirs)
            if as_twin != theirs and parting is None:
                parting = _parting(as_twin, theirs, ours, at)
            at += len(ours)
            lines.append((ours, theirs, as_twin == theirs))
        percent = 100.0 * same / total if total else 100.0
        return AnswerMatch(percent=percent, parting=parting, lines=lines)

    def _pairs(self, board: list[str], twin: list[str]) -> Iterator[tuple[str, str]]:
        """Lines that belong together; "" where one has none."""
        if len(board) == len(twin):
            yield from zip(board, twin, strict=True)
            return
        keys, others = [self._key(line) for line in board], [self._key(line) for line in twin]
        for _, i, i_end, j, j_end in SequenceMatcher(None, keys, others, autojunk=False).get_opcodes():
            yield from zip_longest(board[i:i_end], twin[j:j_end], fillvalue="")

    def _key(self, line: str) -> str:
        return self._numbers.sub(r"\1#", line) if self._numbers else line

    def _as_twin(self, board: str, twin: str) -> str:
        """Line of a board, with the twin's in place of what may differ."""
        if twin and board and self._is_own_words(twin.rstrip("\r\n")):
            return twin
        if not self._numbers or self._key(board) != self._key(twin):
            return board
        numbers = iter(self._numbers.findall(twin))

        def put(found: re.Match[str]) -> str:
            label, number = next(numbers)
            return f"{label}{number if self._is_near(label, found[2], number) else found[2]}"

        return self._numbers.sub(put, board)

    def _is_near(self, label: str, board: str, twin: str) -> bool:
        rule, ours, theirs = self._measured[label], float(board), float(twin)
        if rule.from_first:
            first = self._firsts.setdefault(label, (ours, theirs))
            ours, theirs = ours - first[0], theirs - first[1]
        apart = abs(ours - theirs)
        if rule.turn:
            apart = min(apart % rule.turn, -apart % rule.turn)
        return apart <= rule.within + 1e-9


def _common(one: str, other: str) -> int:
    """Number of characters that two lines begin and end with in common."""
    most = min(len(one), len(other))
    front = next((i for i in range(most) if one[i] != other[i]), most)
    back = next((i for i in range(most - front) if one[-1 - i] != other[-1 - i]), most - front)
    return front + back


def _parting(as_twin: str, twin: str, board: str, at: int) -> Parting:
    most = min(len(as_twin), len(twin))
    front = next((i for i in range(most) if as_twin[i] != twin[i]), most)
    own_front = max(front + len(board) - len(as_twin), 0)
    return Parting(at=at + own_front, board=_shown(board), twin=_shown(twin))


def _shown(line: str) -> str | None:
    return (line if len(line) <= _SHOWN else line[:_SHOWN] + "...") or None
