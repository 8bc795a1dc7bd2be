"""Load of 252 SACs on a line in real time, which one core has to carry. Two cases: at 38400 baud broadcasts
alone, the line never idle; at 1 Mbaud one broadcast in ten commands, the others each to another node, which
acknowledges it.

The bursts of a second are played at their own times, those of the next when they are over: of a daemon that
comes behind they would collide with what is left. ``segment_live_broadcasts``, ``segment_live_mixed``: the
daemon's CPU seconds for a second of the line's time, of which a core has one, and 0.9 are wanted of the mixed
case; beside them how long a second took, and the share of the packets asked for that was on the wire.
"""

import json
import select
import time
from pathlib import Path

from _processes import Daemon, cpu_s, daemon
from _report import check_work, is_quick, report

from device_profiles.sac.packet import encode
from hil.net.control_client import ask

NODES = range(4, 256)
SECONDS = 5 if is_quick() else 20
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


def measure(name: str, limit: float, running: Daemon, baud: int, broadcasts_of_ten: int) -> None:
    control = running.folder / "run" / "bench" / "control.sock"
    wait_s(3)
    set_up(control, baud)

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
    check_work("packets on the wire", share * asked, asked, 0.01)
    extra = {"reference": "one core", "took_s": took_s / SECONDS, "packets": asked, "share": share}
    report(f"segment_live_{name}", spent_s / SECONDS, "s/s", 1.0, limit, extra)


def main() -> None:
    for name, limit, baud, broadcasts in (("broadcasts", 1.0, 38400, 10), ("mixed", 0.9, 1_000_000, 1)):
        with daemon(config(baud)) as running:
            measure(name, limit, running, baud, broadcasts)


if __name__ == "__main__":
    main()
