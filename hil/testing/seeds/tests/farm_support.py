"""A Dask scheduler and workers as processes, each with a prefix of its command, for tests of farms."""

import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

READY_S = 60.0


class FarmProcess:
    """Scheduler or worker, whose log is in a file."""

    def __init__(self, log: Path, words: Sequence[str], before: Sequence[str] = ()) -> None:
        self._log = log
        with log.open("w") as file:
            dask = [sys.executable, "-m", "dask", *words]
            self.process = subprocess.Popen([*before, *dask], stdout=file, stderr=file)

    def says(self, text: str) -> None:
        """Wait until its log has a text."""
        deadline = time.monotonic() + READY_S
        while text not in self._log.read_text():
            assert self.process.poll() is None, self._log.read_text()
            assert time.monotonic() < deadline, self._log.read_text()
            time.sleep(0.1)

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()


def start_scheduler(folder: Path, host: str, port: int, before: Sequence[str] = ()) -> FarmProcess:
    words = ["scheduler", "--host", host, "--port", str(port), "--no-dashboard"]
    made = FarmProcess(folder / "scheduler.log", words, before)
    made.says("Scheduler at:")
    return made


def start_worker(
    folder: Path, name: str, address: str, before: Sequence[str] = (), *options: str
) -> FarmProcess:
    words = ["worker", address, "--no-nanny", "--no-dashboard", "--nthreads", "1", "--name", name]
    words += ["--local-directory", str(folder / name), *options]
    made = FarmProcess(folder / f"{name}.log", words, before)
    made.says("Registered to:")
    return made
