"""Lanes that there are not, in the environment of commands: a sentence, and nothing is started."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

HIL = str(Path(sys.executable).with_name("hil"))
SAID = "hil: HIL_LANES: there are no lanes 'wide': use none, any, avx2 or avx512\n"


@pytest.mark.long
def test_serve_refuses_lanes_that_there_are_not(tmp_path: Path) -> None:
    config = tmp_path / "bench.yaml"
    config.write_text("bench: b\ndevices: {m1: {profile: mechaduino, port: pty}}\n")
    folders = ("--runtime-dir", str(tmp_path / "run"), "--state-dir", str(tmp_path / "state"))
    environ = os.environ | {"HIL_LANES": "wide"}
    told = subprocess.run(
        [HIL, "serve", str(config), *folders], env=environ, capture_output=True, text=True, timeout=60
    )
    assert (told.returncode, told.stderr) == (2, SAID)
    assert not list((tmp_path / "run").glob("*/m1"))
