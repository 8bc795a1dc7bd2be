"""The page about programs: its program, its bench and its test."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

HIL = (sys.executable, "-P", "-c", "import sys; sys.argv[0] = 'hil'; from hil.cli.entry import main; main()")
PATIENCE_S = 120

PAGE = Path(__file__).parents[1] / "docs/how-to/programs.md"


@pytest.mark.thorough
def test_the_page_is_carried_out(tmp_path: Path) -> None:
    home, config, shown, test = re.findall(r"```(?:python|yaml)?\n(.*?)```", PAGE.read_text(), re.DOTALL)[:4]
    (tmp_path / "home.py").write_text(home)
    (tmp_path / "bench.yaml").write_text(config)
    (tmp_path / "test_home.py").write_text(test)
    command, *lines = shown.splitlines()
    words = command.removeprefix("$ hil ").split()
    done = subprocess.run(
        [*HIL, *words],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
        env={"TZ": "UTC"},
    )
    assert done.stdout.splitlines()[:2] == lines[:2]
    assert len(done.stdout.splitlines()) == 10
    tested = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "test_home.py"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    assert tested.returncode == 0, tested.stdout
