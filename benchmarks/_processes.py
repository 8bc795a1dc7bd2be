"""Processes that benchmarks start and look at."""

import os
import select
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from hil.net.control_client import ControlError, ask

HIL = str(Path(sys.executable).with_name("hil"))
_TICKS_PER_S = os.sysconf("SC_CLK_TCK")


def have(program: str, package: str) -> bool:
    """True if a program is installed; if not, prints the package to install."""
    if shutil.which(program):
        return True
    print(f"skipped: needs {program}: sudo apt install {package}", flush=True)
    return False


def cpu_s(pid: int) -> float:
    """CPU time of a process so far, all its threads."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / _TICKS_PER_S


def precise_cpu_s(pid: int) -> float:
    """CPU time of a process so far, from the scheduler's nanoseconds of all its threads."""
    tasks = Path(f"/proc/{pid}/task")
    return sum(int((task / "schedstat").read_text().split()[0]) for task in tasks.iterdir()) * 1e-9


def rss_MB(pid: int) -> float:
    """Resident memory of a process."""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1024
    raise ValueError(f"process {pid} has no VmRSS")


class Daemon:
    """A running ``hil serve``; its output in ``output``."""

    def __init__(self, process: subprocess.Popen[bytes], folder: Path, out: Path) -> None:
        self.process = process
        self.folder = folder
        self._out = out

    @property
    def pid(self) -> int:
        return self.process.pid

    @property
    def output(self) -> str:
        return self._out.read_text()

    @property
    def serves(self) -> bool:
        """True once the control socket answers."""
        sockets = list(self.folder.glob("run/*/control.sock"))
        with suppress(ControlError):
            return bool(sockets and ask(sockets[0], "list"))
        return False

    def missed_share(self) -> float:
        """Share of the core's wakes that came too late so far."""
        (control,) = self.folder.glob("run/*/control.sock")
        status = ask(control, "status")
        return status["missed"] / max(status["ticks"] + status["missed"], 1)

    def port(self, device: str, bench: str = "bench") -> str:
        """Path of a device's pseudo-terminal."""
        return str(self.folder / "run" / bench / device)


@contextmanager
def daemon(config: str, prefix: Sequence[str] = (), *, is_recorded: bool = True) -> Iterator[Daemon]:
    """Run ``hil serve`` with this configuration for the block, which begins when everything serves.
    ``is_recorded``: as a user's run is."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "bench.yaml").write_text(config)
        out = folder / "out"
        with out.open("wb") as file:
            process = subprocess.Popen(
                [
                    *prefix,
                    *(HIL, "serve", str(folder / "bench.yaml")),
                    *("--runtime-dir", str(folder / "run"), "--state-dir", str(folder / "state")),
                    *(() if is_recorded else ("--no-log",)),
                ],
                stdout=file,
                stderr=file,
            )
        running = Daemon(process, folder, out)
        try:
            deadline = time.monotonic() + 30
            while not running.serves:
                if process.poll() is not None or time.monotonic() > deadline:
                    raise RuntimeError(f"the daemon did not start: {running.output}")
                select.select([], [], [], 0.002)
            yield running
        finally:
            process.terminate()
            process.wait(10)


@contextmanager
def load(wanted: bool) -> Iterator[None]:
    """Run two busy processes beside the measurement, if wanted."""
    if not wanted:
        yield
        return
    process = subprocess.Popen(["stress-ng", "--quiet", "--cpu", "2"], stdout=subprocess.DEVNULL)
    try:
        yield
    finally:
        process.terminate()
        process.wait(10)
