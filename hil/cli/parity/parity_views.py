"""Scores of a board against its twin: a table for people, rows for programs, answers side by side."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hil.cli.framework.shown_view import Grid, Line, line, terminal_columns
from hil.cli.framework.shown_words import counted
from hil.testing.parity.parity_scores import FIRST, LAST, STOOD, SessionScore, StepScore, percentile
from hil.testing.parity.typed_session import TypedSession
from hil.vocab.shown_text import printable

_KEYS = {FIRST: "first_byte", LAST: "last_byte", STOOD: "end_of_motion"}
_EVENTS = ((FIRST, "first"), (LAST, "last"), (STOOD, "stands"))
_SIDES = ("board", "twin", "late")
_COMMAND, _SIDE, _LEAST_SIDE = 24, 46, 12
"""Maximum widths of a command and of one side of two answers, and its least one."""
_MARGIN = 6
"""Characters of a line beside those two sides."""
_AROUND = 2
"""Number of lines before and after one that is not the same."""
P95 = 95.0


@dataclass(frozen=True, kw_only=True)
class PlayedSession:
    """Session that was typed at a board. ``broken``: why it was broken off; empty: it was not."""

    name: str
    session: TypedSession
    score: SessionScore
    broken: str = ""
    recording: Path | None = None

    @property
    def is_equal(self) -> bool:
        return not self.broken and self.score.equal == self.score.of


def score_words(played: Sequence[PlayedSession]) -> str:
    """Sum of sessions in a line, as in ``31 of 33 commands equal, 99.1 %; times within 4.1 ms (p95)``."""
    equal, of = (sum(getattr(each.score, name) for each in played) for name in ("equal", "of"))
    percent = sum(each.score.percent * each.score.of for each in played) / max(of, 1)
    times_ms = sorted(ms for each in played for ms in each.score.times_ms)
    p95_ms = percentile(times_ms, P95)
    times = "" if p95_ms is None else f"; times within {p95_ms:.1f} ms (p95)"
    return f"{equal} of {counted(of, 'command')} equal, {percent:.1f} %{times}"


def session_blocks(played: PlayedSession, shows: bool) -> Iterator[Line | Grid]:
    """Table of a session, with its differences. ``shows``: also the answers that part, side by side."""
    score = played.score
    yield line(f"{played.name}: {score_words([played])}", wraps=True)
    if score.steps:
        yield _table(score, shows)
    if score.host_ms:
        late = f"{score.host_ms:.1f} ms after the twin's"
        yield line(
            f"  The quickest answer came {late}: that is host and adapter, and not counted.", wraps=True
        )
    for label, (ours, theirs) in score.origins.items():
        if ours != theirs:
            said = f'  "{label.strip()}" begins at {ours:g}, the twin\'s at {theirs:g}: changes count.'
            yield line(said, wraps=True)
    if played.session.board and not played.is_equal:
        has = json.dumps(dict(played.session.board))
        yield line(f"  The twin has {has}: the board should, too.", wraps=True)
    if played.broken:
        number = len(score.steps)
        where = f"at command {number} of {score.of}" if number else "before its first command"
        yield line(f"  Broken off {where}: {played.broken}", wraps=True)
    if played.recording:
        yield line(f"  Recorded: {played.recording}")


def _table(score: SessionScore, shows: bool) -> Grid:
    events = [
        event for event in _EVENTS if event[0] != STOOD or any(each.step.stands for each in score.steps)
    ]
    sides = [f"{title}\n{side}\nms" for _, title in events for side in _SIDES]
    notes = {
        number: [
            *_difference_lines(step),
            *(_side_by_side(step.match.lines) if shows and step.parting else ()),
        ]
        for number, step in enumerate(score.steps)
    }
    return Grid(
        ("", "command", "bytes", *sides, "score"),
        ("command", "bytes"),
        [_cells(each, [name for name, _ in events]) for each in score.steps],
        later=[name for name in sides if "late" not in name],
        notes=notes,
    )


def _cells(each: StepScore, events: Sequence[str]) -> list[str]:
    typed = shown(each.step.types)
    typed = f'"{typed}"' if " " in typed else typed
    command = typed if len(typed) <= _COMMAND else typed[: _COMMAND - 3] + "..."
    same = f"{len(each.board.text)} equal" if not each.parting else f"{each.match.percent:.1f} %"
    times = (cell for name in events for cell in _time_cells(each, name))
    return [str(each.number), command, same, *times, f"{each.percent:.1f} %"]


def _time_cells(each: StepScore, name: str) -> tuple[str, str, str]:
    """Times of board and twin, and how much later the board is, as that counts; ``!``: too much."""
    if found := each.times.get(name):
        mark = "" if found.is_near else "!"
        return f"{found.board_ms:.1f}", f"{found.twin_ms:.1f}", f"{found.late_ms + 0.0:+.1f}{mark}"
    if name == STOOD and each.step.stands:
        return _side_cell(each.board.stood_ms), _side_cell(each.twin.stood_ms), "!"
    return "-", "-", "-"


def _side_cell(stood_ms: float | None) -> str:
    return "never" if stood_ms is None else f"{stood_ms:.1f}"


def _difference_lines(each: StepScore) -> Iterator[str]:
    if part := each.parting:
        sides = ["nothing" if text is None else f'"{shown(text)}"' for text in (part.twin, part.board)]
        yield f"parts at byte {part.at}: expected {sides[0]}, got {sides[1]}"
    for name, apart in each.late.items():
        when = "later" if apart.late_ms > 0 else "earlier"
        yield f"{name}: {abs(apart.late_ms):.1f} ms {when} than the twin, more than {apart.within_ms:g} ms"
    if each.never_stood and each.step.stands:
        who = " and ".join(f"the {side}" for side in each.never_stood)
        yield f"{STOOD}: {who} did not stand within {each.step.stands.within_ms / 1000:g} s"


def _side_by_side(lines: Sequence[tuple[str, str, bool]]) -> Iterator[str]:
    """Lines of two answers; ``|`` between those that are not the same, with a few around them."""
    side = min(_SIDE, max((terminal_columns() or 2 * _SIDE + _MARGIN) - _MARGIN, 2 * _LEAST_SIDE) // 2)
    yield f"{'the board':{side}}   the twin"
    near = [
        any(not same for *_, same in lines[max(i - _AROUND, 0) : i + _AROUND + 1]) for i in range(len(lines))
    ]
    for (ours, theirs, same), is_near, before in zip(lines, near, [True, *near], strict=False):
        if is_near:
            sides = [shown(text)[:side] for text in (ours, theirs)]
            yield f"{sides[0]:{side}} {' ' if same else '|'} {sides[1]}".rstrip()
        elif before:
            yield "..."


def shown(text: str) -> str:
    r"""Text in a line: ends of lines and other control characters as \r, \n, \x12."""
    return printable(text.replace("\\", "\\\\"))


def session_row(played: PlayedSession) -> dict[str, Any]:
    """The same for programs."""
    score = played.score
    return {
        "session": played.name,
        "equal": played.is_equal,
        "commands_equal": score.equal,
        "commands": score.of,
        "percent": round(score.percent, 3),
        "host_ms": round(score.host_ms, 3),
        "p95_ms": _rounded(percentile(score.times_ms, P95)),
        "broken": played.broken or None,
        "recording": None if played.recording is None else str(played.recording),
        "rows": [_row(each) for each in score.steps],
    }


def _row(each: StepScore) -> dict[str, Any]:
    part = each.parting
    times: Mapping[str, Any] = {
        key: None
        if (apart := each.times.get(name)) is None
        else {
            "board_ms": round(apart.board_ms, 3),
            "twin_ms": round(apart.twin_ms, 3),
            "late_ms": round(apart.late_ms, 3),
            "within_ms": apart.within_ms,
        }
        for name, key in _KEYS.items()
    }
    return {
        "number": each.number,
        "types": each.step.types,
        "equal": each.is_equal,
        "percent": round(each.percent, 3),
        "bytes_percent": round(each.match.percent, 3),
        "parts": part and {"at": part.at, "expected": part.twin, "got": part.board},
        **times,
        "never_stood": list(each.never_stood),
        "board": each.board.text,
        "twin": each.twin.text,
    }


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 3)
