"""Second tries are said, and too many fail: in the browser tests and in all others."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from markdown_blocks import ROOT

RUNNER = ROOT / "tests/browser/run_twice.py"
TESTS = """
from pathlib import Path
import pytest

@pytest.mark.parametrize("number", range({count}))
def test_one(number):
    seen = Path(__file__).with_name(f"seen{{number}}")
    again, _ = seen.exists(), seen.touch()
    assert again or number >= {flaky}
    assert number != {broken}
"""
PLAIN = os.environ | {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "PYTEST_ADDOPTS": "-p xdist.plugin"}
"""Environment of these tests, which want nothing of hil: each process of theirs imports it otherwise."""


def last_line(folder: Path, *, count: int = 40, flaky: int = 0, broken: int = -1) -> tuple[int, str]:
    """Exit code and last line of a run of tests: the first ``flaky`` fail once, ``broken`` always."""
    (folder / "test_them.py").write_text(TESTS.format(count=count, flaky=flaky, broken=broken))
    done = subprocess.run(
        [sys.executable, str(RUNNER), "test_them.py"],
        cwd=folder,
        env=PLAIN,
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout.splitlines()[-1]


def test_all_at_the_first_try(tmp_path: Path) -> None:
    assert last_line(tmp_path) == (0, "All 40 passed at the first try.")


@pytest.mark.thorough
def test_one_at_the_second_try_is_named(tmp_path: Path) -> None:
    said = "1 of 40 passed at the second try: test_them.py::test_one[0]"
    assert last_line(tmp_path, flaky=1) == (0, said)


def test_more_than_three_in_a_hundred_fail(tmp_path: Path) -> None:
    code, said = last_line(tmp_path, flaky=2)
    assert (code, said.startswith("2 of 40 passed at the second try: ")) == (1, True)
    assert said.endswith("That is more than 3%: mend what they wait for.")


@pytest.mark.thorough
def test_one_that_fails_twice_fails(tmp_path: Path) -> None:
    assert last_line(tmp_path, flaky=1, broken=7)[0] == 1


@pytest.mark.parametrize(("flaky", "code"), [(1, 0), (11, 1)])
def test_of_all_tests_ten_may_need_a_second_try(tmp_path: Path, flaky: int, code: int) -> None:
    (tmp_path / "test_them.py").write_text(TESTS.format(count=40, flaky=flaky, broken=-1))
    shutil.copy(ROOT / "conftest.py", tmp_path)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "--reruns", "1", "-rR", "-p", "pytest_rerunfailures"],
        cwd=tmp_path,
        env=PLAIN,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == code
    assert f"40 passed, {flaky} rerun" in done.stdout.splitlines()[-1]
    assert ("11 tests needed a second try; 10 may." in done.stdout) == bool(code)
