"""Benchmarks check what they time: a figure is that of the work which its text describes."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"
CHECKS = re.compile(r"\b(check_work\(|assert (?!\w+\.std)|raise (SystemExit|RuntimeError|TimeoutError))")
OF_A_DAEMON_AT_REST = {"idle_cpu", "memory"}
"""Benchmarks of a daemon that does nothing: there is no work to count."""


@pytest.mark.parametrize("path", sorted(BENCHMARKS.glob("[a-z]*.py")), ids=lambda path: path.stem)
def test_a_benchmark_counts_its_work(path):
    checks = re.search(
        r"\b(check_work\(|assert (?!\w+\.std)|raise (SystemExit|RuntimeError|TimeoutError))", path.read_text()
    )
    assert bool(checks) != (path.stem in OF_A_DAEMON_AT_REST)


def ended(done, expected, tolerance):
    code = f"from _report import check_work; check_work('pulses', {done}, {expected}, {tolerance})"
    return subprocess.run([sys.executable, "-c", code], cwd=BENCHMARKS, capture_output=True, text=True)


@pytest.mark.parametrize("done", [95, 105, 0])
def test_other_work_ends_a_benchmark(done):
    told = ended(done, 100, 0.04)
    assert told.returncode == 1
    assert told.stderr == f"pulses: {done} instead of 100: a figure would be that of other work\n"


def test_the_work_that_is_meant_goes_on():
    assert ended(97, 100, 0.04).returncode == 0
