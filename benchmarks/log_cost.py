"""CPU time that a round trip costs a daemon whose run is recorded, and one with a capture, against one with
neither.

Three equal daemons run side by side and have the same trips at a pseudo-terminal, in turn by blocks of 20;
medians of some turns of 2000. What a daemon takes without trips is subtracted: turns of 200 were less than
that. At most 1.25 times is wanted. The time of the trip itself and the share of wakes that the core missed
are reported beside it: texts are made behind the answer.
"""

import json
import statistics
import subprocess
import time
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager

import serial
from _processes import HIL, Daemon, daemon, precise_cpu_s
from _report import check_work, is_quick, report

CONFIG = json.dumps(
    {"bench": "bench", "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}}}
)
TRIPS = (b"0\n", 6), (b"r", 17)
BLOCK, BLOCKS = 10, 100
"""Pairs of trips one after the other, and number of such blocks in a turn."""
TURNS = 5 if is_quick() else 15
STARTED_S, STILL_S = 5.0, 3.0
SETTLED_S = 0.3
"""Time after the trips of a turn: what is made after the answers belongs to them."""
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
        self.still_share = 0.0
        self.cpu_us: list[float] = []
        self.trip_us: list[float] = []

    def used_s(self) -> float:
        """CPU time that the daemon has used so far, without what it takes with nothing to do."""
        return precise_cpu_s(self._running.pid) - self.still_share * time.monotonic()

    def trips(self) -> None:
        """Have a block of trips."""
        began = time.perf_counter()
        for _ in range(BLOCK):
            for command, length in TRIPS:
                self._port.write(command)
                check_work("bytes answered", len(self._port.read(length)), length)
        self.trip_us.append((time.perf_counter() - began) / BLOCK / len(TRIPS) * 1e6)


def stand_still(sides: Iterable[Side]) -> None:
    """Measure what each daemon takes without trips."""
    before, began_s = [side.used_s() for side in sides], time.monotonic()
    time.sleep(STILL_S)
    for side, before_s in zip(sides, before, strict=True):
        side.still_share = (side.used_s() - before_s) / (time.monotonic() - began_s)


def turn(sides: Iterable[Side]) -> None:
    """Note what a trip costs each side: blocks in turns, so that other load slows all of them down alike."""
    before = [side.used_s() for side in sides]
    for _ in range(BLOCKS):
        for side in sides:
            side.trips()
    time.sleep(SETTLED_S)
    for side, before_s in zip(sides, before, strict=True):
        side.cpu_us.append((side.used_s() - before_s) / BLOCKS / BLOCK / len(TRIPS) * 1e6)


def main() -> None:
    with ExitStack() as stack:
        plain, logged, read = (
            stack.enter_context(daemon(CONFIG, is_recorded=is_recorded))
            for is_recorded in (False, True, False)
        )
        time.sleep(STARTED_S)
        stack.enter_context(captured(read))
        time.sleep(1)
        sides = {"plain": Side(plain), "log": Side(logged), "capture": Side(read)}
        stand_still(sides.values())
        for _ in range(TURNS):
            turn(sides.values())
        missed = {"missed": logged.missed_share(), "reference_missed": plain.missed_share()}
    bare = sides.pop("plain")
    extra: dict[str, object] = {"reference": "the same trips at a daemon with neither"}
    for name, side in sides.items():
        trip = {"trip_us": statistics.median(side.trip_us), "reference_us": statistics.median(bare.trip_us)}
        cpu_us, reference_us = statistics.median(side.cpu_us), statistics.median(bare.cpu_us)
        report(
            f"{name}_cpu", cpu_us, "us", reference_us, LIMIT, extra | trip | (missed if name == "log" else {})
        )
        print(f"a trip: {trip}; {missed if name == 'log' else ''}", flush=True)


if __name__ == "__main__":
    main()
