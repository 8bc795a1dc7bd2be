"""Pages of the documentation as text: their groups, their headings, and a page from a heading on."""

import re
from collections.abc import Iterator
from typing import NamedTuple

from hil.cli.framework.installed_files import Page

GROUPS = {
    "start": "begin here",
    "how-to": "one task each",
    "facts": "to look things up",
    "follow": "how hil works inside, step by step",
    "decisions": "why it is as it is",
}
"""Groups of pages in their order, each with what is in it."""
_START = ("tour", "faq", "commands", "glossary", "index")
_FENCE = re.compile(r" {0,3}(```+|~~~+)")
_HEADING = re.compile(r"(#{1,6}) +(.*?)(?: +#+)? *$")
_NO_ANCHOR = re.compile(r"[^\w\- ]")
_LINK = re.compile(r"\[([^\]]*)\]\([^)]*\)")


class Heading(NamedTuple):
    """Heading of a page. ``anchor``: as links have it behind #; ``level``: 1 of the title."""

    text: str
    anchor: str
    level: int


def group_of(page: Page) -> str:
    """Group of a page, by its folder and its name."""
    if (folder := page.file.parent.name) in GROUPS:
        return folder
    if page.file.stem.startswith("follow-"):
        return "follow"
    return "start" if page.file.stem in _START else "facts"


def headings(text: str) -> list[Heading]:
    """Headings of a page, in their order."""
    return [heading for _, heading in _headings(text)]


def beginning_at(text: str, wanted: str) -> str | None:
    """Page from a heading on, by its anchor or its words; None: it has no such heading."""
    anchor = _anchor(wanted)
    lines = text.splitlines(keepends=True)
    return next(("".join(lines[at:]) for at, each in _headings(text) if each.anchor == anchor), None)


def _headings(text: str) -> Iterator[tuple[int, Heading]]:
    """Headings with the numbers of their lines, from 0 on; those of code are none."""
    fence = ""
    seen: dict[str, int] = {}
    for number, line in enumerate(text.splitlines()):
        if found := _FENCE.match(line):
            if not fence:
                fence = found[1]
            elif found[1].startswith(fence):
                fence = ""
        elif not fence and (heading := _HEADING.match(line)):
            words = _LINK.sub(r"\1", heading[2]).replace("`", "").replace("*", "")
            anchor = _anchor(words)
            count = seen[anchor] = seen.get(anchor, -1) + 1
            yield number, Heading(words, f"{anchor}-{count}" if count else anchor, len(heading[1]))


def _anchor(words: str) -> str:
    return _NO_ANCHOR.sub("", words.strip().lower()).replace(" ", "-")
