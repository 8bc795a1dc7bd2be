"""Time from `hil serve` to a port that takes bytes. The board's own four seconds come after."""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from _processes import HIL
from _report import is_quick, report

CONFIG = "bench: bench\ndevices: {m1: {profile: mechaduino}}\n"
LIMIT_S = 1.0


def start_s() -> float:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "bench.yaml").write_text(CONFIG)
        port = folder / "run" / "bench" / "m1"
        command = [HIL, "serve", str(folder / "bench.yaml"), "--runtime-dir", str(folder / "run")]
        began = time.perf_counter()
        process = subprocess.Popen(
            [*command, "--state-dir", str(folder / "state")],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            while True:
                try:
                    fd = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
                    os.write(fd, b"\n")
                    os.close(fd)
                    return time.perf_counter() - began
                except OSError:
                    if time.perf_counter() - began > 30:
                        raise
        finally:
            process.terminate()
            process.wait(10)


def import_s() -> float:
    began = time.perf_counter()
    subprocess.run([sys.executable, "-c", "import asyncio, yaml, pydantic, typer"], check=True)
    return time.perf_counter() - began


def main() -> None:
    """Medians of alternating runs."""
    starts, imports = [], []
    for _ in range(5 if is_quick() else 15):
        starts.append(start_s())
        imports.append(import_s())
    value = statistics.median(starts)
    extra = {
        "reference": "a Python that imports asyncio, yaml, pydantic and typer, and ends",
        "limit_s": LIMIT_S,
        "holds": value <= LIMIT_S,
        "runs_s": starts,
    }
    report("start_up", value, "s", statistics.median(imports), None, extra)
    print(f"  to be at most {LIMIT_S:g} s: {'yes' if value <= LIMIT_S else 'NO'}")


if __name__ == "__main__":
    main()
