"""``docs/how-to/seeds.md``: its test at many seeds says what the page shows, in shards, too."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from markdown_blocks import blocks

PAGE = "docs/how-to/seeds.md"
TEST = "test_poll.py"


@pytest.mark.thorough
@pytest.mark.long
def test_the_page_says_what_its_test_does(tmp_path: Path) -> None:
    shown = {(each.heading, each.language): each.text for each in blocks(PAGE)}
    (tmp_path / TEST).write_text(shown[TEST, "python"])
    ways = os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"]))
    env = os.environ | {"PATH": ways, "PYTEST_ADDOPTS": "-q -p no:cacheprovider"}
    shell = {"cwd": tmp_path, "env": env, "capture_output": True, "text": True}
    done = subprocess.run(["pytest", "--hil-seeds", "200", "-n", "2"], check=False, **shell)
    assert done.returncode == 1, done.stdout + done.stderr
    assert shown[TEST, "text"] in done.stdout
    first, second, merge = shown["In shards", "bash"].splitlines()
    for line in (first, second, merge):
        done = subprocess.run(line.split(), check=False, **shell)
        assert done.returncode in (0, 1), done.stdout + done.stderr
    assert done.returncode == 1
    *told, _ = shown[TEST, "text"].splitlines(keepends=True)
    assert "".join(told) in done.stdout
    assert "200 results of 2 shards: 196 passed, 4 failed" in done.stdout
    assert "<testsuite " in (tmp_path / "junit.xml").read_text()
