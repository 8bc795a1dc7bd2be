"""Reference and man page: what the program prints, and all that the code has."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from hil.cli.documents.command_page import command_page
from hil.cli.documents.command_tree import commands
from hil.cli.documents.completion import SHELLS
from hil.cli.documents.man import man_page
from hil.cli.documents.reference import reference
from hil.cli.documents.surroundings import ENVIRONMENT
from hil.cli.framework.command_group import app

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "reference.md"
MAN = ROOT / "docs" / "hil.1"
READ = re.compile(r"(?:env(?:iron)?(?:\.get\(|\[)|_service_directory\(|_chosen\([\w, ]+)\"(\w+)\"")


def test_the_reference_is_up_to_date() -> None:
    assert PAGE.read_text() == reference(app), "run: make reference"


def test_the_page_of_commands_is_up_to_date() -> None:
    assert (ROOT / "docs" / "commands.md").read_text() == command_page(app), "run: make reference"


def test_the_man_page_is_up_to_date() -> None:
    assert MAN.read_text() == man_page(app), "run: make reference"


def test_completions_are_up_to_date() -> None:
    files = {"bash": "hil.bash", "zsh": "_hil", "fish": "hil.fish"}
    assert set(files) == set(SHELLS)
    for shell, name in files.items():
        assert (ROOT / "completions" / name).read_text() == SHELLS[shell](commands(app)), (
            "run: make reference"
        )


def test_the_man_page_is_well_formed() -> None:
    if not shutil.which("mandoc"):
        pytest.skip("no mandoc here")
    done = subprocess.run(["mandoc", "-Tlint", "-Wwarning", MAN], capture_output=True, text=True, check=False)
    # A date would change with each commit.
    problems = [line for line in done.stdout.splitlines() if "missing date" not in line]
    assert problems == []


def test_the_man_page_shows_as_text_what_the_command_line_has() -> None:
    if not shutil.which("mandoc"):
        pytest.skip("no mandoc here")
    done = subprocess.run(["mandoc", "-Tascii", "-Owidth=300", MAN], capture_output=True, check=True)
    shown = re.sub(r".\x08", "", done.stdout.decode())
    for command in commands(app).all():
        assert f"hil {command.name}".strip() in shown
        for option in command.options:
            assert all(re.search(rf"^ +(-.*, )?{flag}\b", shown, re.M) for flag in option.flags), option


def test_every_variable_that_is_read_is_told() -> None:
    tops = [init.parent for init in ROOT.glob("*/__init__.py")]
    files = [path for top in tops for path in top.rglob("*.py") if "tests" not in path.parts]
    read = {name for path in files for name in READ.findall(path.read_text())}
    assert read == set(ENVIRONMENT)
