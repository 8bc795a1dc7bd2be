"""A project with tests that fail at some seeds, and pytest in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

TESTS = """
LINE = {
    "bench": "line",
    "devices": {"s1": {"profile": "sac"}, "s2": {"profile": "sac"}},
    "segments": {"bus0": {"stations": ["s1", "s2"], "taps": {"master": {"port": "memory"}}, "baud": 38400}},
    "faults": [{"fault": "wire_noise", "target": "bus0", "rate": 0.00001}],
}


def test_answer(bench):
    b = bench(LINE)
    b.fault("byte_delay", "s1", rate=0.5)
    b.fault("byte_flip", "s2", rate=0.001)
    b.fault("byte_flip", "s1", rate=0.001)
    b.run(ms=1200)
    with open("bytes.txt", "a") as file:
        file.write(f"{b.seed} {b.port('s1').read().hex()}\\n")
    b.port("s1").write(b"v\\r")
    b.run(ms=500)
    assert b"SAC>" in b.port("s1").read()


def test_without(bench):
    b = bench(LINE)
    assert b.seed % 10 != 3


def test_seed(bench, hil_seed):
    assert bench(LINE).seed == hil_seed


def test_plain():
    pass
"""


def make_project(folder: Path, tests: str = TESTS) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "test_line.py").write_text(tests)
    return folder


def pytest_in(folder: Path, *options: str, code: int | None = 0, hash_seed: str = "random") -> str:
    """Run the tests of a folder in a process of its own; answers what it said. ``code``: its exit code; None:
    tests passed, or some failed."""
    env = os.environ | {
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        "PYTHONHASHSEED": hash_seed,
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
    }
    plugins = ("-p", "hil.testing.plugin", "-p", "xdist", "-p", "no:cacheprovider", "--rootdir", ".")
    command = [sys.executable, "-m", "pytest", "-q", *plugins, *options]
    done = subprocess.run(command, env=env, capture_output=True, text=True, cwd=folder, check=False)
    assert done.returncode in ((0, 1) if code is None else (code,)), done.stdout + done.stderr
    return done.stdout + done.stderr
