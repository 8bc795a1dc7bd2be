"""CPU time that a round trip costs a daemon with an input log, and with a capture, against one with neither.

Three equal daemons run side by side and have the same trips through a pseudo-terminal, in turns; medians of
the turns. What a daemon takes without trips is subtracted. At most 1.25 times is wanted. The time of the trip
itself is reported beside it: texts are made after the answer.
"""

import json
import statistics
import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import serial
from _processes import HIL, Daemon, daemon, precise_cpu_s
from _report import check_work, is_quick, report

CONFIG = json.dumps(
    {"bench": "bench", "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}}}
)
TRIPS = (b"0\n", 6), (b"r", 17)
TURNS, PAIRS = (3, 100) if is_quick() else (15, 400)
STARTED_S, STILL_S = 5.0, 0.3
LIMIT = 1.25


@contextmanager
def captured(running: Daemon) -> Iterator[None]:
    """Capture the board's port for the block."""
    command = [HIL, "capture", "m1", "--write", str(running.folder / "m1.pcapng")]
    process = subprocess.Popen(
        [*command, "--runtime-dir", str(running.folder / "run")], stderr=subprocess.DEVNULL
    )
    try:
        yield
        check_work("captures that run", process.poll() is None, 1)
    finally:
        process.terminate()
        process.wait(10)


class Side:
    """A daemon, a client at its port, and the figures of its trips in microseconds."""

    def __init__(self, running: Daemon) -> None:
        self._running = running
        self._port = serial.Serial(running.port("m1"), 115200, timeout=5)
        self._port.write(b"r")
        self._port.read_until(b"setpoint:\r\n")
        self.cpu_us: list[float] = []
        self.trip_us: list[float] = []

    def turn(self) -> None:
        cpu_s, at_s = precise_cpu_s(self._running.pid), time.monotonic()
        time.sleep(STILL_S)
        still = (precise_cpu_s(self._running.pid) - cpu_s) / (time.monotonic() - at_s)
        cpu_s, at_s = precise_cpu_s(self._running.pid), time.monotonic()
        for _ in range(PAIRS):
            for command, length in TRIPS:
                self._port.write(command)
                check_work("bytes answered", len(self._port.read(length)), length)
        tripped_s = time.monotonic() - at_s
        time.sleep(STILL_S)  # what is made after the answers belongs to them
        spent_s = precise_cpu_s(self._running.pid) - cpu_s - still * (time.monotonic() - at_s)
        self.cpu_us.append(spent_s / PAIRS / len(TRIPS) * 1e6)
        self.trip_us.append(tripped_s / PAIRS / len(TRIPS) * 1e6)


def main() -> None:
    with ExitStack() as stack:
        plain, logged, read = (stack.enter_context(daemon(CONFIG, log=log)) for log in (False, True, False))
        time.sleep(STARTED_S)
        stack.enter_context(captured(read))
        time.sleep(1)
        sides = {"plain": Side(plain), "log": Side(logged), "capture": Side(read)}
        for _ in range(TURNS):
            for side in sides.values():
                side.turn()
    bare = sides.pop("plain")
    extra: dict[str, object] = {"reference": "the same trips at a daemon without a log and a capture"}
    for name, side in sides.items():
        trip = {"trip_us": statistics.median(side.trip_us), "reference_us": statistics.median(bare.trip_us)}
        cpu_us, reference_us = statistics.median(side.cpu_us), statistics.median(bare.cpu_us)
        report(f"{name}_cpu", cpu_us, "us", reference_us, LIMIT, extra | trip)


if __name__ == "__main__":
    main()
