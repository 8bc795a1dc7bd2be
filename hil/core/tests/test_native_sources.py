"""Checks that all C of the project is compiled, and tried under the sanitizers: no list leaves a file out."""

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[3]
TOPS = [init.parent for init in ROOT.glob("*/__init__.py")]
EXTENSIONS = """
import json, setuptools
from distutils.core import run_setup
made = run_setup("setup.py", stop_after="init").ext_modules
print(json.dumps([source for each in made for source in each.sources if source.endswith(".c")]))
"""


def sources() -> set[str]:
    """Every ``.c`` that is written by hand, without tests."""
    files = [file for top in TOPS for file in top.rglob("*.c")]
    by_hand = [file for file in files if not file.with_suffix(".pyx").is_file() and "tests" not in file.parts]
    return {file.relative_to(ROOT).as_posix() for file in by_hand}


def test_all_c_is_below_a_folder_native() -> None:
    assert len(sources()) > 40
    assert [file for file in sources() if "/native/" not in file] == []


def test_all_c_is_in_an_extension() -> None:
    command = [sys.executable, "-W", "ignore", "-c", EXTENSIONS]
    said = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert set(json.loads(said.splitlines()[-1])) == sources()


def test_all_c_is_under_the_sanitizers() -> None:
    command = ["make", "-s", "--no-print-directory", "-C", "hil/core/native/tests", "sources"]
    said = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert set(said.split()) == sources()


def test_each_folder_of_c_has_tests_in_c() -> None:
    folders = {ROOT / file[: file.index("/native/")] / "native" for file in sources()}
    assert [folder for folder in sorted(folders) if not list(folder.glob("tests/*.c"))] == []
