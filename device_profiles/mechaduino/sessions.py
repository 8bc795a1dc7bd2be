"""Recorded sessions with a Mechaduino: as reference data have them, and as this folder's transcripts do."""

import re
from collections.abc import Mapping
from typing import Any

from device_profiles.mechaduino import text
from hil.vocab.recorded_session import Digest, SessionPlan, TimedText

_FROM_MS = 4000.0
"""Time from which text counts where the start-up is left out."""
_TOLERANCE_MS = 2.0
_TABLES = {"identity": "identity", "empty": "empty", "zero": "empty"}
_OWN_WORDS = frozenset(
    line.strip()
    for lines in (
        text.SINE_INTRO,
        (text.SINE_INTRO[1], text.DIAGNOSTICS_INTRO[1], text.DIAGNOSTICS_INTRO[2]),
        text.DIAAGC_LINES.values(),
        text.ERRFL_LINES.values(),
    )
    for line in lines
    if line.strip()
)
"""Lines of explanation, in our own words."""


def session_plan(session: Mapping[str, Any]) -> SessionPlan | None:
    """Plan of a session of either form; None: it is of something else."""
    if {"setup", "input", "end_ms", "boot_included"} <= session.keys():
        return _reference_plan(session)
    if {"board", "input", "expected", "from_ms", "end_ms"} <= session.keys():
        expected, from_ms = _timed(session["expected"]), float(session["from_ms"])
        return _plan(session["board"], session, {"": expected}, from_ms, {})
    return None


def _reference_plan(session: Mapping[str, Any]) -> SessionPlan:
    from_ms = 0.0 if session["boot_included"] else _FROM_MS
    if "timeline" in session:
        return _plan(session["setup"], session, {"": _timed(session["timeline"])}, from_ms, {})
    digest = Digest(
        size_bytes=int(session["output_bytes"]),
        sha256=str(session["output_sha256"]),
        head=str(session["output_head"]),
        tail=str(session["output_tail"]),
    )
    return _plan(session["setup"], session, {}, from_ms, {"": digest})


def _plan(
    board: Mapping[str, Any],
    session: Mapping[str, Any],
    timelines: Mapping[str, list[TimedText]],
    from_ms: float,
    digests: Mapping[str, Digest],
) -> SessionPlan:
    flash: dict[str, Any] = {"table": _TABLES[board.get("table", "identity")]}
    if "lookup_address" in board:
        flash["address"] = int(board["lookup_address"], 16)
    device = {
        "profile": "mechaduino",
        "flash": flash,
        "registers": {name: int(board[name], 16) for name in ("diaagc", "errfl") if name in board},
        "spi_previous_command": int(board.get("spi_previous_command", "FFFF"), 16),
    }
    points = [(float(t_ms), int(count)) for t_ms, count in board.get("encoder", [[0, 4000]])]
    return SessionPlan(
        device=device,
        inputs=_timed(session["input"]),
        end_ms=float(session["end_ms"]),
        timelines=timelines,
        digests=digests,
        from_ms=from_ms,
        encoder=(points, board.get("encoder_interp", "hold") == "linear"),
        tolerance_ms=_TOLERANCE_MS,
        is_own_words=is_own_words,
    )


def is_own_words(line: str) -> bool:
    """True if a line is explanation, in our own words."""
    return line.strip() in _OWN_WORDS or bool(re.search(re.escape(text.K_HINT), line))


def _timed(rows: list[tuple[float, str]]) -> list[TimedText]:
    return [(float(at_ms), str(said)) for at_ms, said in rows]
