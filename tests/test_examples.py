"""Every example prints what stands beside it."""

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


def test_the_tuning_draws_both_responses(tmp_path: Path) -> None:
    picture = tmp_path / "tuning.svg"
    subprocess.run(
        [sys.executable, EXAMPLES / "tuning.py", picture], check=True, timeout=60, capture_output=True
    )
    assert {"<!-- factory: yw [deg] -->", "<!-- tuned: yw [deg] -->"} <= set(
        line.strip() for line in picture.read_text().splitlines()
    )


def test_the_bus_masters_own_tests_pass() -> None:
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", EXAMPLES / "bus_master"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=170, check=False)
    assert "4 passed" in done.stdout, done.stdout
