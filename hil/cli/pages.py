"""Pages of the documentation, where hil is installed."""

from pathlib import Path
from typing import NamedTuple

from hil.cli.installed_files import installed


class Page(NamedTuple):
    title: str
    file: Path


_FOLDERS = ("", "how-to")


def find_pages() -> dict[str, Page]:
    """Find the pages by name, each with its title; none if this installation came without them."""
    if not (reference := installed("docs/reference.md")):
        return {}
    files = [file for folder in _FOLDERS for file in sorted((reference.parent / folder).glob("*.md"))]
    return {file.stem: Page(_title(file), file) for file in files}


def _title(file: Path) -> str:
    with file.open() as lines:
        return lines.readline().lstrip("# ").strip()
