"""CANopen drives on a bus of 1 Mbit/s: CPU time, PDOs that are late, lines of slcan, an SDO read.

Each drive has an RPDO of 6 bytes (controlword, target) and a TPDO of 6 bytes (statusword, position), both at
SYNC, in cyclic synchronous position mode. A cycle's RPDOs and its SYNC are played at their own simulated
times.

``can_drives_4`` (1 kHz), ``_16`` (250 Hz), ``_100`` (40 Hz): the daemon's CPU seconds a second in real time,
with PDOs that are missing and how far firmware was behind the wall's time. The reference is one core. Before
each the same in virtual time: TPDOs that are not over when the next SYNC begins. ``can_drives_virtual``: CPU
seconds for a simulated second of 100 drives, at most 0.35; ``can_drives_sync``: of these, what a SYNC costs a
drive until its TPDO waits, at most 30 us. ``can_slcan_rate``: 5000 frames of two bytes a
second from each of two clients to the other, frames that are missing or refused. ``can_sdo_read``: p99 of an
SDO read by a client at the pty, beyond what the bus takes; at most 1.5 ms. ``_fast``: with 4000 wakes of the
core a second.
"""

import json
import os
import select
import struct
import sys
import time
import tty
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from _processes import Daemon, daemon, precise_cpu_s
from _report import check_work, is_quick, report

from bridges.can.bus.bus_events import BusEvent
from bridges.can.frames.can_frame import CanFrame
from bridges.can.frames.frame_length import frame_bits
from bridges.can.frames.slcan import encode
from bridges.can.testing.can_faces import SdoClient
from hil.net.control_client import ask
from hil.sim.inputs import Play
from hil.testing import Bench
from hil.vocab.time import NS_PER_S

BIT_RATE = 1_000_000
SCENARIOS = ((4, 1000), (16, 250), (100, 40))
SECONDS = 2 if is_quick() else 9
LEAD_S = 1.0
"""Time until what is played begins: many rows at once take the daemon time."""
READS = 300 if is_quick() else 3000
RATE_HZ, RATE_S = 5000, 2 if is_quick() else 10
CORE, SDO_LIMIT_S, VIRTUAL_LIMIT, SYNC_LIMIT_US = 1.0, 1.5e-3, 0.35, 30.0
SYNC_FROM_MS, SYNC_TO_MS = 0.01, 0.06
"""Time of a cycle in which its SYNC ends, after 47 bits, and no other frame."""
FRAME_NS = 135_000
"""Longest RPDO with the space behind it, in nanoseconds."""
WAKES_HZ = (1000, 4000)
"""Wakes of the core a second: the default, and what is advised for SDO."""
START_WORDS = (0x80, 0x06, 0x07, 0x0F, 0x0F)
"""Controlwords of the first cycles: a fault's reset, and the way to "operation enabled"."""
LONGEST_S = 5.0
STEP = 40
"""Way of a target in a cycle, in thousandths of a degree."""
UP_S = 4.3


def config(drives: int, rate_hz: int = 1000) -> dict[str, object]:
    device = {"profile": "mechaduino", "port": "tcp", "flash": {"table": "identity"}}
    bus = {
        "bit_rate": BIT_RATE,
        "nodes": {f"m{number}": number for number in range(1, drives + 1)},
        "taps": {"slcan0": {}, "slcan1": {}},
    }
    devices = dict.fromkeys(bus["nodes"], device)  # type: ignore[call-overload]
    return {"bench": "bench", "rate_hz": rate_hz, "devices": devices, "can": {"can0": bus}}


def set_up(sdo: SdoClient, node: int, period_ms: int) -> None:
    """Map a drive's PDOs, and choose its mode."""
    for pdo, cob_id, objects in (
        (0x1400, 0x200 + node, (0x6040_0010, 0x607A_0020)),
        (0x1800, 0x180 + node, (0x6041_0010, 0x6064_0020)),
    ):
        writes = [(pdo, 1, 1 << 31 | cob_id, 4), (pdo, 2, 1, 1), (pdo + 0x200, 0, 0, 1)]
        writes += [(pdo + 0x200, number, mapped, 4) for number, mapped in enumerate(objects, 1)]
        for index, subindex, value, size in [*writes, (pdo + 0x200, 0, 2, 1), (pdo, 1, cob_id, 4)]:
            sdo.download(index, subindex, value.to_bytes(size, "little"))
    for index, subindex, value in ((0x60C2, 1, period_ms), (0x60C2, 2, 0xFD), (0x6060, 0, 8)):
        sdo.download(index, subindex, bytes((value,)))


def cycles(drives: int, rate_hz: int, first: int, count: int) -> Iterator[tuple[int, bytes]]:
    """Lines of slcan for so many cycles from one on, each with its time in nanoseconds: SYNC, and behind it
    the RPDOs for the next, over the whole cycle: TPDOs go before them, and the tap keeps 64 that wait."""
    period_ns = NS_PER_S // rate_hz
    for cycle in range(first, first + count):
        at_ns = (cycle - first) * period_ns
        yield at_ns, encode(CanFrame(0x80))
        word = START_WORDS[min(cycle, len(START_WORDS) - 1)]
        for node in range(1, drives + 1):
            data = struct.pack("<Hi", word, STEP * cycle)
            yield (
                at_ns + 1000 + (node - 1) * (period_ns - FRAME_NS) // drives,
                encode(CanFrame(0x200 + node, data)),
            )


# ---- virtual time ----


class Virtual(NamedTuple):
    """Drives in virtual time: TPDOs, those that are late, CPU seconds for a simulated second, and of those
    microseconds for a SYNC of one drive."""

    count: int
    late: int
    cpu_s: float
    sync_us: float


def virtual(drives: int, rate_hz: int) -> Virtual:
    """Run drives in virtual time."""
    seconds = 1 if is_quick() else 3
    with Bench(config(drives)) as bench:
        canbus = bench.canbus()
        bench.run(UP_S * 1e3)
        for drive in canbus.drives():
            set_up(drive.sdo, drive.node_id, 1000 // rate_hz)
        canbus.send(0, b"\1\0")
        tap = bench.tap("can0.slcan0")
        tap.write(b"S8\rO\r")
        bench.run(1)
        events: list[BusEvent] = []
        canbus.bus.watchers.append(events.append)
        runtime, spent_s, sync_s = bench._runtime, 0.0, 0.0

        def play(piece: int) -> None:
            rows = [(at_ns, line.hex()) for at_ns, line in cycles(drives, rate_hz, piece * rate_hz, rate_hz)]
            runtime.apply_to(runtime.taps["can0.slcan0"], Play(tuple(rows)))

        for piece in range(seconds):
            play(piece)
            spent_s += cpu_s(bench, 1000)
        count, behind = late(events)
        play(seconds)
        for _ in range(rate_hz):
            bench.run(SYNC_FROM_MS)
            sync_s += cpu_s(bench, SYNC_TO_MS - SYNC_FROM_MS)
            bench.run(1000 / rate_hz - SYNC_TO_MS)
        on = sum(bool(bench.axis(drive.axis).snapshot().following) for drive in canbus.drives())
        check_work("drives that follow", on, drives)
    return Virtual(count, behind, spent_s / seconds, sync_s / rate_hz / drives * 1e6)


def cpu_s(bench: Bench, ms: float) -> float:
    """CPU time of so much simulated time."""
    began_s = time.process_time()
    bench.run(ms)
    return time.process_time() - began_s


def late(events: list[BusEvent]) -> tuple[int, int]:
    """TPDOs, and those that were on the bus when a SYNC that was not their own was to begin."""
    count = behind = 0
    open_ids: set[int] = set()
    for event in events:
        can_id = event.frame.id if event.frame else 0
        if can_id == 0x80:
            open_ids.clear()
        elif 0x180 < can_id <= 0x1FF:
            count += 1
            behind += can_id in open_ids
            open_ids.add(can_id)
    return count, behind


# ---- real time ----


class Line:
    """Client at an slcan tap's pty."""

    def __init__(self, path: str) -> None:
        self.fd = os.open(path, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.fd)
        self._got = b""
        for command in (b"C\r", b"S8\r", b"O\r"):
            self.write(command)
            self.until(lambda line: line in (b"\r", b"\a"))

    def write(self, data: bytes) -> None:
        while data:
            data = data[os.write(self.fd, data) :]

    def until(self, wanted: Callable[[bytes], bool], timeout_s: float = 2.0) -> bytes:
        """Next line that is wanted; all others are dropped."""
        deadline_s = time.monotonic() + timeout_s
        while True:
            while end := _end(self._got):
                line, self._got = self._got[:end], self._got[end:]
                if wanted(line):
                    return line
            if not select.select([self.fd], [], [], max(deadline_s - time.monotonic(), 0))[0]:
                raise TimeoutError
            self._got += os.read(self.fd, 4096)

    def sdo(self, node: int) -> SdoClient:
        answer = b"t%03X8" % (0x580 + node)

        def exchange(data: bytes) -> bytes:
            self.write(encode(CanFrame(0x600 + node, data)))
            line = self.until(lambda line: line.startswith(answer))
            return bytes.fromhex(line[5:21].decode())

        return SdoClient(exchange)

    def close(self) -> None:
        os.close(self.fd)


def _end(data: bytes) -> int:
    """Length of the first line of an adapter, 0 if none is whole."""
    ends = [at + 1 for at in (data.find(b"\r"), data.find(b"\a")) if at >= 0]
    return min(ends, default=0)


def wait_s(seconds: float) -> None:
    select.select([], [], [], seconds)


def nodes(control: Path) -> dict[str, dict[str, int]]:
    (row,) = ask(control, "buses")
    counted: dict[str, dict[str, int]] = row["nodes"]
    return counted


def lag_ms(before: list[int], after: list[int], part: float) -> float:
    """Upper bound of a percentile of the firmware's lag, in ms."""
    counts = [new - old for new, old in zip(after, before, strict=True)]
    seen = 0
    for power, count in enumerate(counts):
        seen += count
        if seen >= part * sum(counts):
            return float((1 << power) / 1e6)
    return 0.0


def real_time(drives: int, rate_hz: int) -> None:
    alone = virtual(drives, rate_hz)
    with daemon(json.dumps(config(drives))) as running:
        control = running.folder / "run" / "bench" / "control.sock"
        wait_s(UP_S)
        line = Line(running.port("can0.slcan0"))
        for node in range(1, drives + 1):
            set_up(line.sdo(node), node, 1000 // rate_hz)
        line.write(b"t00020100\r")  # NMT: start all
        wait_s(0.1)
        sent, wanted, cpu, lags = played(running, control, drives, rate_hz)
        line.close()
    print(
        f"{drives} drives at {rate_hz} Hz: {alone.late} of {alone.count} TPDOs late in virtual time",
        flush=True,
    )
    print(f"  real time: {wanted - sent} of {wanted} TPDOs missing, {cpu:.3f} s of CPU a second", flush=True)
    print(f"  lag of firmware: p99 < {lags[0]:.3g} ms, longest < {lags[1]:.3g} ms", flush=True)
    check_work("TPDOs", sent, wanted, 0.01)
    extra = {"late": alone.late, "missing": wanted - sent, "lag_p99_ms": lags[0], "lag_ms": lags[1]}
    report(f"can_drives_{drives}", cpu, "s/s", CORE, 1.0, {"reference": "one core", **extra})
    if drives == SCENARIOS[-1][0]:
        what = {"reference": "0.35 of a core"}
        report("can_drives_virtual", alone.cpu_s, "s/s", VIRTUAL_LIMIT, 1.0, {**what})
        what = {"reference": "30 us for a drive"}
        report("can_drives_sync", alone.sync_us, "us", SYNC_LIMIT_US, 1.0, {**what})


def played(
    running: Daemon, control: Path, drives: int, rate_hz: int
) -> tuple[int, int, float, tuple[float, float]]:
    """TPDOs that were sent (an EMCY counts too), and wanted; CPU seconds a second; lag of the firmware, p99
    and the longest."""

    def tpdos() -> int:
        return sum(each["sent"] for name, each in nodes(control).items() if name.endswith(".canopen"))

    first, wanted, began_s = tpdos(), drives * rate_hz * SECONDS, time.monotonic()
    lead_ns = round(LEAD_S * NS_PER_S)
    rows = [(lead_ns + at_ns, line.hex()) for at_ns, line in cycles(drives, rate_hz, 0, rate_hz * SECONDS)]
    ask(control, "play", tap="can0.slcan0", bursts=rows)
    wait_s(began_s + LEAD_S - time.monotonic())
    cpu, lags, began_s = precise_cpu_s(running.pid), ask(control, "status")["lag"], time.monotonic()
    wait_s(SECONDS)
    while tpdos() - first < wanted and time.monotonic() - began_s < SECONDS + LONGEST_S:
        wait_s(0.02)
    took_s = time.monotonic() - began_s
    spent_s = precise_cpu_s(running.pid) - cpu
    after = ask(control, "status")["lag"]
    both = lag_ms(lags, after, 0.99), lag_ms(lags, after, 1.0)
    return min(tpdos() - first, wanted), wanted, spent_s / took_s, both


def slcan_rate() -> None:
    """Frames from each of two clients to the other, at a steady rate."""
    total = RATE_HZ * RATE_S
    with daemon(json.dumps(config(1))) as running:
        wait_s(1)
        lines = [Line(running.port(f"can0.slcan{at}")) for at in (0, 1)]
        heard, refused, cpu = [0, 0], 0, precise_cpu_s(running.pid)
        sent, began_s = 0, time.monotonic()
        while sum(heard) < 2 * total and time.monotonic() - began_s < RATE_S + 3:
            due = min(int((time.monotonic() - began_s) * RATE_HZ), total)
            if due > sent:
                for at, line in enumerate(lines):
                    frames = (CanFrame(0x100 + at, n.to_bytes(2, "big")) for n in range(sent, due))
                    line.write(b"".join(encode(CanFrame(f.id, f.data[-2:])) for f in frames))
                sent = due
            readable = select.select([line.fd for line in lines], [], [], 0.001)[0]
            for at, line in enumerate(lines):
                if line.fd in readable:
                    data = os.read(line.fd, 65536)
                    heard[at] += data.count(b"t")
                    refused += data.count(b"\a")
        took_s, spent_s = time.monotonic() - began_s, precise_cpu_s(running.pid) - cpu
        for line in lines:
            line.close()
    missing = 2 * total - sum(heard)
    print(f"slcan: {2 * total} frames in {took_s:.2f} s, {missing} missing, {refused} refused", flush=True)
    check_work("frames by slcan", sum(heard), 2 * total, 0.01)
    extra = {"reference": "one core", "missing": missing, "refused": refused, "took_s": took_s}
    report("can_slcan_rate", spent_s / took_s, "s/s", CORE, 1.0, extra)


def sdo_read(wakes_hz: int) -> None:
    request = CanFrame(0x601, bytes.fromhex("4041600000000000"))
    with daemon(json.dumps(config(1, wakes_hz))) as running:
        wait_s(UP_S)
        line = Line(running.port("can0.slcan0"))
        sdo, times_s = line.sdo(1), []
        for _ in range(READS):
            began_s = time.perf_counter()
            value = sdo.upload(0x6041)
            times_s.append(time.perf_counter() - began_s)
            wait_s(0.001)
        line.close()
    answer = CanFrame(0x581, bytes.fromhex("4b416000") + value + bytes(2))
    bus_s = (frame_bits(request) + frame_bits(answer)) / BIT_RATE
    times_s.sort()
    p50_s, p99_s = (times_s[int(part * READS)] - bus_s for part in (0.5, 0.99))
    print(
        f"an SDO read, {wakes_hz} wakes/s: the bus takes {bus_s * 1e3:.3f} ms; beyond p50 {p50_s * 1e3:.3f}",
        flush=True,
    )
    what = {"reference": "1.5 ms", "bus_ms": bus_s * 1e3, "p50_ms": p50_s * 1e3}
    name = "can_sdo_read" if wakes_hz == WAKES_HZ[0] else "can_sdo_read_fast"
    report(name, p99_s * 1e3, "ms", SDO_LIMIT_S * 1e3, 1.0, what)


def main() -> None:
    for drives, rate_hz in SCENARIOS:
        real_time(drives, rate_hz)
    slcan_rate()
    for wakes_hz in WAKES_HZ:
        sdo_read(wakes_hz)


if __name__ == "__main__":
    sys.exit(main())
