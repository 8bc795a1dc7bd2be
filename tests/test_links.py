"""Links in the project's Markdown pages: pages, headings, files and names in files are there."""

import re
from pathlib import Path

import pytest
from markdown_blocks import ROOT, all_pages
from mentions import MENTION, is_defined

PAGES = all_pages()
FOLDERS = sorted(
    {page.relative_to(ROOT).parts[0] for page in PAGES if page.parent != ROOT} | {"hil", "tests"}
)
PRESENT = [page for page in PAGES if page.name != "CHANGELOG.md" and page.parent.name != "decisions"]
"""Pages that describe what is; the others describe what was."""
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ (.+)$", re.M)
FILE = re.compile(rf"`((?:{'|'.join(FOLDERS)})/[\w/.-]+\.\w+)")
CODE_BLOCK = re.compile(r"^```.*?^```", re.M | re.S)


def prose(page: Path) -> str:
    return CODE_BLOCK.sub("", page.read_text())


def anchors(page: Path) -> set[str]:
    """Anchors of a page as the usual renderers make them: lower case, spaces to hyphens, punctuation
    dropped."""
    return {
        re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in HEADING.findall(prose(page))
    }


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_relative_links_lead_somewhere(page: Path) -> None:
    for link in LINK.findall(prose(page)):
        if "://" in link:
            continue
        file, _, anchor = link.partition("#")
        target = (page.parent / file).resolve() if file else page
        assert target.exists(), f"{page.name}: {link}"
        assert not anchor or anchor in anchors(target), f"{page.name}: {link} has no such heading"


@pytest.mark.parametrize("page", PRESENT, ids=lambda page: str(page.relative_to(ROOT)))
def test_files_and_names_in_them_are_there(page: Path) -> None:
    text = page.read_text()
    files = [file for file in FILE.findall(text)]
    assert [
        file
        for file in files
        if not any((base / file).exists() for base in (ROOT, page.parent, page.parents[1]))
    ] == []
    assert [(file, name) for file, name in MENTION.findall(text) if not is_defined(ROOT / file, name)] == []
