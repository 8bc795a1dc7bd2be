"""``examples/tmcl``: a bus outside of hil, whose own tests pass with the package installed."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
FOLDER = EXAMPLES / "tmcl"


def installed_in(folder: Path) -> dict[str, str]:
    """Environment in which the package is installed: its entry points stand below a folder."""
    project = tomllib.loads((FOLDER / "pyproject.toml").read_text())["project"]
    info = folder / "tmcl_bus-0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: 0\n")
    lines = []
    for group, points in project["entry-points"].items():
        lines += [f"[{group}]", *(f"{name} = {package}" for name, package in points.items())]
    (info / "entry_points.txt").write_text("\n".join(lines) + "\n")
    return {**os.environ, "PYTHONPATH": os.pathsep.join((str(folder), str(FOLDER)))}


@pytest.mark.thorough
def test_its_own_tests_pass(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", FOLDER]
    done = subprocess.run(
        command, env=installed_in(tmp_path), capture_output=True, text=True, timeout=170, check=False
    )
    (told,) = re.findall(r"`pytest examples/tmcl`: (\d+ passed)", (EXAMPLES / "README.md").read_text())
    assert told in done.stdout, done.stdout
