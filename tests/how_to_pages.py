"""Files of a how-to page: below a heading that is a path stands the file's content."""

import asyncio
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Awaitable, Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

import pytest
from markdown_blocks import ROOT, blocks

from hil.compose import find_catalogue
from hil.config import parse
from hil.daemon import Daemon, Serving
from hil.discovery.installed import every_point

_PATH = re.compile(r"[\w/]+\.(py|yaml)")
Answer = TypeVar("Answer")
HEAD = '"""Written from a page."""\n'


def write_files(page: str, root: Path) -> list[Path]:
    """Write the files of ``docs/how-to/<page>.md`` below a folder, each folder of a package with its
    ``__init__.py``; answers their paths, without those."""
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
def installed_from(page: str, root: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Path]]:
    """Write a page's files below a folder, and have its packages installed, with the entry points that the
    page's TOML has; with the files' paths."""
    written = write_files(page, root)
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
    every_point.cache_clear()
    yield written
    every_point.cache_clear()
    for top in {package.partition(".")[0] for package in packages}:
        for name in [name for name in sys.modules if name == top or name.startswith(f"{top}.")]:
            del sys.modules[name]


def style_problems(files: list[Path]) -> str:
    """Let ruff look at files, by the project's rules, but for the order of imports; answers its findings."""
    said = ""
    for what in (("check", "--ignore", "I001"), ("format", "--diff")):
        command = [sys.executable, "-m", "ruff", *what, "-q", "--config", ROOT / "pyproject.toml", *files]
        said += subprocess.run(command, capture_output=True, text=True, check=False).stdout
    return said


def run_tests(
    path: Path, folder: Path, *options: str, environment: Mapping[str, str] = os.environ
) -> subprocess.CompletedProcess[str]:
    """Run tests as their author does, from a folder, in a process of their own."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *options, str(path)]
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=120, check=False
    )


def only_test(files: list[Path]) -> Path:
    """Path of a page's only file of tests."""
    (test,) = (path for path in files if path.name.startswith("test_"))
    return test


def answer_of_daemon(text: str, folder: Path, ask: Callable[[Serving], Awaitable[Answer]]) -> Answer:
    """Run a daemon of a configuration, with its folders below one, until ``ask`` has its answer."""

    async def main() -> Answer:
        config = parse(text, "page.yaml", find_catalogue())
        daemon = Daemon(config, config_folder=folder, runtime_base=folder, state_base=folder / "state")

        async def asked(serving: Serving) -> Answer:
            try:
                async with asyncio.timeout(120):
                    return await ask(serving)
            finally:
                daemon.stop()

        tasks: list[asyncio.Task[Answer]] = []
        await daemon.run(lambda serving: tasks.append(asyncio.get_running_loop().create_task(asked(serving))))
        return await tasks[0]

    return asyncio.run(main())
