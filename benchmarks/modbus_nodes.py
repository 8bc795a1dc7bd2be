"""Modbus nodes on a line in real time: 32 units polled without a pause, ten registers each.

The polls of two seconds are played at the times that ``hil modbus cycle`` computes, so that the line is as
full as it can be. Prints polls and packets that are missing, and the daemon's CPU seconds for a second:
what the boards cost that nobody asks, and with the polls; then the same with two boards. Last a master at the
tap's pseudo-terminal, which sends a request 3.5 characters behind the answer. Wanted: 0 missing, and at most
0.3 of a core.
"""

import json
import os
import select
import sys
import time
import tty
from pathlib import Path

from _processes import Daemon, daemon, precise_cpu_s
from _report import check_work, is_quick, report

from bridges.modbus.protocol.client_side import encode as encode_request
from bridges.modbus.protocol.client_side import read
from bridges.modbus.protocol.frame import encode
from bridges.modbus.protocol.pdu import Table
from bridges.modbus.protocol.poll_cycle import Poll, PollCycle
from hil.net.control_client import ask
from hil.vocab.line_format import FORMATS

UNITS = 32
PIECES = 2 if is_quick() else 10
PIECE_S = 2.0
IDLE_S = 2 if is_quick() else 10
TRIPS = 200 if is_quick() else 1000
REGISTERS = 10
CORE_LIMIT = 0.3
LONGEST_S = 10.0
UP_S = 4.5
REQUEST = encode_request(read(Table.INPUT_REGISTERS, 0, REGISTERS))


def config(units: int, baud: int, form: str) -> str:
    names = [f"m{unit}" for unit in range(1, units + 1)]
    device = {"profile": "mechaduino", "port": "tcp", "flash": {"table": "identity"}}
    wire = {
        "modbus": {"units": {name: unit for unit, name in enumerate(names, 1)}, "response_ms": 0.5},
        "taps": {"master": {}},
        "baud": baud,
        "format": form,
    }
    return json.dumps({"bench": "bench", "devices": dict.fromkeys(names, device), "segments": {"bus0": wire}})


def wait_s(seconds: float) -> None:
    select.select([], [], [], seconds)


def counted(control: Path) -> tuple[int, int]:
    """Packets on the line, and errors."""
    (row,) = ask(control, "segments")
    return int(row["packets"]), sum(row["errors"].values())


def idle(running: Daemon) -> float:
    """CPU seconds a second while nobody asks."""
    before = precise_cpu_s(running.pid)
    wait_s(IDLE_S)
    return (precise_cpu_s(running.pid) - before) / IDLE_S


def polled(running: Daemon, control: Path, cycle: PollCycle) -> tuple[int, int, float]:
    """Polls and missing packets, and CPU seconds a second."""
    times = list(cycle.times())
    (first, wrong), cpu, count, took_s = counted(control), precise_cpu_s(running.pid), 0, 0.0
    for _ in range(PIECES):
        rows, at_ns = [], 0
        while at_ns + times[-1].end_ns < PIECE_S * 1e9:
            rows += [(at_ns + each.start_ns, encode(each.poll.unit, 4, REQUEST[1:]).hex()) for each in times]
            at_ns += times[-1].end_ns
        count += len(rows)
        began_s = time.monotonic()
        ask(control, "play", tap="bus0.master", bursts=rows)
        wait_s(at_ns / 1e9)
        while counted(control)[0] - first < 2 * count and time.monotonic() - began_s < LONGEST_S:
            wait_s(0.02)
        took_s += time.monotonic() - began_s
    spent_s, (last, errors) = precise_cpu_s(running.pid) - cpu, counted(control)
    return count, 2 * count - (last - first) + errors - wrong, spent_s / took_s


def asked_at_the_pty(path: str, units: int, silence_s: float) -> tuple[int, float]:
    """Requests without their answer, and requests a second, of a master that waits for each answer and the
    silence behind it."""
    fd = os.open(path, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(fd)
    missing, began_s = 0, time.monotonic()
    for trip in range(TRIPS):
        os.write(fd, encode(trip % units + 1, 4, REQUEST[1:]))
        got = b""
        while len(got) < 5 + 2 * REGISTERS and select.select([fd], [], [], 1.0)[0]:
            got += os.read(fd, 256)
        missing += len(got) < 5 + 2 * REGISTERS
        time.sleep(silence_s)
    os.close(fd)
    return missing, TRIPS / (time.monotonic() - began_s)


def measure(units: int, baud: int, form: str) -> float:
    """Measure a line; answers the CPU seconds a second."""
    cycle = PollCycle(baud, FORMATS[form], [Poll(n, 4, REGISTERS) for n in range(1, units + 1)], 500_000)
    with daemon(config(units, baud, form)) as running:
        control = running.folder / "run" / "bench" / "control.sock"
        wait_s(UP_S)
        alone = idle(running)
        count, missing, busy = polled(running, control, cycle)
        lost, rate = asked_at_the_pty(running.port("bus0.master"), units, cycle.silence_ns / 1e9)
    print(f"{units} units at {baud} baud {form}, {cycle.summary()['polls_per_s']:.0f} polls/s of the line:")
    print(
        f"  {count} polls, {missing} packets missing; {alone:.3f} s of CPU a second idle, {busy:.3f} polled"
    )
    print(f"  a master at the pty: {TRIPS} requests, {lost} without answer, {rate:.0f} a second", flush=True)
    check_work("packets on the line", 2 * count - missing, 2 * count, 0.01)
    check_work("answers at the pty", TRIPS - lost, TRIPS, 0.01)
    return busy


def main() -> None:
    few = measure(2, 115200, "8N1")
    many = measure(UNITS, 115200, "8N1")
    measure(UNITS, 19200, "8E1")
    extra = {"reference": "0.3 of a core", "two_units": few}
    report("modbus_nodes", many, "s/s", CORE_LIMIT, 1.0, extra)


if __name__ == "__main__":
    sys.exit(main())
