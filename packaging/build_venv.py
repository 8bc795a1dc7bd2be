"""Installs hil into the venv whose Python runs this, editable, with what it needs: build_venv.py [EXTRA...]

Packages are fetched while C is compiled. Each second has a line: what is done, and how long the rest takes.
"""

import os
import re
import subprocess
import sys
import sysconfig
import tempfile
import time
import tomllib
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).parent.parent
PIP = (sys.executable, "-m", "pip", "install", "-q", "--disable-pip-version-check")


def requirements(extras: Iterable[str]) -> list[str]:
    """Packages that hil asks for, and those of its extras."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    found, waiting = list(project["dependencies"]), list(extras)
    while waiting:
        for each in project["optional-dependencies"][waiting.pop()]:
            own = re.fullmatch(rf"{project['name']}\[(.*)\]", each)
            waiting += own[1].split(",") if own else []
            found += [] if own else [each]
    return found


def installed() -> int:
    """Number of packages in the venv."""
    return len(list(Path(sysconfig.get_path("purelib")).glob("*.dist-info")))


def compiled(progress: Path) -> tuple[float, float]:
    """Part of the C that is compiled, and when its compilation began; ``setup.py`` writes both."""
    done, all_bytes, begun = progress.read_text().split() or (0, 1, 0)
    return int(done) / int(all_bytes), float(begun)


def said(jobs: dict[str, subprocess.Popen[bytes]], before: int, progress: Path) -> str:
    """Line of progress."""
    is_there = jobs["packages"].poll() is not None
    part, begun = compiled(progress)
    words = ["all packages are there" if is_there else f"{installed() - before} packages are there"]
    if jobs["C"].poll() is not None:
        words.append("all C is compiled")
    elif not begun:
        words.append("C waits for its compiler's packages")
    else:
        left = f", about {(time.time() - begun) * (1 - part) / part:.0f} s to go" if part else ""
        words.append(f"{part:.0%} of the C is compiled{left}")
    return "; ".join(words)


def main() -> None:
    begun, before = time.monotonic(), installed()
    with tempfile.TemporaryDirectory() as folder:
        progress = Path(folder) / "progress"
        progress.touch()
        env = {**os.environ, "HIL_BUILD_PROGRESS": str(progress)}
        commands = {"packages": requirements(sys.argv[1:]), "C": ["--no-deps", "-e", str(ROOT)]}
        jobs = {name: subprocess.Popen([*PIP, *words], env=env) for name, words in commands.items()}
        try:
            while None in (ends := [job.poll() for job in jobs.values()]) and not any(ends):
                time.sleep(1)
                print(f"{time.monotonic() - begun:3.0f} s: {said(jobs, before, progress)}", flush=True)
        finally:
            for job in jobs.values():
                job.terminate()
                job.wait()
        if any(ends):
            sys.exit("hil was not built: pip says why above")
    print(f"Built in {time.monotonic() - begun:.0f} s.")


if __name__ == "__main__":
    main()
