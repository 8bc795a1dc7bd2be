"""Resident memory of a daemon, with every kind of port and every board imported, and as it starts; of each of
several, what they share divided among them."""

import json
import sys
import time
from contextlib import ExitStack
from pathlib import Path

from _processes import daemon, rss_MB
from _report import report

ONE = {"profile": "mechaduino"}
LIMIT_MB = 80.0
SIDE_BY_SIDE = 8
TWIN_LIMIT_MB = 40.0
"""Memory of each of a hundred benches on a computer of 4 GB."""
LIBRARIES = ("serial", "yaml", "pydantic", "typer", "rich")
"""Libraries of an installation without extras; the daemon itself leaves out what it does not use."""


def config(devices: dict[str, object]) -> str:
    return json.dumps({"bench": "bench", "devices": devices})


def bare_MB() -> float:
    import subprocess

    code = "import asyncio, time; print(flush=True); time.sleep(60)"
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE)
    assert process.stdout
    process.stdout.readline()
    try:
        return rss_MB(process.pid)
    finally:
        process.kill()
        process.wait()


def pss_MB(pid: int) -> float:
    """Resident memory of a process; of what several share, its part."""
    lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("Pss:")) / 1024


def twin_MB() -> float:
    """Memory of each of several benches with one board, five seconds after the start."""
    with ExitStack() as stack:
        twins = [stack.enter_context(daemon(config({"m1": ONE}))) for _ in range(SIDE_BY_SIDE)]
        time.sleep(5)
        return sum(pss_MB(twin.pid) for twin in twins) / SIDE_BY_SIDE


def main() -> None:
    """Resident memory a second after the start."""
    bare = bare_MB()
    with daemon(config({"m1": ONE})) as running:
        time.sleep(1)
        alone = rss_MB(running.pid)
    everything = ";".join(f"import {name}" for name in LIBRARIES)
    kinds = config({"m1": ONE, "m2": ONE | {"port": {"kind": "tcp", "listen": 0}}})
    # All libraries too: a bridge may be used one day, and the figure includes it.
    with daemon(
        kinds,
        prefix=(
            sys.executable,
            "-c",
            f"{everything};import sys;from hil.cli.entry import main;sys.argv=sys.argv[1:];main()",
        ),
    ) as running:
        time.sleep(1)
        full = rss_MB(running.pid)
    extra = {"reference": "a Python that imports asyncio", "limit_MB": LIMIT_MB, "holds": full <= LIMIT_MB}
    report("memory_everything_imported", full, "MB", bare, None, extra)
    print(f"  to be at most {LIMIT_MB:g} MB: {'yes' if full <= LIMIT_MB else 'NO'}")
    report("memory_one_board", alone, "MB", bare, None, {"reference": extra["reference"]})
    limit = {"reference": "the limit: 40 MB, as 100 are to have 4 GB"}
    report("memory_side_by_side", twin_MB(), "MB", TWIN_LIMIT_MB, 1.0, limit)


if __name__ == "__main__":
    main()
