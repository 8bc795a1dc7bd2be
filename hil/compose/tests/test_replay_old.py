"""Logs that an earlier version wrote, of boards with one axis and two UARTs at most, replay identically, and
the same inputs are written in the same text."""

import gzip
import io
from pathlib import Path

import pytest

from hil.compose.replay import replay_log
from hil.sim.input_log import InputLogWriter
from hil.sim.log_reading import read_input_log

OLD = sorted((Path(__file__).parent / "data").glob("*.log.gz"))


@pytest.mark.parametrize("path", OLD, ids=lambda path: path.stem)
def test_an_old_log_replays_identically(path: Path) -> None:
    read = read_input_log(io.StringIO(gzip.decompress(path.read_bytes()).decode()))
    assert len(read.inputs) >= 10
    assert replay_log(read).difference() is None


@pytest.mark.parametrize("path", OLD, ids=lambda path: path.stem)
def test_what_an_old_log_has_is_written_as_it_was(path: Path) -> None:
    lines = gzip.decompress(path.read_bytes()).decode().splitlines(keepends=True)
    read = read_input_log(lines)
    text = io.StringIO()
    writer = InputLogWriter(text, "test", {}, {})
    for logged in read.inputs:
        writer.write(logged)
    again = [line for line in text.getvalue().splitlines(keepends=True)[1:] if '"check":' not in line]
    assert again == [line for line in lines if '"input":' in line]
