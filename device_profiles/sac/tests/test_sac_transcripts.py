"""Plays the dialogues of ``transcripts/``; their README says what a file holds."""

from pathlib import Path
from typing import Any

import pytest
import yaml

from device_profiles.sac.command_line import COMMANDS
from hil.testing import Bench

FILES = sorted((Path(__file__).parent.parent / "transcripts").glob("*.yaml"))
EVENTS = {"type", "reset", "pin", "wait"}


def read(path: Path) -> dict[str, Any]:
    """A transcript, with its equal rows written out."""
    transcript: dict[str, Any] = yaml.safe_load(path.read_text())
    for step in transcript["steps"]:
        step["answer"] = [line for entry in step["answer"] for line in written_out(entry)]
    return transcript


def written_out(entry: str | dict[str, Any]) -> list[str]:
    if isinstance(entry, str):
        return [entry]
    first, last = entry["rows"]
    return [f"{number}{entry['each']}" for number in range(first, last + 1)]


TRANSCRIPTS = [read(path) for path in FILES]


def answers(transcript: dict[str, Any], bytewise: bool = False) -> list[dict[str, Any]]:
    """The steps with what the board does. ``bytewise``: each input byte in a write of its own."""
    bench = Bench({"bench": "transcript", "devices": {"s1": {"profile": "sac", "port": "memory"}}})
    port, device, axis = bench.port("s1"), bench.device("s1"), bench.axis("s1")
    played = []
    for step in transcript["steps"]:
        match step:
            case {"type": text}:
                data = text.encode("latin-1")
                for piece in [data[i : i + 1] for i in range(len(data))] if bytewise else [data]:
                    port.write(piece)
            case {"reset": True}:
                device.reset()
            case {"pin": [name, level]}:
                device.pin(name).set(level)
        bench.run(ms=step["for_ms"])
        now = step | {"answer": port.read().decode("latin-1").split("\r\n")}
        if "pulses" in step:
            now["pulses"] = axis.snapshot().pulses
        played.append(now)
    assert device.failed is None
    bench.close()
    return played


@pytest.mark.parametrize("transcript", TRANSCRIPTS, ids=lambda transcript: transcript["name"])
def test_the_board_answers_as_the_transcript_says(transcript: dict[str, Any]) -> None:
    assert answers(transcript) == transcript["steps"]


@pytest.mark.parametrize("transcript", TRANSCRIPTS, ids=lambda transcript: transcript["name"])
def test_bytes_of_one_time_may_come_one_by_one(transcript: dict[str, Any]) -> None:
    assert answers(transcript, bytewise=True) == transcript["steps"]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_transcript_keeps_to_the_format(path: Path) -> None:
    transcript = yaml.safe_load(path.read_text())
    assert list(transcript) == ["name", "note", "source", "steps"]
    assert transcript["name"] == path.stem
    assert transcript["note"]
    assert transcript["source"]
    for step in transcript["steps"]:
        assert len(EVENTS & set(step)) == 1
        assert set(step) <= EVENTS | {"for_ms", "answer", "pulses"}


def test_every_command_is_in_a_transcript() -> None:
    typed = [step["type"] for t in TRANSCRIPTS for step in t["steps"] if "type" in step]
    lines = {line for text in typed for line in text.replace("\n", "\r").split("\r")}
    firsts = {line[0] for line in lines if line}
    assert all(firsts & set(command.letters) for command in COMMANDS)
    assert {line[1] for line in lines if line.startswith("$") and len(line) > 1} >= set("CEFHKLOPRUn")
