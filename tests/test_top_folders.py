"""Checks that every list of the folders with code has all of them."""

import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
TOPS = {init.parent.name for init in ROOT.glob("*/__init__.py")}
CONFIGURED = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]
LISTS = {
    "mypy reads": CONFIGURED["mypy"]["files"],
    "the import rules read": CONFIGURED["importlinter"]["root_packages"],
    "pytest looks into": CONFIGURED["pytest"]["ini_options"]["testpaths"],
    "a wheel has": [
        each.removesuffix("*") for each in CONFIGURED["setuptools"]["packages"]["find"]["include"]
    ],
    "the image has": [line.removeprefix("!") for line in (ROOT / ".dockerignore").read_text().splitlines()],
}


@pytest.mark.parametrize("what", LISTS)
def test_no_folder_is_left_out(what: str) -> None:
    assert len(TOPS) >= 4
    assert sorted(TOPS - set(LISTS[what])) == []
