"""``examples/own_board``, ``relay_board`` and ``instruments``: their own tests pass, without a compiler."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"


@pytest.mark.thorough
@pytest.mark.parametrize("example", ["own_board", "relay_board", "instruments"])
def test_all_pass(example: str) -> None:
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", EXAMPLES / example]
    done = subprocess.run(command, capture_output=True, text=True, timeout=170, check=False)
    assert done.returncode == 0, done.stdout
    (told,) = re.findall(rf"`pytest examples/{example}`: (\d+) passed", (EXAMPLES / "README.md").read_text())
    passed, skipped = (
        sum(map(int, re.findall(rf"(\d+) {word}", done.stdout))) for word in ("passed", "skipped")
    )
    assert passed + skipped == int(told)
