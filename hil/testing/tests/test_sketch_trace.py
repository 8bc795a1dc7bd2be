"""``python -m hil.testing.sketch_trace``: what comes out of a sketch, and faults of what is given."""

import json
import shutil
from pathlib import Path

import pytest

from hil.testing.sketch_trace import main

PROGRAMS = Path(__file__).parents[2] / "core" / "tests" / "avr_programs"


def folder_of(tmp_path: Path, program: str, inputs: str = "", cycles: object = 4000) -> Path:
    folder = tmp_path / program
    folder.mkdir()
    (folder / "inputs.csv").write_text(inputs)
    (folder / "expect.json").write_text(json.dumps({"cycles": cycles}))
    shutil.copy(PROGRAMS / f"{program}.hex", folder)
    return folder


def trace_of(folder: Path, *options: str) -> list[str]:
    trace = folder / "trace.csv"
    assert main([str(folder), "-o", str(trace), *options]) == 0
    return trace.read_text().splitlines()


def test_bytes_and_edges_come_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert trace_of(folder_of(tmp_path, "serial")) == ["23,TX,97", "103,TX,98"]
    assert "times real time" in capsys.readouterr().out


def test_a_reset_by_the_watchdog_comes_out(tmp_path: Path) -> None:
    (line,) = trace_of(folder_of(tmp_path, "watching", cycles=2_000_000))
    cycle, what, cause = line.split(",")
    assert (what, cause) == ("RESET", "8")
    assert int(cycle) == pytest.approx(5 * 256_000, abs=200)


def test_inputs_go_in_and_stops_do_not_show(tmp_path: Path) -> None:
    folder = folder_of(tmp_path, "outside", "0,D4,0\n0,D8,0\n10,D9,1\n800,D8,1\n\n900,V3,2.5\n950,RX,65\n")
    whole = trace_of(folder)
    assert [line.split(",")[1:] for line in whole] == [["D7", "1"]]
    assert trace_of(folder, "--stops", "7") == whole


def test_the_hex_may_lie_beside_the_folder_or_be_named(tmp_path: Path) -> None:
    folder = folder_of(tmp_path, "serial")
    (tmp_path / "build").mkdir()
    file = (folder / "serial.hex").rename(tmp_path / "build" / "serial.hex")
    assert len(trace_of(folder)) == 2
    file = file.rename(tmp_path / "other.hex")
    assert len(trace_of(folder, "--hex", str(file))) == 2


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda folder: (folder / "serial.hex").unlink(), "has no .hex"),
        (lambda folder: shutil.copy(folder / "serial.hex", folder / "b.hex"), "has 2 files .hex"),
        (lambda folder: (folder / "serial.hex").write_text(":00000001F0\n"), "checksum"),
        (lambda folder: (folder / "inputs.csv").unlink(), "inputs.csv cannot be read"),
        (
            lambda folder: (folder / "inputs.csv").write_text("1,D2\n"),
            "inputs.csv:1: no line of cycle,what,value",
        ),
        (lambda folder: (folder / "inputs.csv").write_text("\n1,D77,0\n"), "inputs.csv:2: no pin"),
        (lambda folder: (folder / "expect.json").unlink(), "expect.json cannot be read"),
        (lambda folder: (folder / "expect.json").write_text("{"), "does not say how long it runs"),
        (
            lambda folder: (folder / "expect.json").write_text('{"cycles": -5}'),
            "does not say how long it runs",
        ),
    ],
)
def test_what_cannot_be_used_is_told(tmp_path, change, said, capsys) -> None:  # type: ignore[no-untyped-def]
    folder = folder_of(tmp_path, "serial")
    change(folder)
    assert main([str(folder), "-o", str(folder / "trace.csv")]) == 2
    assert said in capsys.readouterr().err


def test_a_trace_that_cannot_be_written_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = folder_of(tmp_path, "serial")
    assert main([str(folder), "-o", str(tmp_path / "none" / "trace.csv")]) == 2
    assert "cannot be written" in capsys.readouterr().err
