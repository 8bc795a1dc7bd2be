"""A command to a board and its answer back through a pseudo-terminal, against a bare asyncio echo.

The client is pyserial, as users have it.

`r` is answered at once and touches no state of the axis; the number that follows sets the set-point, so that
the answer may have to wait for the core to leave the axis."""

import json
import statistics
import subprocess
import sys
import time

import serial
from _processes import daemon
from _report import is_quick, report

LIMIT = 1.3
WAKE_US = 1000.0
ECHO = """
import asyncio, os, pty, tty
master, slave = pty.openpty()
tty.setraw(slave)
print(os.ttyname(slave), flush=True)
async def main():
    asyncio.get_running_loop().add_reader(master, lambda: os.write(master, os.read(master, 4096)))
    await asyncio.sleep(3600)
asyncio.run(main())
"""


def trip_us(port: serial.Serial, command: bytes, length: int) -> float:
    began = time.perf_counter_ns()
    port.write(command)
    answer = port.read(length)
    taken = (time.perf_counter_ns() - began) / 1000
    if len(answer) != length:
        raise RuntimeError(f"{command!r} was answered with {answer!r}")
    return taken


def opened(path: str) -> serial.Serial:
    return serial.Serial(path, 115200, timeout=5)


def main() -> None:
    """Blocks of 200 trips, in turn; medians."""
    echo = subprocess.Popen([sys.executable, "-c", ECHO], stdout=subprocess.PIPE, text=True)
    assert echo.stdout
    plain, fast, state = [], [], []
    try:
        config = {
            "bench": "bench",
            "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}},
        }
        with daemon(json.dumps(config)) as running:
            bare, board = opened(echo.stdout.readline().strip()), opened(running.port("m1"))
            time.sleep(4.5)
            board.reset_input_buffer()
            for _ in range(5 if is_quick() else 20):
                plain += [trip_us(bare, b"r", 1) for _ in range(200)]
                for _ in range(100):
                    fast.append(trip_us(board, b"r", 17))
                    state.append(trip_us(board, b"0\n", 6))
    finally:
        echo.kill()
        echo.wait()
    reference = statistics.median(plain)
    extra = {"reference": "one byte through a bare asyncio echo on a pseudo-terminal; pyserial at both"}
    for name, trips, limit in (
        ("pty_round_trip", fast, LIMIT),
        ("pty_round_trip_axis", state, (LIMIT * reference + WAKE_US) / reference),
    ):
        p99 = {
            "p99_us": statistics.quantiles(trips, n=100)[98],
            "reference_p99_us": statistics.quantiles(plain, n=100)[98],
        }
        report(name, statistics.median(trips), "us", reference, limit, extra | p99)


if __name__ == "__main__":
    main()
