"""Resident memory of a daemon, with every kind of port and every board imported, and as it starts."""

import json
import sys
import time

from _processes import daemon, rss_MB
from _report import report

ONE = {"profile": "mechaduino"}
LIMIT_MB = 80.0
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


def main() -> None:
    """Resident memory a second after the start."""
    bare = bare_MB()
    with daemon(config({"m1": ONE})) as running:
        time.sleep(1)
        alone = rss_MB(running.pid)
    everything = ";".join(f"import {name}" for name in LIBRARIES)
    kinds = config({"m1": ONE, "m2": ONE | {"port": {"kind": "tcp", "port": 0}}})
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


if __name__ == "__main__":
    main()
