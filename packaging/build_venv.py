"""Builds hil in a venv, editable, with what it needs: build_venv.py [--packages] VENV [EXTRA...]

Each step has a line, and each second of the longer ones another: at a terminal over the one before, elsewhere
every ten seconds. Packages are fetched while C is compiled. --packages: hil is in the venv already, and only
what the extras need comes to it. What pip says is in VENV/packages.log and VENV/core.log. For other scripts:
--check tells only what is missing here to compile, --cause LOG why a build of that log has failed.
"""

from __future__ import annotations  # an older Python gets as far as the sentence that it is too old

import fcntl
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).parent.parent
LAST_LINES = 25
"""Lines of a failed step's log that are shown: a compiler's first error is within them, mostly."""
NEEDED_MB = 600
"""Room that a build takes: about 270 MB for hil, 530 with what the tests need, and what pip unpacks."""
OF_OTHERS = ("PYTHONPATH", "PYTHONHOME", "PIP_TARGET", "PIP_PREFIX", "PIP_ROOT")
"""Variables by which pip would find packages elsewhere, or put them there."""
CAUSES = (
    (r"No space left on device|Disk quota exceeded", f"the disk is full: free {NEEDED_MB} MB"),
    (
        r"[Nn]ame resolution|NewConnectionError|Failed to establish a new connection|ConnectTimeout"
        r"|Network is unreachable|ProxyError",
        "pip's index is not reached: see to the network or the proxy (HTTPS_PROXY), or name another index"
        " (PIP_INDEX_URL)",
    ),
    (r"CERTIFICATE_VERIFY_FAILED", "pip does not trust its index: PIP_CERT=FILE names your certificates"),
    (r"Python\.h: No such file", "the headers of Python are missing: sudo apt install python3-dev"),
    (r"fatal error: [\w/]+\.h: No such file", "headers of C are missing: sudo apt install libc6-dev"),
    (r"Read-only file system|Permission denied", "a folder cannot be written: build in a clone of your own"),
)
"""Reasons that logs are searched for, with a sentence for each."""


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


def missing(*, compiles: bool) -> str:
    """Tell what is missing here to build anything, and how to get it; empty: nothing."""
    header = Path(sysconfig.get_path("include")) / "Python.h"
    is_there = {"python3-venv": find_spec("ensurepip") is not None}
    if compiles:
        compiler = shlex.split(os.environ.get("CC") or sysconfig.get_config_var("CC") or "gcc")[0]
        is_there |= {"gcc": shutil.which(compiler) is not None, "python3-dev": header.exists()}
        if not is_there["gcc"] and shutil.which("gcc"):
            return f"the C compiler {compiler}, as CC or this Python names it, is not here: CC=gcc make demo"
    lacks = [name for name, is_here in is_there.items() if not is_here]
    return f"{' and '.join(lacks)} missing: sudo apt install {' '.join(lacks)}" if lacks else ""


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
        with log.open("wb") as file:  # a group of its own: it ends with the compilers that it has started
            self._process = subprocess.Popen(
                command, env=env, stdout=file, stderr=file, start_new_session=True
            )

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
        # Each call of the compiler is a line of 400 characters, and says nothing.
        lines = [line for line in self.said().splitlines() if not re.match(r"\s*\S+ .* -c \S+ -o ", line)]
        print(*(f"    {line}" for line in lines[-LAST_LINES:]), sep="\n")

    def said(self) -> str:
        return self.log.read_text(errors="replace")

    def end(self) -> None:
        """End what still runs, with all that it has started: nothing writes on after that."""
        for number, wait_s in ((signal.SIGINT, 10), (signal.SIGKILL, None)):
            if self.code is None:
                with suppress(subprocess.TimeoutExpired, ProcessLookupError):
                    os.killpg(self._process.pid, number)
                    self._process.wait(wait_s)


def installed(venv: Path) -> int:
    """Number of packages in the venv."""
    return len(list(venv.glob("lib/python*/site-packages/*.dist-info")))


def of_packages(said: str, come: int) -> str:
    """Describe how far pip is, by what it has said, and the number of packages that have come."""
    if listed := re.search(r"^Installing collected packages: (.*)$", said, re.M):
        return f"{come} of {listed[1].count(',') + 1} packages are installed"
    return f"{len(re.findall('^(?:Collecting|Processing) ', said, re.M))} packages are fetched"


def cause(said: str) -> str:
    """Tell why a step has failed, where its log has a reason that is known; else empty."""
    return next((sentence for pattern, sentence in CAUSES if re.search(pattern, said)), "")


def runs(venv: Path) -> bool:
    """Whether a venv is complete, and its Python is still there."""
    python = venv / "bin" / "python"
    return (venv / "bin" / "pip").exists() and shutil.which(python) is not None


@contextmanager
def alone() -> Iterator[None]:
    """Wait until no other process builds in this checkout."""
    with Path(__file__).open() as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            print(f"Another build runs in {ROOT}: this one waits for its end.", flush=True)
            fcntl.flock(file, fcntl.LOCK_EX)
        yield


def compiled(progress: Path) -> tuple[float, float]:
    """Part of the C that is compiled, and when its compilation began; ``setup.py`` writes both."""
    done, all_bytes, begun = progress.read_text().split() or (0, 1, 0)
    return int(done) / int(all_bytes), float(begun)


def of_core(progress: Path) -> str:
    """Describe how much has been compiled."""
    part, begun = compiled(progress)
    if not begun:
        return "C is translated"
    if part == 1:
        return "all of the C is compiled, and is linked"
    # The first part is of the core alone, which takes longer for its size than what comes after it.
    left = f", about {(time.time() - begun) * (1 - part) / part:.0f} s to go" if part > 0.2 else ""
    return f"{part:.0%} of the C is compiled{left}"


def make_venv(venv: Path, env: dict[str, str]) -> None:
    """Make a venv, or make a broken one again; where that fails, none is left.

    Raises:
        OSError: The folder cannot be written.
    """
    command = [sys.executable, "-m", "venv", *(["--clear"] if (venv / "pyvenv.cfg").exists() else []), venv]
    try:
        done = subprocess.run(command, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode:
            why = cause(done.stdout) or done.stdout.strip()
            sys.exit(f"hil: not built, the venv {venv} cannot be made: {why}")
    except BaseException:
        if (venv / "pyvenv.cfg").exists():
            shutil.rmtree(venv, ignore_errors=True)
        raise


def build(venv: Path, extras: list[str], *, compiles: bool) -> str:
    """Do all steps; returns why one failed, or nothing."""
    steps = Steps(3 if compiles else 2)
    own = {name: value for name, value in os.environ.items() if name not in OF_OTHERS} | {"PIP_USER": "0"}
    if runs(venv):
        steps.say(1, f"the venv {venv} is there")
    else:
        steps.say(1, f"make the venv {venv} of Python {sys.version.split()[0]}")
        make_venv(venv, own)
    pip = [str(venv / "bin" / "python"), "-m", "pip", "install", "--disable-pip-version-check"]
    before = installed(venv)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        progress = Path(folder) / "progress"
        progress.touch()
        env = own | {"HIL_BUILD_PROGRESS": str(progress), "TMPDIR": folder}
        wanted = requirements(extras)
        what = f"fetch and install {len(wanted)} Python packages and what they need"
        steps.say(2, what)
        # A release without a wheel would be compiled, where an older one has a wheel.
        jobs = [Job(2, "Python packages", venv / "packages.log", [*pip, "--prefer-binary", *wanted], env)]
        try:
            if compiles:
                steps.say(3, "compile the C core, about 25 s on two idle cores")
                command = [*pip, "-q", "--no-deps", "-e", str(ROOT)]
                jobs.append(Job(3, "the C core", venv / "core.log", command, env))
            while None in (codes := [job.code for job in jobs]) and not any(codes):
                time.sleep(0.2 if sys.stdout.isatty() else 1)
                for job in jobs:
                    job.tell_end(steps)
                said = [of_packages(jobs[0].said(), installed(venv) - before)] if jobs[0].code is None else []
                said += [of_core(progress)] if jobs[-1].code is None and compiles else []
                if said:
                    steps.progress("; ".join(said))
            for job in jobs:
                job.tell_end(steps)
            failed = [job.said() for job in jobs if job.code]
        finally:
            for job in jobs:
                job.end()
    return (cause(failed[0]) or "for the reason above") if failed else ""


def main() -> None:
    if sys.version_info < (3, 11):  # noqa: UP036 - it may be started with any
        sys.exit(
            f"hil: needs Python 3.11 or newer, and this is {sys.version.split()[0]};"
            " name another: make PYTHON=python3.13"
        )
    words = sys.argv[1:]
    if words[:1] == ["--cause"]:
        print(cause(Path(words[1]).read_text(errors="replace")) or "for the reason above")
        return
    compiles, only_checks = "--packages" not in words, "--check" in words
    if why := missing(compiles=compiles):
        sys.exit(f"hil: not built, {why}")
    if only_checks:
        return
    venv, *extras = (each for each in words if not each.startswith("--"))
    begun = time.monotonic()
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.default_int_handler)
    try:
        with alone():
            why = build(Path(venv), extras, compiles=compiles)
    except KeyboardInterrupt:
        sys.exit("\nhil: not built, interrupted; run the same command again")
    except OSError as error:
        why = cause(str(error)) or "see to that"
        sys.exit(f"hil: not built, {error.filename or 'a file'}: {error.strerror}; {why}")
    if why:
        sys.exit(f"hil: not built, {why}; then run the same command again")
    print(f"Built in {time.monotonic() - begun:.0f} s.", flush=True)


if __name__ == "__main__":
    main()
