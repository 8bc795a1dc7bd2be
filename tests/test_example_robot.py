"""The example suite of Robot Framework, alone and side by side."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("robot", reason="Robot Framework is not installed")
FOLDER = Path(__file__).parents[1] / "examples" / "robot"


def run(folder: Path, *command: str) -> str:
    programs = f"{Path(sys.executable).parent}:{os.environ['PATH']}"  # pabot starts robot by its name
    done = subprocess.run(
        ["env", f"PATH={programs}", *command],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_suite_passes_from_any_folder(tmp_path: Path) -> None:
    said = run(tmp_path, "robot", "--xunit", "x.xml", str(FOLDER))
    assert "5 tests, 5 passed, 0 failed" in said
    assert 'tests="5"' in (tmp_path / "x.xml").read_text()
    assert {"log.html", "report.html"} <= {path.name for path in tmp_path.iterdir()}


@pytest.mark.thorough
@pytest.mark.long
@pytest.mark.parametrize("kind", ["virtual", "live"])
def test_tests_run_side_by_side(tmp_path: Path, kind: str) -> None:
    pytest.importorskip("pabot", reason="pabot is not installed")
    said = run(
        tmp_path,
        "pabot",
        "--no-pabotlib",
        "--testlevelsplit",
        "--processes",
        "3",
        "--variable",
        f"KIND:{kind}",
        str(FOLDER),
    )
    assert "5 tests, 5 passed, 0 failed" in said
