"""The page that is in the wheel is made of the sources that are here."""

import gzip
import hashlib
import json
import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
SOURCES = ROOT / "web"
SINGLE = (
    *("build_version.mjs", "index.html", "package-lock.json", "package.json", "tsconfig.json"),
    "vite.config.mjs",
)

FIRST_VIEW_BYTES = 150_000


def version_of_sources() -> str:
    """Checksum as ``web/build_version.mjs`` computes it."""
    below = [path.relative_to(SOURCES).as_posix() for path in SOURCES.glob("src/**/*") if path.is_file()]
    digest = hashlib.sha256()
    for name in sorted([*SINGLE, *below], key=str.encode):
        content = (SOURCES / name).read_bytes()
        digest.update(f"{name}\0{len(content)}\0".encode() + content)
    return digest.hexdigest()


def imported(script: Path) -> list[str]:
    """Names of the scripts without which this one does not begin."""
    return re.findall(r'(?:\bfrom|\bimport)\s*["\'`]\./([^"\'`]+)["\'`]', script.read_text())


def test_the_first_view_is_light() -> None:
    """Files that a browser loads before anything is opened: the index, what it names, and their imports."""
    static = ROOT / "bridges/web/static"
    index = (static / "index.html").read_text()
    names = ["index.html", *re.findall(r'(?:src|href)="\./([^"]+)"', index)]
    for name in names:
        if name.endswith(".js"):
            names += [each for each in imported(static / name) if each not in names]
    # One script: what views share is in it, and nothing has to be asked for after it.
    assert names == ["index.html", "page.js", "page.css"]
    assert sum(len(gzip.compress((static / name).read_bytes())) for name in names) <= FIRST_VIEW_BYTES


def test_no_part_changes_the_elements_of_others() -> None:
    """Importing `preact/compat` changes the properties of all elements, from when any part has loaded it."""
    sources = [*SOURCES.glob("src/**/*.ts"), *SOURCES.glob("src/**/*.tsx")]
    assert [path.name for path in sources if 'from "preact/compat"' in path.read_text()] == []


def test_the_built_page_is_of_these_sources() -> None:
    built = json.loads((ROOT / "bridges/web/static/build.json").read_text())
    assert built == {"version": version_of_sources()}, "the sources have changed: `make web`, and commit it"
