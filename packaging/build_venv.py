"""Builds hil in a venv, editable, with what it needs: build_venv.py [--packages] VENV [EXTRA...]

Each step has a line, and each second of the longer ones another: at a terminal over the one before, elsewhere
every ten seconds. Packages are fetched while C is compiled. --packages: hil is in the venv already, and only
what the extras need comes to it. What pip says is in VENV/packages.log and VENV/core.log.
"""

from __future__ import annotations  # an older Python gets as far as the sentence that it is too old

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).parent.parent
LAST_LINES = 25
"""Lines of a failed step's log that are shown: a compiler's first error is within them, mostly."""


def requirements(extras: Iterable[str]) -> list[str]:
    """Packages that hil asks for, and those of its extras."""
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    found, waiting = list(project["dependencies"]), list(extras)
    while waiting:
        for each in project["optional-dependencies"][waiting.pop()]:
            own = re.fullmatch(rf"{project['name']}\[(.*)\]", each)
            waiting += own[1].split(",") if own else []
            found += [] if own else [each]
    return found


def missing(*, compiles: bool) -> list[str]:
    """Debian packages without which nothing can be built here."""
    header = Path(sysconfig.get_path("include")) / "Python.h"
    is_there = {"python3-venv": find_spec("ensurepip") is not None}
    if compiles:
        is_there |= {"gcc": shutil.which("gcc") is not None, "python3-dev": header.exists()}
    return [name for name, is_here in is_there.items() if not is_here]


class Steps:
    """Numbered lines of what is done, with the time that each took."""

    def __init__(self, count: int) -> None:
        self._count, self._is_seen = count, sys.stdout.isatty()
        self._begun = self._said = time.monotonic()

    def say(self, number: int, text: str) -> None:
        """Print a step's line, over the line of progress."""
        over = "\r\033[K" if self._is_seen else ""
        print(f"{over}[{number}/{self._count}] {text}", flush=True)

    def progress(self, text: str) -> None:
        """Print a line that the next one replaces; where it cannot, one in ten seconds."""
        now = time.monotonic()
        line = f"{now - self._begun:7.0f} s: {text}"
        if self._is_seen:
            print(f"\r\033[K{line[: shutil.get_terminal_size().columns - 1]}", end="", flush=True)
        elif now - self._said >= 10:
            self._said = now
            print(line, flush=True)


class Job:
    """A pip that runs, with its log."""

    def __init__(self, number: int, what: str, log: Path, command: list[str], env: dict[str, str]) -> None:
        self.number, self.what, self.log = number, what, log
        self._begun, self._is_told = time.monotonic(), False
        with log.open("wb") as file:
            self._process = subprocess.Popen(command, env=env, stdout=file, stderr=file)

    @property
    def code(self) -> int | None:
        """Exit code; None while it runs."""
        return self._process.poll()

    def tell_end(self, steps: Steps) -> None:
        """Say once that it has ended, and how; a failed one shows the end of its log."""
        if self.code is None or self._is_told:
            return
        self._is_told = True
        seconds = time.monotonic() - self._begun
        if self.code == 0:
            steps.say(self.number, f"{self.what}: done in {seconds:.0f} s")
            return
        steps.say(self.number, f"{self.what}: failed after {seconds:.0f} s. The end of {self.log}:")
        lines = self.log.read_text(errors="replace").splitlines()
        print(*(f"    {line}" for line in lines[-LAST_LINES:]), sep="\n")

    def end(self) -> None:
        self._process.terminate()
        self._process.wait()


def installed(venv: Path) -> int:
    """Number of packages in the venv."""
    return len(list(venv.glob("lib/python*/site-packages/*.dist-info")))


def compiled(progress: Path) -> tuple[float, float]:
    """Part of the C that is compiled, and when its compilation began; ``setup.py`` writes both."""
    done, all_bytes, begun = progress.read_text().split() or (0, 1, 0)
    return int(done) / int(all_bytes), float(begun)


def of_core(progress: Path) -> str:
    """Describe how much has been compiled."""
    part, begun = compiled(progress)
    if not begun:
        return "C is translated"
    # The first part is of the core alone, which takes longer for its size than what comes after it.
    left = f", about {(time.time() - begun) * (1 - part) / part:.0f} s to go" if part > 0.2 else ""
    return f"{part:.0%} of the C is compiled{left}"


def build(venv: Path, extras: list[str], *, compiles: bool) -> bool:
    """Do all steps; False: one failed."""
    steps = Steps(3 if compiles else 2)
    if (venv / "bin" / "pip").exists():
        steps.say(1, f"the venv {venv} is there")
    else:
        steps.say(1, f"make the venv {venv} of Python {sys.version.split()[0]}")
        subprocess.run([sys.executable, "-m", "venv", venv], check=True)
    pip = [str(venv / "bin" / "python"), "-m", "pip", "install", "-q", "--disable-pip-version-check"]
    before = installed(venv)
    with tempfile.TemporaryDirectory() as folder:
        progress = Path(folder) / "progress"
        progress.touch()
        env = {**os.environ, "HIL_BUILD_PROGRESS": str(progress)}
        wanted = requirements(extras)
        what = f"fetch and install {len(wanted)} Python packages and what they need"
        steps.say(2, what)
        # A release without a wheel would be compiled, where an older one has a wheel.
        jobs = [Job(2, "Python packages", venv / "packages.log", [*pip, "--prefer-binary", *wanted], env)]
        if compiles:
            steps.say(3, "compile the C core, about 25 s on two idle cores")
            command = [*pip, "--no-deps", "-e", str(ROOT)]
            jobs.append(Job(3, "the C core", venv / "core.log", command, env))
        try:
            while None in (codes := [job.code for job in jobs]) and not any(codes):
                time.sleep(0.2 if sys.stdout.isatty() else 1)
                for job in jobs:
                    job.tell_end(steps)
                said = [f"{installed(venv) - before} packages are there"] if jobs[0].code is None else []
                said += [of_core(progress)] if jobs[-1].code is None and compiles else []
                if said:
                    steps.progress("; ".join(said))
            for job in jobs:
                job.tell_end(steps)
        finally:
            for job in jobs:
                job.end()
    return not any(codes)


def main() -> None:
    if sys.version_info < (3, 11):  # noqa: UP036 - it may be started with any
        sys.exit(
            f"hil: needs Python 3.11 or newer, and this is {sys.version.split()[0]};"
            " name another: make PYTHON=python3.13"
        )
    words = sys.argv[1:]
    compiles = "--packages" not in words
    venv, *extras = (each for each in words if each != "--packages")
    if lacks := missing(compiles=compiles):
        sys.exit(f"hil: not built, {' and '.join(lacks)} missing: sudo apt install {' '.join(lacks)}")
    begun = time.monotonic()
    if not build(Path(venv), extras, compiles=compiles):
        sys.exit("hil: not built, for the reason above; then run the same command again")
    print(f"Built in {time.monotonic() - begun:.0f} s.", flush=True)


if __name__ == "__main__":
    main()
