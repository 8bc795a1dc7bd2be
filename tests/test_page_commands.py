"""Commands of ``docs/how-to`` and ``docs/faq.md``: each is carried out, and prints what its page shows."""

import re
import shlex
import shutil
from collections.abc import Iterator
from pathlib import Path

import page_preparations
import pytest
import sketch_preparations
from _pytest.mark import ParameterSet
from e2e_support import Place
from markdown_blocks import ROOT, all_pages
from page_sessions import Session, Step, hil_lines, inline_commands, parsed, steps
from page_tables import CARRIED_OUT, PREPARATIONS

from hil.cli.framework.usage_words import USAGE_ERROR

ENTERED = (page_preparations, sketch_preparations)
"""Modules that have filled the tables."""
PAGES = [
    "docs/faq.md",
    *sorted(str(path.relative_to(ROOT)) for path in (ROOT / "docs/how-to").glob("*.md")),
]
ALL = [str(path.relative_to(ROOT)) for path in all_pages() if path.name != "CHANGELOG.md"]
ELSEWHERE = {
    ("docs/how-to/add-a-profile.md", "Add a board"): "test_how_to_board.py",
    ("docs/how-to/add-a-profile.md", "Where to put it"): "test_how_to_board.py",
    ("docs/how-to/runs.md", "Over several benches"): "test_e2e_benches.py",
}
"""Headings whose commands another file carries out. ``test_e2e_tour.py`` has those of README and tour."""
NOT_HERE = {
    r"sudo |make ": "installs or builds",
    r"podman |docker ": "needs a container's runtime: `make test-container`",
    r"picocom ": "a terminal that only its user leaves",
    r".*/dev/ttyUSB": "needs a board",
    r"hil sac calibrate": "a minute by the computer's clock",
    r".*\| wireshark|.*--wireshark": "needs a screen",
    r"pip install '?dist/|pipx |uvx ": "installs: `make wheels` tries what it builds",
    r"arduino-cli ": "not in Debian",
}
"""Commands that are not carried out, and why. Commands for root are not either."""


SLOW = ("draw", "modbus", "own-sketch", "race")
"""Pages that take half a minute and more."""


def is_carried_out(step: Step) -> bool:
    program = step.command.split()[0]
    return not (
        step.is_root
        or (step.page, step.heading) in ELSEWHERE
        or any(re.match(pattern, step.command) for pattern in NOT_HERE)
        or (program == "mbpoll" and not shutil.which(program))
        or ("tshark" in step.command and not shutil.which("tshark"))
    )


def carried_out() -> Iterator[ParameterSet]:
    """Pages with commands that are carried out."""
    for page in PAGES:
        if any(map(is_carried_out, steps(page))):
            name = Path(page).stem
            yield pytest.param(page, id=name, marks=[pytest.mark.thorough] if name in SLOW else [])


@pytest.mark.parametrize("page", [*carried_out()])
def test_commands_print_what_the_page_shows(page: str, place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(place.folder)
    heading = ""
    with Session(place, page) as session:
        for step in filter(is_carried_out, steps(page)):
            if step.heading != heading:
                heading = step.heading
                if prepare := PREPARATIONS.get((page, heading)):
                    prepare(session)
            by = [
                each
                for (of, begin), each in CARRIED_OUT.items()
                if of == page and step.command.startswith(begin)
            ]
            session.check(step, *by)


@pytest.mark.parametrize(
    "page", [page for page in ALL if "/decisions/" not in page and page != "docs/reference.md"]
)
def test_command_lines_are_right(page: str) -> None:
    """Those of blocks are whole, those in sentences may lack arguments."""
    for step in steps(page):
        for line in hil_lines(step.command):
            parsed(shlex.split(line))
    for line in inline_commands(page):
        try:
            parsed(shlex.split(line))
        except USAGE_ERROR as error:
            said = error.format_message()
            lacks = r".* is missing|.* has no value|.* is one of several commands|Usage: "
            stands_for = r'([A-Z]+): "\[?\1\]?" is no number'
            assert re.match(f"{stands_for}|{lacks}", said), f"`hil {line}`: {said}"


@pytest.mark.parametrize(("page", "heading"), [*PREPARATIONS, *ELSEWHERE])
def test_a_prepared_heading_is_the_page_s(page: str, heading: str) -> None:
    assert re.search(rf"^#+ {re.escape(heading)}$", (ROOT / page).read_text(), re.M)


def test_no_page_installs_the_checkout_again_for_an_extra() -> None:
    """`pip install '.[plot]'` compiles all C again and replaces an editable install."""
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    again = re.compile(r"pip install [^`\n]*'\.\[")
    assert [page.name for page in pages if again.search(page.read_text())] == []
