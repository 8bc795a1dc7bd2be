"""Load of 252 SACs on a line in real time, which one core has to carry. Two cases: at 38400 baud broadcasts
alone, the line never idle; at 1 Mbaud one broadcast in ten commands, the others each to another node, which
acknowledges it.

The bursts of a second are played at their own times, those of the next when they are over: of a daemon that
comes behind they would collide with what is left. Prints the daemon's CPU seconds for a second of the line's
time (a core has one), how long it took, and the share of the packets asked for that was on the wire.
"""

import json
import select
import sys
import time
from pathlib import Path

from _processes import Daemon, cpu_s, daemon
from _report import check_work

from device_profiles.sac.packet import encode
from hil.net.control_client import ask

NODES = range(4, 256)
SECONDS = 5 if "--quick" in sys.argv else 20
ALL, MASTER = 0, 1
ACK_CHARACTERS = 2 + 7 + 2
"""Characters after a command to one node: turnaround, its ACK, and the master's wait after that."""
PIECE_S = 1.0
LONGEST_S = 10.0
"""Maximum wait for the packets of a second: those that have not come were lost."""


def config(baud: int) -> str:
    names = [f"s{address}" for address in NODES]
    segment = {"stations": names, "taps": {"m": {"port": "tcp"}}, "baud": baud}
    devices = {name: {"profile": "sac", "port": "tcp"} for name in names}
    return json.dumps({"bench": "bench", "devices": devices, "segments": {"bus0": segment}})


def wait_s(seconds: float) -> None:
    select.select([], [], [], seconds)


def set_up(control: Path, baud: int) -> None:
    for address in NODES:
        for line in (f"$CM{address}", f"$Cn{baud}"):
            ask(control, "type", device=f"s{address}", text=f"{line}\\r")
    wait_s(3)
    for address in NODES:
        ask(control, "type", device=f"s{address}", text="$R\\r")
    wait_s(4)


def one_second(baud: int, broadcasts_of_ten: int, number: int) -> list[tuple[int, str]]:
    """Packets of one second of line time: rows of (start in ns, bytes in hexadecimal)."""
    character_ns = 10 * 10**9 / baud
    rows, at_ns, count = [], 0.0, number * 1000
    while at_ns < 0.999e9:
        is_for_all = count % 10 < broadcasts_of_ten
        to = ALL if is_for_all else NODES[count * 7 % len(NODES)]
        raw = encode(to, MASTER, b"v%d" % (150 + count % 2))
        rows.append((round(at_ns), raw.hex()))
        at_ns += (len(raw) + (0 if is_for_all else ACK_CHARACTERS)) * character_ns + 1
        count += 1
    return rows


def measure(about: str, running: Daemon, control: Path, baud: int, broadcasts_of_ten: int) -> None:
    def packets() -> int:
        return int(ask(control, "segments")[0]["packets"])

    asked, before, took_s = 0, packets(), 0.0
    cpu = cpu_s(running.pid)
    for number in range(SECONDS):
        rows = one_second(baud, broadcasts_of_ten, number)
        asked += len(rows) + sum(bytes.fromhex(raw)[1] != ALL for _, raw in rows)
        began_s = time.monotonic()
        ask(control, "play", tap="bus0.m", bursts=rows)
        wait_s(PIECE_S)
        while packets() - before < asked and time.monotonic() - began_s < LONGEST_S:
            wait_s(0.02)
        took_s += time.monotonic() - began_s
    spent_s, share = cpu_s(running.pid) - cpu, (packets() - before) / asked
    print(f"{about}: {spent_s / SECONDS:.2f} s of CPU and {took_s / SECONDS:.2f} s of time a second")
    print(f"  {share:.1%} of {asked} packets")
    check_work("packets on the wire", share * asked, asked, 0.01)


def main() -> None:
    for about, baud, broadcasts in (
        ("38400 baud, broadcasts alone", 38400, 10),
        ("1 Mbaud, one broadcast in ten", 1_000_000, 1),
    ):
        with daemon(config(baud)) as running:
            control = running.folder / "run" / "bench" / "control.sock"
            wait_s(3)
            set_up(control, baud)
            measure(about, running, control, baud, broadcasts)


if __name__ == "__main__":
    main()
