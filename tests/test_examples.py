"""Every example prints what stands beside it."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
PROGRAMS = sorted(path for path in EXAMPLES.glob("*.py") if path.stem != "board")


def test_every_program_is_in_the_table() -> None:
    table = (EXAMPLES / "README.md").read_text()
    assert len(PROGRAMS) >= 6
    assert all(f"[{path.name}]({path.name})" in table for path in PROGRAMS)


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: path.stem)
def test_it_prints_what_stands_beside_it(program: Path) -> None:
    done = subprocess.run([sys.executable, program], capture_output=True, text=True, timeout=60, check=False)
    assert done.stderr == ""
    assert done.stdout == program.with_suffix(".txt").read_text()


def test_the_run_of_six_axes_prints_what_stands_beside_it_and_draws_them(tmp_path: Path) -> None:
    program, picture = EXAMPLES / "runs" / "six_axes.py", tmp_path / "run.png"
    done = subprocess.run([sys.executable, program, picture], capture_output=True, text=True, timeout=60)
    assert done.stderr == ""
    assert done.stdout == program.with_suffix(".txt").read_text()
    assert picture.stat().st_size > 50_000


@pytest.mark.thorough
def test_the_run_with_a_real_board_prints_what_stands_beside_it() -> None:
    """The output is the same but for where real time puts the twins' samples."""
    program = EXAMPLES / "runs" / "mixed.py"
    done = subprocess.run([sys.executable, program], capture_output=True, text=True, timeout=90)
    assert done.stderr == ""
    said, wanted = (
        re.sub(r"(?<=: stands at )(?=-?\d)\S+|(?<=at most )[0-9.]+|(?<=rms )[0-9.]+", "#", text)
        for text in (done.stdout, program.with_suffix(".txt").read_text())
    )
    assert said == wanted


@pytest.mark.thorough
def test_the_tuning_draws_both_responses(tmp_path: Path) -> None:
    picture = tmp_path / "tuning.svg"
    subprocess.run(
        [sys.executable, EXAMPLES / "tuning.py", picture], check=True, timeout=60, capture_output=True
    )
    assert {"<!-- factory: yw [deg] -->", "<!-- tuned: yw [deg] -->"} <= set(
        line.strip() for line in picture.read_text().splitlines()
    )


@pytest.mark.thorough
def test_the_bus_masters_own_tests_pass() -> None:
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", EXAMPLES / "bus_master"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=170, check=False)
    (told,) = re.findall(r"`pytest examples/bus_master`: (\d+ passed)", (EXAMPLES / "README.md").read_text())
    assert told in done.stdout, done.stdout
