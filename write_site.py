"""Writes the site, the project's pages as HTML with search: ``make site``. It needs no network to be read.

The pages stay as they are, Markdown that is read on a code host, too. They are copied into ``build/pages``,
where each linked file that is no page gets a page of its own, and each linked folder of pages a list. Sphinx
makes ``build/site`` of them (``docs/conf.py``): a warning of it is an error. After that each link in the HTML
has to lead somewhere, and nothing may come from another host.
"""

import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from html.parser import HTMLParser
from os.path import normpath, relpath
from pathlib import Path
from typing import NamedTuple
from urllib.parse import unquote, urlsplit

ROOT = Path(__file__).parent
PAGES, SITE = ROOT / "build" / "pages", ROOT / "build" / "site"
HOME = "README.md"
"""Page at which the site opens, as its ``index.html``."""


def _how_to(*names: str) -> list[str]:
    return [f"docs/how-to/{name}.md" for name in names]


NAVIGATION: Mapping[str, list[str]] = {
    "Start": [
        "docs/tour.md", "docs/faq.md", *_how_to("package"), "examples/README.md", "docs/not-modelled.md",
    ],
    "Use: programs and tests": _how_to(
        "ports", "monitor", "write-a-test", "programs", "robot", "seeds", "ci", "draw"
    ),
    "Use: motion": _how_to("move-axes", "runs", "gcode", "switches", "race"),
    "Use: lines and buses": _how_to(
        "segments", "line", "sac-network", "modbus", "scada", "can", "can-channels", "zenoh", "web", "usb"
    ),
    "Use: your own board": _how_to(
        "own-sketch", "arduino", "own-mechaduino", "mechaduino-troubles", "easydriver", "walter", "own-drive",
        "eds-drives", "dialogue",
    ),
    "Operate": [
        *_how_to("service", "real-time", "health", "recordings", "reload", "lab"),
        *_how_to("real-boards", "parity", "real-can-drives"),
        "docs/benchmarks.md",
    ],
    "Extend": _how_to(
        "add-a-profile", "add-a-verb", "add-a-framing", "add-a-fault", "add-a-port", "add-a-bridge",
        "add-a-bus",
    ),
    "Boards": ["device_profiles/**/README.md", "bridges/*/README.md"],
    "Examples": ["examples/*/README.md"],
    "Look up": [
        "docs/glossary.md", "docs/commands.md", "docs/reference.md", "docs/robot-keywords.md",
        "docs/log-format.md", "CHANGELOG.md",
    ],
    "Work on it": ["CONTRIBUTING.md", "web/README.md", "docs/follow-a-*.md", "docs/decisions"],
}  # fmt: skip
"""Groups of pages by purpose, in order; a pattern stands for files by their names, a folder for its list."""

FOLDERS = {name for names in NAVIGATION.values() for name in names if (ROOT / name).is_dir()}
"""Folders whose list is in the navigation, and their pages in that list alone."""

LANGUAGES = {
    ".py": "python", ".yaml": "yaml", ".yml": "yaml", ".c": "c", ".ino": "cpp", ".cpp": "cpp", ".ts": "ts",
    ".json": "json", ".robot": "robotframework",
}  # fmt: skip
"""Languages of files that are linked; others are shown as text."""

UNLISTED = "---\norphan: true\n---\n"
"""Says to Sphinx that a page is in no list."""

_LINK = re.compile(r"(\[[^\]]*\]\()([^)\s]+)(\))")
_CODE = re.compile(r"^ *```.*?^ *```$", re.M | re.S)


class Broken(Exception):
    """The site cannot be: each line says where, and what is wrong there."""


def title_of(page: Path) -> str:
    """Heading of a page, which is its first line."""
    with page.open() as lines:
        return lines.readline().lstrip("# ").strip()


def pages() -> dict[str, list[str]]:
    """Pages of each group, as paths from the root. Raises Broken for a page of ``docs`` in no group."""
    groups: dict[str, list[str]] = {}
    for group, patterns in NAVIGATION.items():
        found = (sorted(ROOT.glob(pattern)) for pattern in patterns)
        groups[group] = [path.relative_to(ROOT).as_posix() for paths in found for path in paths]
    listed = {HOME, *(name for names in groups.values() for name in names)}
    there = [page.relative_to(ROOT).as_posix() for page in (ROOT / "docs").rglob("*.md")]
    if left := sorted(
        name for name in there if name not in listed and Path(name).parent.as_posix() not in listed
    ):
        raise Broken("\n".join(f"{name}: in no group of NAVIGATION in write_site.py" for name in left))
    return groups


def page_of(target: str) -> str:
    """Path of the site's page for a file or folder of the project."""
    if target == HOME:
        return "index.md"
    if (ROOT / target).is_dir():
        return f"{target}/index.md"
    return target if target.endswith((".md", ".png", ".svg")) else f"{target}.md"


class Copies:
    """Pages under ``build/pages``, and what they link to."""

    def __init__(self) -> None:
        self.made: set[str] = set()

    def add(self, name: str, below: str = "") -> None:
        """Copy a file or a folder's list, with all that it links to; ``below``: more text at a page's end."""
        if name in self.made:
            return
        self.made.add(name)
        source, made = ROOT / name, PAGES / page_of(name)
        made.parent.mkdir(parents=True, exist_ok=True)
        if source.is_dir():
            made.write_text(self._list(name))
        elif name.endswith(".md"):
            text = self._linked(name, source.read_text()) + below
            made.write_text(f"{UNLISTED}{text}" if str(Path(name).parent) in FOLDERS else text)
        elif made.suffix == ".md":
            made.write_text(_as_page(name, source.read_text()))
        else:
            shutil.copy2(source, made)

    def _list(self, folder: str) -> str:
        listed = sorted((ROOT / folder).glob("*.md"))
        for page in listed:
            self.add(f"{folder}/{page.name}")
        titles = ((page, re.sub(r"^\d+\.? ", "", title_of(page))) for page in listed)
        lines = "".join(f"- [{page.stem[:4]}: {title}]({page.name})\n" for page, title in titles)
        return f"# {Path(folder).name.capitalize()}\n\n{lines}"

    def _linked(self, name: str, text: str) -> str:
        """Text whose links lead to pages of the site."""

        def lead(found: re.Match[str]) -> str:
            file, hash_, anchor = found[2].partition("#")
            if not file or "://" in file or file.startswith("mailto:"):
                return found[0]
            target = normpath(Path(name).parent / unquote(file))
            self.add(target)
            way = relpath(page_of(target), Path(page_of(name)).parent)
            return f"{found[1]}{way}{hash_}{anchor}{found[3]}"

        kept, at = [], 0
        for code in _CODE.finditer(text):
            kept += [_LINK.sub(lead, text[at : code.start()]), code[0]]
            at = code.end()
        return "".join((*kept, _LINK.sub(lead, text[at:])))


def _as_page(name: str, text: str) -> str:
    """Page of a file that is shown as it is, in no list and not in the search."""
    fence = "`" * max(3, 1 + max((len(run) for run in re.findall("`+", text)), default=0))
    language = LANGUAGES.get(Path(name).suffix, "text")
    return (
        f"---\norphan: true\nnosearch: true\n---\n# {name}\n\n{fence}{language}\n{text.rstrip()}\n{fence}\n"
    )


def _tree(names: list[str], options: tuple[str, ...]) -> str:
    return "\n".join(("```{toctree}", *options, "", *names, "```\n"))


def copy_pages() -> int:
    """Write ``build/pages``; returns how many files are there."""
    shutil.rmtree(PAGES, ignore_errors=True)
    groups, copies = pages(), Copies()
    trees = (
        _tree([page_of(name) for name in names], (":hidden:", f":caption: '{group}'"))
        for group, names in groups.items()
        if names
    )
    copies.add(HOME, "\n" + "\n".join(trees))
    for name in (name for names in groups.values() for name in names):
        copies.add(name)
    return len(copies.made)


class Mark(NamedTuple):
    """An attribute of a page that leads somewhere."""

    line: int
    tag: str
    target: str


class _Reader(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.marks: list[Mark] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name == "id" and value:
                self.anchors.add(value)
            elif name in ("href", "src") and value:
                self.marks.append(Mark(self.getpos()[0], tag, value))


def broken_links(site: Path) -> Iterator[str]:
    """Go through what is wrong in a site: a link to a page, an anchor or a picture that is not there, a
    script, style or picture of another host. Links of sentences may lead to other hosts."""
    readers: dict[Path, _Reader] = {}
    for page in sorted(site.rglob("*.html")):
        readers[page] = reader = _Reader()
        reader.feed(page.read_text())
    for page, reader in readers.items():
        for mark in reader.marks:
            parts, where = urlsplit(mark.target), f"{page.relative_to(site)}:{mark.line}"
            if parts.scheme == "data":
                continue
            if parts.scheme or parts.netloc:
                if mark.tag != "a":
                    yield f"{where}: {mark.tag} from another host: {mark.target}"
                continue
            target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
            if not target.is_file():
                yield f"{where}: {mark.target} is not there"
            elif (
                parts.fragment
                and target in readers
                and unquote(parts.fragment) not in readers[target].anchors
            ):
                yield f"{where}: {mark.target}: the page has no such place"


def write() -> str:
    """Write the site; returns what it is. Raises Broken."""
    count = copy_pages()
    shutil.rmtree(SITE, ignore_errors=True)
    sphinx = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-j", "2", "-b", "html"]
    places = ["-c", str(ROOT / "docs"), "-d", str(ROOT / "build" / "doctrees"), str(PAGES), str(SITE)]
    if subprocess.run([*sphinx, *places], check=False).returncode:
        raise Broken("sphinx has found what stands above")
    if wrong := [*broken_links(SITE)]:
        raise Broken("\n".join(wrong))
    size = sum(file.stat().st_size for file in SITE.rglob("*") if file.is_file())
    return f"{SITE.relative_to(ROOT)}/index.html: {count} pages and files, {size / 1e6:.0f} MB"


if __name__ == "__main__":
    try:
        print(write())
    except Broken as problem:
        sys.exit(f"write_site.py: the site is not written:\n{problem}")
