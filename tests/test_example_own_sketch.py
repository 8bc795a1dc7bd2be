"""``examples/own_sketch``: its own tests pass; those of sketches where they can be built."""

import re
import subprocess
import sys
from pathlib import Path

from sketch_preparations import need_toolchain

EXAMPLES = Path(__file__).parents[1] / "examples"


def run_tests(name: str) -> str:
    """Run tests of the example; answers their last line."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", EXAMPLES / "own_sketch" / name]
    done = subprocess.run(command, capture_output=True, text=True, timeout=170, check=False)
    assert done.returncode == 0, done.stdout
    return done.stdout.splitlines()[-1]


def test_kept_programs_need_no_compiler() -> None:
    assert "failed" not in run_tests("test_bare_programs.py")


def test_all_pass() -> None:
    need_toolchain()
    (told,) = re.findall(r"`pytest examples/own_sketch`: (\d+ passed)", (EXAMPLES / "README.md").read_text())
    assert told in run_tests("")
