"""Pages of the documentation, where hil is installed: beside its source, in its environment, or where its
package has put them."""

import sys
from pathlib import Path
from typing import NamedTuple


class Page(NamedTuple):
    title: str
    file: Path


_PLACES = (
    Path(__file__).parents[2] / "docs",
    Path(sys.prefix) / "share" / "hil" / "docs",
    Path("/usr/share/doc/hil/docs"),
)
_FOLDERS = ("", "how-to")


def find_pages() -> dict[str, Page]:
    """Find the pages of the first place that has some, by name, each with its title."""
    for place in _PLACES:
        files = [file for folder in _FOLDERS for file in sorted((place / folder).glob("*.md"))]
        if (place / "reference.md").is_file():
            return {file.stem: Page(_title(file), file) for file in files}
    return {}


def _title(file: Path) -> str:
    with file.open() as lines:
        return lines.readline().lstrip("# ").strip()
