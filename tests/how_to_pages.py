"""Files of a how-to page: below a heading that is a path stands the file's content."""

import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from markdown_blocks import ROOT, blocks

from hil.discovery.installed import installed

_PATH = re.compile(r"[\w/]+\.(py|yaml)")
HEAD = '"""Written from a page."""\n'


def write_files(page: str, root: Path) -> list[Path]:
    """Write the files of ``docs/how-to/<page>.md`` below a folder, each folder of a package with its
    ``__init__.py``, and return their paths."""
    written = []
    for block in blocks(f"docs/how-to/{page}.md"):
        if _PATH.fullmatch(block.heading) and block.language in ("python", "yaml"):
            path = root / block.heading
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.text)
            written.append(path)
            for folder in path.relative_to(root).parents:
                if path.name in ("port.py", "bridge.py") and folder.name:
                    (root / folder / "__init__.py").write_text(HEAD)
    return written


@contextmanager
def installed_from(page: str, root: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Install the packages below a folder, with the entry points that a page's TOML has."""
    (text,) = (block.text for block in blocks(f"docs/how-to/{page}.md") if block.language == "toml")
    info = root / "lab-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: lab\nVersion: 1\n")
    packages = []
    with (info / "entry_points.txt").open("w") as file:
        for group, points in tomllib.loads(text)["project"]["entry-points"].items():
            file.write(f"[{group}]\n" + "".join(f"{name} = {package}\n" for name, package in points.items()))
            packages += points.values()
    monkeypatch.syspath_prepend(str(root))
    installed.cache_clear()
    yield
    installed.cache_clear()
    for top in {package.partition(".")[0] for package in packages}:
        for name in [name for name in sys.modules if name == top or name.startswith(f"{top}.")]:
            del sys.modules[name]


def style_problems(files: list[Path]) -> str:
    """Findings of ruff in files, by the project's rules, but for the order of imports."""
    said = ""
    for what in (("check", "--ignore", "I001"), ("format", "--diff")):
        command = [sys.executable, "-m", "ruff", *what, "-q", "--config", ROOT / "pyproject.toml", *files]
        said += subprocess.run(command, capture_output=True, text=True, check=False).stdout
    return said
