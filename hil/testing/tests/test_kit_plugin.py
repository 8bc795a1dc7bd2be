"""The ``bench`` fixture, in a pytest of its own."""

import os
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

TEST = """
CONFIG = {"bench": "b", "devices": {"m1": {"profile": "mechaduino", "port": "memory"}}}

def test_it_answers(bench):
    one, two = bench(CONFIG), bench(CONFIG, seed=3)
    assert two.seed == 3
    one.run(3000)
    assert one.port("m1").read().startswith(b"\\r\\n\\r\\n----- Mechaduino 0.X -----")
    assert two.port("m1").read() == b""

def test_it_says_what_is_wrong(bench):
    bench({"bench": "b", "devices": {"m1": {"profile": "nothing", "port": "memory"}}})
"""

CLONE = Path(__file__).parents[3]


def test_tests_in_a_folder_of_the_clone_need_the_kit_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "hypothesis", None)  # as with `.[testing]` alone
    runpy.run_path(str(CLONE / "conftest.py"))


@pytest.mark.long
def test_the_fixture_makes_benches(tmp_path: Path) -> None:
    (tmp_path / "test_inner.py").write_text(TEST)
    env = os.environ | {
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
    }
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-p",
        "hil.testing.plugin",
        "-p",
        "no:cacheprovider",
        str(tmp_path),
    ]
    done = subprocess.run(command, env=env, capture_output=True, text=True, cwd=tmp_path)
    assert "1 failed, 1 passed" in done.stdout, done.stdout + done.stderr
    assert "ConfigError" in done.stdout
