"""Plays the dialogues of ``transcripts/``; their README says what a file holds."""

import json
from pathlib import Path
from typing import Any

import pytest

from device_profiles.mechaduino.firmware import COMMANDS
from hil.testing import Bench

FILES = sorted((Path(__file__).parent.parent / "transcripts").glob("*.json"))
TRANSCRIPTS: list[dict[str, Any]] = [json.loads(path.read_text()) for path in FILES]
LONG_OUTPUTS = frozenset("qgja")
"""Commands whose output is checked in ``test_long_outputs.py`` only."""


def play(transcript: dict[str, Any], bytewise: bool = False) -> list[list[object]]:
    """Play a transcript, and return what the board sends in the form of ``expected``. ``bytewise``: each
    input byte in a write of its own."""
    board = transcript["board"]
    device = {
        "profile": "mechaduino",
        "port": "memory",
        "flash": {"table": board.get("table", "identity")},
        "registers": {name: int(board[name], 16) for name in ("diaagc", "errfl") if name in board},
        "spi_previous_command": int(board.get("spi_previous_command", "FFFF"), 16),
    }
    bench = Bench({"bench": "transcript", "devices": {"m1": device}})
    port = bench.port("m1")
    bench.axis("m1").script_encoder(board.get("encoder", [[0, 4000]]), board.get("encoder_interp", "hold"))
    for t_ms, text in transcript["input"]:
        bench.run_until(ms=t_ms)
        data = text.encode("latin-1")
        for piece in [data[i : i + 1] for i in range(len(data))] if bytewise else [data]:
            port.write(piece)
    bench.run_until(ms=transcript["end_ms"])
    assert bench.device("m1").failed is None
    from_ns = transcript["from_ms"] * 1_000_000
    return [[at_ns / 1e6, data.decode("latin-1")] for at_ns, data in port.read_timed() if at_ns >= from_ns]


@pytest.mark.parametrize("transcript", TRANSCRIPTS, ids=lambda transcript: transcript["name"])
def test_the_board_answers_as_the_transcript_says(transcript: dict[str, Any]) -> None:
    assert play(transcript) == transcript["expected"]


@pytest.mark.parametrize("transcript", TRANSCRIPTS, ids=lambda transcript: transcript["name"])
def test_bytes_of_one_time_may_come_one_by_one(transcript: dict[str, Any]) -> None:
    assert play(transcript, bytewise=True) == transcript["expected"]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_transcript_keeps_to_the_format(path: Path) -> None:
    transcript = json.loads(path.read_text())
    assert list(transcript) == [
        "name", "note", "source", "board", "from_ms", "input", "end_ms", "expected"
    ]  # fmt: skip
    assert transcript["name"] == path.stem
    assert transcript["note"]
    assert transcript["source"]
    assert path.stat().st_size < 8192
    for rows in (transcript["input"], transcript["expected"]):
        times = [t_ms for t_ms, _ in rows]
        assert times == sorted(times)
        assert all(t_ms <= transcript["end_ms"] for t_ms in times)


def test_every_command_is_in_a_transcript_or_has_a_long_output() -> None:
    typed = {byte for transcript in TRANSCRIPTS for _, text in transcript["input"] for byte in text}
    assert {command.letter for command in COMMANDS} - LONG_OUTPUTS <= typed
