"""``docs/how-to/ci.md``: its jobs, carried out without what only a CI has."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml
from e2e_support import HIL, PATIENCE_S
from markdown_blocks import blocks

from hil.cli.framework.exit_codes import Exit

PAGE = blocks("docs/how-to/ci.md")
FILES = {each.text.splitlines()[0].removeprefix("# "): each.text for each in PAGE}
PROJECT = ("bench.yaml", "test_angle.py", "moves.sh")


def github(job: str, file: str = ".github/workflows/test.yml") -> list[str]:
    steps: list[dict[str, Any]] = yaml.safe_load(FILES[file])["jobs"][job]["steps"]
    return [step["run"] for step in steps if "run" in step]


def gitlab(job: str, file: str = ".gitlab-ci.yml") -> list[str]:
    lines: list[str] = yaml.safe_load(FILES[file])[job]["script"]
    return lines


@pytest.mark.parametrize("job", ["virtual", "live"])
@pytest.mark.parametrize("lines_of", [pytest.param(github, marks=pytest.mark.thorough), gitlab])
def test_a_job(lines_of: Any, job: str, tmp_path: Path) -> None:
    for name in PROJECT:
        (tmp_path / name).write_text(FILES[name])
    install, *lines = lines_of(job)
    assert install.startswith("pip install ")
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
        "XDG_RUNTIME_DIR": str(tmp_path / "run"),
        "XDG_STATE_HOME": str(tmp_path / "state"),
    }
    with subprocess.Popen(
        ["bash", "-e", "-c", "\n".join(lines)],
        cwd=tmp_path,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as running:
        try:
            said, _ = running.communicate(timeout=3 * PATIENCE_S)
        finally:
            left = subprocess.run([HIL, "stop"], env=environment, capture_output=True, check=False)
    assert running.returncode == 0, said
    assert left.returncode == Exit.FAILED, "the bench ends with its job"
    assert ("1 passed" if job == "virtual" else "position_deg > 89 and loop_on == 1 after") in said


@pytest.mark.thorough
@pytest.mark.long
@pytest.mark.parametrize(
    ("lines_of", "file", "variables"),
    [
        (github, ".github/workflows/seeds.yml", {"SHARD": "{}"}),
        (gitlab, "seeds.gitlab-ci.yml", {"CI_NODE_INDEX": "{}", "CI_NODE_TOTAL": "4"}),
    ],
)
def test_seeds_at_night(lines_of: Any, file: str, variables: dict[str, str], tmp_path: Path) -> None:
    for name in PROJECT:
        (tmp_path / name).write_text(FILES[name])
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"

    def carried_out(job: str, number: int) -> str:
        install, line = lines_of(job, file)
        assert install.startswith("pip install ")
        own = {name: value.format(number) for name, value in variables.items()}
        done = subprocess.run(
            ["bash", "-e", "-c", line.replace("1000", "20")],
            cwd=tmp_path,
            env=os.environ | own | {"PATH": path},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    for number in range(1, 5):
        assert "5 passed" in carried_out("seeds", number)
    assert "20 results of 4 shards: 20 passed" in carried_out("merge", 0)
