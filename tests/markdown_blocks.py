"""Fenced blocks of the project's pages, for tests that run what the pages show."""

import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parent.parent
_MADE = {"build", "dist", "node_modules"}
"""Folders of what others have made."""
_PART = re.compile(r"^(?:#+ (?P<heading>[^\n]+)|```(?P<language>\w*)\n(?P<text>.*?)^```)$", re.M | re.S)
CUT = "..."
"""A line that stands for any number of lines."""


class Block(NamedTuple):
    """Block of a page, below the heading that is next above it."""

    heading: str
    language: str
    text: str


def blocks(page: str) -> list[Block]:
    """Blocks of a page, given as a path from the project's root, in order."""
    heading, found = "", []
    for part in _PART.finditer((ROOT / page).read_text()):
        if part["heading"] is not None:
            heading = part["heading"]
        else:
            found.append(Block(heading, part["language"], part["text"]))
    return found


def block(page: str, heading: str, index: int = 0) -> str:
    """Text of a block, counted below its heading."""
    return [each.text for each in blocks(page) if each.heading == heading][index]


def fits(shown: str, printed: str, *varies: str) -> bool:
    """True if a page shows what was printed. ``varies``: patterns of what is different each time; they match
    what is shown too. Spaces at ends of lines do not count."""

    def masked(text: str) -> str:
        text = "\n".join(line.rstrip() for line in text.replace("\r\n", "\n").strip().split("\n"))
        return re.sub("|".join(varies), "#", text) if varies else text

    lines = (r"(?:.*\n)*" if line == CUT else re.escape(line + "\n") for line in masked(shown).split("\n"))
    return re.fullmatch("".join(lines), masked(printed) + "\n") is not None


def all_pages() -> list[Path]:
    """All pages of the project."""
    below = (page for top in ROOT.glob("[a-z]*/") for page in top.rglob("*.md"))
    return sorted(
        page for page in (*ROOT.glob("*.md"), *below) if not _MADE & set(page.relative_to(ROOT).parts)
    )
