"""The test of ``docs/how-to/write-a-test.md`` that runs in memory, live, and at a real board."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from markdown_blocks import blocks

from hil.testing import live

pytestmark = pytest.mark.long  # they start daemons

HEADING = "The same test on the real board"
PAGE = {each.language: each.text for each in blocks("docs/how-to/write-a-test.md") if each.heading == HEADING}


def said(folder: Path, kind: str) -> str:
    (folder / "test_page.py").write_text(PAGE["python"])
    paths = os.pathsep.join(filter(None, sys.path))
    env = os.environ | {"PYTHONPATH": paths, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    plugins = ("-p", "hil.testing.plugin", "-p", "no:cacheprovider")
    command = [sys.executable, "-m", "pytest", "-q", *plugins, f"--hil={kind}", "test_page.py"]
    done = subprocess.run(command, env=env, capture_output=True, text=True, cwd=folder, check=False)
    return done.stdout + done.stderr


@pytest.mark.thorough
def test_all_pass_in_memory_and_live(tmp_path: Path) -> None:
    for kind in ("virtual", "live"):
        text = said(tmp_path, kind)
        assert "3 passed" in text, text
        assert "hil: " not in text


@pytest.mark.thorough
def test_at_a_real_board_one_is_skipped_as_the_page_shows(tmp_path: Path) -> None:
    with live({"bench": "desk", "devices": {"s1": {"profile": "sac"}}}, capture=False) as board:
        (tmp_path / "rig.yaml").write_text(PAGE["yaml"].replace("/dev/ttyUSB0", board.port("s1")))
        text = said(tmp_path, "rig.yaml")
    shown = PAGE["text"]
    assert shown.startswith("hil: 1 test skipped")
    assert shown in text
    assert "2 passed, 1 skipped" in text
