"""``hil gcode`` over the line of a running bench: programs that end, are stopped, paused, and fail."""

import json
import os
import pty
import select
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from hil.testing import LiveError, ServedBench, live

pytestmark = pytest.mark.long
EXAMPLES = Path(__file__).parents[3] / "examples" / "line"
PROGRAM = "import sys; sys.argv[0] = 'hil'; from hil.cli.entry import main; main()"
PATIENCE_S = 60.0
TOUR = "G21 G90 G64 F1200\nG1 X8\nY6\nG3 X2 Y6 I-3\nG1 X0 Y0\nM2\n"
LONG = "G21 G90 F600\nG1 " + "\n".join(f"X{n * 0.8:.1f} Y{n % 2 * 0.2:.1f}" for n in range(1, 120)) + "\nM2\n"
DEG_PER_MM = 40 * 1.8


@pytest.fixture(scope="module")
def bench() -> Iterator[ServedBench]:
    with live(EXAMPLES / "line.yaml") as made:
        for number, name in ((4, "x4"), (5, "y5"), (6, "z6")):
            made.type(name, b"$CM%d\r" % number, b"$R\r", until=b"SAC>")
        yield made


@pytest.fixture(autouse=True)
def at_zero(bench: ServedBench) -> None:
    """Each program begins where its machine's axes are at 0: the boards count from there."""
    for name in ("x4", "y5", "z6"):
        bench.hil("zero", name)


def words(bench: ServedBench, folder: Path, text: str, *more: str) -> list[str]:
    file = folder / "made.ngc"
    file.write_text(text)
    where = ("--machine", str(EXAMPLES / "mill.yaml"), "--bench", "line")
    return ["gcode", str(file), *where, *more]


def turned_mm(bench: ServedBench, name: str) -> float:
    return float(bench.ask("state", device=name)["position_deg"]) / DEG_PER_MM


@pytest.mark.thorough
def test_a_program_is_carried_out_and_tells_where_each_axis_stands(
    bench: ServedBench, tmp_path: Path
) -> None:
    text = TOUR.replace("X0 Y0\nM2", "X1.5 Y0.25\nG4 P0.1\nM2")
    said = json.loads(bench.hil(*words(bench, tmp_path, text, "--json"), timeout_s=PATIENCE_S))
    run = said["run"]
    assert (run["state"], run["why"]) == ("ended", "")
    assert {row["axis"]: row["position"] for row in run["axes"]} == {"x": 1.5, "y": 0.25, "z": 0.0}
    assert said["duration_s"] < run["took_s"] < said["duration_s"] + 5
    assert turned_mm(bench, "x4") == pytest.approx(1.5, abs=0.02)
    assert turned_mm(bench, "y5") == pytest.approx(0.25, abs=0.02)


def going_on(bench: ServedBench, folder: Path, terminal: int | None = None) -> "subprocess.Popen[bytes]":
    command = [*words(bench, folder, LONG), "--runtime-dir", str(bench.folder / "run")]
    command += [] if terminal is not None else ["--json"]
    given = {"stdin": terminal, "stderr": terminal} if terminal is not None else {"stderr": subprocess.PIPE}
    return subprocess.Popen([sys.executable, "-P", "-c", PROGRAM, *command], stdout=subprocess.PIPE, **given)


def until_it_moves(bench: ServedBench, program: "subprocess.Popen[bytes]", beyond_mm: float = 0.5) -> None:
    deadline_s = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline_s and program.poll() is None:
        if turned_mm(bench, "x4") > beyond_mm:
            return
    raise AssertionError("nothing has moved")


def test_ctrl_c_stops_along_the_path_and_the_place_is_known(bench: ServedBench, tmp_path: Path) -> None:
    with going_on(bench, tmp_path) as program:
        until_it_moves(bench, program)
        program.send_signal(signal.SIGINT)
        out, _ = program.communicate(timeout=PATIENCE_S)
    assert program.returncode == 130
    run = json.loads(out)["run"]
    assert run["state"] == "stopped"
    places = {row["axis"]: row["position"] for row in run["axes"]}
    assert 0.5 < places["x"] < 90
    assert turned_mm(bench, "x4") == pytest.approx(places["x"], abs=0.05)
    assert turned_mm(bench, "y5") == pytest.approx(places["y"], abs=0.05)


def test_keys_change_the_feed_pause_and_stop(bench: ServedBench, tmp_path: Path) -> None:
    ours, theirs = pty.openpty()
    with going_on(bench, tmp_path, theirs) as program:
        os.close(theirs)
        until_it_moves(bench, program)  # and nobody takes what the bar writes
        os.write(ours, b"++")
        seen = until_shown(ours, b"120%")
        os.write(ours, b"p")
        seen += until_shown(ours, b"paused")
        rest_mm = turned_mm(bench, "x4")
        time.sleep(0.3)  # a pause that moves would show
        assert turned_mm(bench, "x4") == pytest.approx(rest_mm, abs=0.05)
        os.write(ours, b"p")
        until_it_moves(bench, program, rest_mm + 0.5)
        os.write(ours, b"S")
        out = b""
        while piece := program.stdout.read(1000) if program.stdout else b"":
            out += piece
        drain(ours)
        program.wait(PATIENCE_S)
    os.close(ours)
    assert b"p pauses and resumes" in seen
    assert program.returncode == 5
    assert "where it stands is not known, about" in out.decode()


def until_shown(terminal: int, wanted: bytes) -> bytes:
    seen, deadline_s = b"", time.monotonic() + PATIENCE_S
    while wanted not in seen:
        assert time.monotonic() < deadline_s, seen[-500:]
        seen += drain(terminal, 0.2)
    return seen


def drain(terminal: int, wait_s: float = 0.0) -> bytes:
    seen = b""
    while select.select([terminal], [], [], wait_s)[0]:
        try:
            seen += os.read(terminal, 65536)
        except OSError:
            break
        wait_s = 0.0
    return seen


@pytest.mark.thorough
def test_a_node_that_does_not_answer_is_told_before_anything_moves(
    bench: ServedBench, tmp_path: Path
) -> None:
    bench.type("y5", b"$CM77\r", b"$R\r", until=b"SAC>")
    with pytest.raises(LiveError, match=r"exit code 1\n(?s:.*)no answer of node 5 \(Y\); nothing has moved"):
        bench.hil(*words(bench, tmp_path, TOUR), timeout_s=PATIENCE_S)
    bench.type("y5", b"$CM5\r", b"$R\r", until=b"SAC>")
    assert turned_mm(bench, "x4") == pytest.approx(0, abs=0.02)
