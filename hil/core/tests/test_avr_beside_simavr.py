"""Random programs for the ATmega328P, compared with simavr after each instruction.

``HIL_FUZZ`` sets how many programs are tried (20,000; ``make fuzz``: a million), ``HIL_FUZZ_SEED`` where they
start. What simavr 1.6 gets wrong is set right there and counted; docs/decisions/0067 lists it. One program
again, with each of its instructions: ``programs_beside_simavr SEED 1 NUMBER`` in build/simavr of the C tests.
"""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1] / "native/tests"
PROGRAMS = os.environ.get("HIL_FUZZ", "20000")
SEED = os.environ.get("HIL_FUZZ_SEED", "1")
KNOWN = "1.6"
"""Version of simavr whose mistakes are known here: Debian 12's."""


def version() -> str:
    """Version of simavr's library that C can be compiled with; none: empty."""
    if not shutil.which("pkg-config"):
        return ""
    command = ["pkg-config", "--modversion", "simavr"]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()


@pytest.mark.long
@pytest.mark.skipif(
    version() != KNOWN, reason=f"simavr {KNOWN} is not installed: sudo apt install libsimavr-dev pkg-config"
)
def test_random_programs_are_equal() -> None:
    subprocess.run(["make", "-s", "--no-print-directory", "-C", TESTS, "simavr"], check=True)
    command = [TESTS / "build/simavr/programs_beside_simavr", SEED, PROGRAMS]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    print(done.stdout)
    assert done.returncode == 0, done.stdout
    assert f"{PROGRAMS} programs, " in done.stdout
    (entered,) = re.findall(r"(\d+) times: interrupts entered", done.stdout)
    assert int(entered) > int(PROGRAMS) // 20
