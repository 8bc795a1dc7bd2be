"""Files that come with hil beside its modules: in a checkout, in an environment or a folder into which a
wheel was installed, or where the Debian package has put them.
Pages of the documentation are among them."""

from pathlib import Path
from typing import NamedTuple

_UP = tuple(Path(__file__).parents)
_ROOT = _UP[3]
_SHARES = (
    _ROOT / "share" / "hil",  # pip install --target
    _UP[min(6, len(_UP) - 1)]
    / "share"
    / "hil",  # of lib/python3.x/site-packages, an environment's or a user's
    Path("/usr/share/hil"),
)


def installed(name: str) -> Path | None:
    """Find a file or a folder by its name in the checkout, as in ``wireshark/sac_packets.lua``; None: this
    installation came without it."""
    return next((path for place in (_ROOT, *_SHARES) if (path := place / name).exists()), None)


class Page(NamedTuple):
    title: str
    file: Path


_FOLDERS = ("", "how-to", "decisions")


def find_pages() -> dict[str, Page]:
    """Find the pages by name, each with its title; none if this installation came without them."""
    if not (reference := installed("docs/reference.md")):
        return {}
    files = [file for folder in _FOLDERS for file in sorted((reference.parent / folder).glob("*.md"))]
    return {file.stem: Page(_title(file), file) for file in files}


def _title(file: Path) -> str:
    with file.open() as lines:
        return lines.readline().lstrip("# ").strip()
