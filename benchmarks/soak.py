"""Memory that packets leave behind, and page faults of the core, in a daemon in real time that answers all it
can.

Masters at tcp taps command a SAC each over a segment, and send the next command when they have the
answer, for as many seconds as the first argument says (120; `make soak-load` takes longer). Prints the
slope of the daemon's own memory over the packets, with its standard error, and the page faults of the
core's thread; both after a warm-up of a fifth of the time. A packet without an answer ends it.
"""

import json
import os
import select
import socket
import sys
import time
from pathlib import Path

from _processes import Daemon, cpu_s, daemon
from _report import is_quick, report

from device_profiles.sac.packet import PacketDecoder, encode
from hil.net.control_client import ask

SEGMENTS = 16
SPEED = 20
NODE, MASTER = 85, 1
COMMAND = b"v150"
SAMPLE_S = 1.0
WARM_UP = 0.2
MOST_MiB_PER_1E7 = 1.0


def config() -> str:
    names = [f"s{n}" for n in range(SEGMENTS)]
    segments = {f"bus{n}": {"stations": [f"s{n}"], "taps": {"m": {"port": "tcp"}}} for n in range(SEGMENTS)}
    devices = {name: {"profile": "sac"} for name in names}
    return json.dumps({"bench": "bench", "speed": SPEED, "devices": devices, "segments": segments})


class Master:
    """Keeps a packet under way, and counts the answers."""

    def __init__(self, address: str) -> None:
        host, _, number = address.removeprefix("socket://").rpartition(":")
        self.socket = socket.create_connection((host, int(number)))
        self._decoder = PacketDecoder()
        self.answers = 0
        self._send()

    def _send(self) -> None:
        self.socket.sendall(encode(NODE, MASTER, COMMAND))

    def take(self) -> None:
        if self._decoder.feed(self.socket.recv(65536)):
            self.answers += 1
            self._send()


def anonymous_MiB(pid: int) -> float:
    """Anonymous memory of a process, counted page by page: the kernel's own sum in /proc/PID/status is up to
    32 pages a CPU behind."""
    text = Path(f"/proc/{pid}/smaps_rollup").read_text()
    return int(text.partition("Anonymous:")[2].split()[0]) / 1024


def core_faults(pid: int) -> tuple[int, int]:
    """Minor and major page faults of the core's thread: the one that is scheduled first in, first out.

    Raises:
        SystemExit: there is none; real time is not permitted.
    """
    for task in Path(f"/proc/{pid}/task").iterdir():
        fields = (task / "stat").read_text().rpartition(")")[2].split()
        if int(fields[38]) == os.SCHED_FIFO:
            return int(fields[7]), int(fields[9])
    raise SystemExit("the core's thread has no real-time priority: `hil doctor` says why")


def slope(points: list[tuple[float, float]]) -> tuple[float, float]:
    """Slope of a straight line through points, and its standard error."""
    count = len(points)
    mean_x = sum(x for x, _ in points) / count
    mean_y = sum(y for _, y in points) / count
    spread = sum((x - mean_x) ** 2 for x, _ in points)
    rise = sum((x - mean_x) * (y - mean_y) for x, y in points) / spread
    rest = sum((y - mean_y - rise * (x - mean_x)) ** 2 for x, y in points)
    return rise, float((rest / (count - 2) / spread) ** 0.5)


def soak(running: Daemon, seconds: float) -> None:
    control = running.folder / "run" / "bench" / "control.sock"
    while ask(control, "status")["sim_ns"] < 2_000_000_000:
        select.select([], [], [], 0.1)
    rows = ask(control, "segments")
    masters = {master.socket: master for master in (Master(row["taps"][0]["address"]) for row in rows)}
    began_s, warm_s = time.monotonic(), WARM_UP * seconds
    next_s, faults, points = warm_s, (0, 0), []
    while (now_s := time.monotonic() - began_s) < seconds:
        ready, _, _ = select.select(list(masters), [], [], 5)
        if not ready:
            raise SystemExit("a node does not answer any more")
        for each in ready:
            masters[each].take()
        if now_s >= next_s:
            if not points:
                faults, cpu_before_s = core_faults(running.pid), cpu_s(running.pid)
            packets = 2 * sum(master.answers for master in masters.values())
            points.append((float(packets), anonymous_MiB(running.pid)))
            next_s += SAMPLE_S
    minor, major = (now - then for now, then in zip(core_faults(running.pid), faults, strict=True))
    rise, error = slope(points)
    packets = points[-1][0] - points[0][0]
    status = ask(control, "status")
    extra: dict[str, object] = {
        "reference": "the limit",
        "standard_error": error * 1e7,
        "packets": packets,
        "seconds": seconds - warm_s,
        "cpu_us_per_packet": (cpu_s(running.pid) - cpu_before_s) / packets * 1e6,
        "memory_MiB": [points[0][1], points[-1][1]],
        "core_faults": [minor, major],
        "ticks_missed": [status["ticks"], status["missed"]],
    }
    report("memory_slope", rise * 1e7, "MiB per 1e7 packets", MOST_MiB_PER_1E7, 1.0, extra)
    print(f"  +- {error * 1e7:.2f} (standard error); {packets:.3g} packets in {seconds - warm_s:.0f} s")
    print(f"  memory at the begin {points[0][1]:.2f} MiB, at the end {points[-1][1]:.2f} MiB")
    print(f"core_page_faults: {minor} minor, {major} major in {seconds - warm_s:.0f} s (0 wanted)")
    for each in masters:
        each.close()


def main() -> None:
    numbers = [float(word) for word in sys.argv[1:] if word.isdigit()]
    with daemon(config()) as running:
        soak(running, numbers[0] if numbers else 10 if is_quick() else 120)


if __name__ == "__main__":
    main()
