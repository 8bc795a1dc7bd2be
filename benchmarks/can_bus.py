"""CAN: frames a second on the bus beside python-can's virtual one, core for a full bus, lines of slcan.

``can_virtual_pair``: time to send a frame and have it received, with arbitration, stuff bits and times of
each; beside python-can's ``virtual`` bus (extra dev), which has none of these, in turns. Ours makes a frame
each time, theirs sends one message again and again. At most twice as much is wanted.

``can_full_bus_*``: CPU time of a second at 1 Mbit/s, frames of 8 bytes one behind the other, of many nodes,
each of which wants one identifier; ``noise`` with a bit error in ten thousand bits, ``lonely`` with nobody
who acknowledges. The reference is one core.

``slcan_*``: time of the adapter for a line of a client, and for one to it, beside python-can's client for the
same lines over a pty, which has to read them byte by byte.
"""

import os
import statistics
import threading
import time
import tty
from collections.abc import Callable
from heapq import heappop, heappush
from typing import Any

from _report import is_quick, report

from bridges.can.bus.bus_events import CanFilter, NodeState
from bridges.can.bus.can_bus import CanBus
from bridges.can.bus.can_faults import CanFaults
from bridges.can.frames.can_frame import CanFrame
from bridges.can.frames.slcan import SlcanAdapter, SlcanStatus, encode
from hil.vocab.faults import Fault
from hil.vocab.time import SimTimeNs

FRAMES = 2_000 if is_quick() else 20_000
RUNS = 3 if is_quick() else 11
BIT_RATE = 1_000_000
DATA = bytes(range(8))

Work = Callable[[], float]
"""Work that answers its time for a frame, in seconds."""


class Timeline:
    """Simulated time, as a group has it."""

    def __init__(self) -> None:
        self.now_ns = SimTimeNs(0)
        self._calls: list[tuple[int, int, Callable[[SimTimeNs], None]]] = []
        self._count = 0

    def at(self, at_ns: int, call: Callable[[SimTimeNs], None]) -> None:
        self._count += 1
        heappush(self._calls, (at_ns, self._count, call))

    def run(self, until_ns: int) -> None:
        calls = self._calls
        while calls and calls[0][0] <= until_ns:
            at_ns, _, call = heappop(calls)
            self.now_ns = SimTimeNs(at_ns)
            call(self.now_ns)
        self.now_ns = SimTimeNs(max(self.now_ns, until_ns))


class Ear:
    def __init__(self) -> None:
        self.heard = 0
        self.again: Callable[[], None] = lambda: None

    def hear(self, frame: CanFrame, start_ns: SimTimeNs, end_ns: SimTimeNs) -> None:
        self.heard += 1

    def sent(self, frame: CanFrame, start_ns: SimTimeNs, end_ns: SimTimeNs) -> None:
        self.again()

    def changed(self, state: NodeState, at_ns: SimTimeNs) -> None:
        pass


def ours() -> float:
    clock, ear = Timeline(), Ear()
    bus = CanBus(clock, BIT_RATE)
    bus.join("a", Ear())
    bus.join("b", ear)
    clock.run(1_000_000)
    began = time.perf_counter()
    for number in range(FRAMES):
        bus.send("a", CanFrame(number & 0x7FF, DATA))
        clock.run(clock.now_ns + 150_000)
    took = time.perf_counter() - began
    assert ear.heard == FRAMES
    return took / FRAMES


def theirs() -> float:
    import can

    with can.Bus("bench", interface="virtual") as a, can.Bus("bench", interface="virtual") as b:
        message = can.Message(arbitration_id=0x123, data=DATA, is_extended_id=False)
        began = time.perf_counter()
        for _ in range(FRAMES):
            a.send(message)
            assert b.recv(0)
        return (time.perf_counter() - began) / FRAMES


def full_bus(count: int, *, noise: float = 0.0) -> float:
    """CPU seconds for a second of a bus on which everybody has something to send at any time."""
    clock = Timeline()
    bus = CanBus(clock, BIT_RATE)
    for index in range(count):
        ear = Ear()
        name, frame = f"n{index}", CanFrame(0x100 + index, DATA)
        bus.join(name, ear, filters=[CanFilter(0x100 + (index + 1) % count, 0x7FF)])
        ear.again = lambda name=name, frame=frame: bus.send(name, frame)  # type: ignore[misc]
        bus.send(name, frame)
    if noise:
        CanFaults(bus).inject(1, Fault("wire_noise", "can0", {"rate": noise, "seed": 1}))
    seconds = 0.2 if is_quick() else 1.0
    began = time.process_time()
    clock.run(round(seconds * 1e9))
    took = (time.process_time() - began) / seconds
    assert bus.counters(clock.now_ns)["load_percent"] > 90
    return took


class Channel:
    def open(self, bit_rate: int, *, is_listening: bool) -> bool:
        return True

    def close(self) -> None:
        pass

    def send(self, frame: CanFrame) -> bool:
        return True

    def status(self) -> SlcanStatus:
        return SlcanStatus(0)


def opened() -> SlcanAdapter:
    adapter = SlcanAdapter(Channel())
    adapter.feed(b"S8\rO\r")
    return adapter


def lines_in() -> float:
    adapter, line = opened(), encode(CanFrame(0x123, b"\1\2"))
    began = time.perf_counter()
    for _ in range(FRAMES):
        assert adapter.feed(line) == b"z\r"
    return (time.perf_counter() - began) / FRAMES


def lines_out() -> float:
    adapter, frame = opened(), CanFrame(0x123, b"\1\2")
    began = time.perf_counter()
    for at_ns in range(FRAMES):
        assert adapter.received(frame, at_ns)
    return (time.perf_counter() - began) / FRAMES


def _client(run: Callable[[Any, int], None]) -> float:
    """Time of python-can's client for a frame, at a pty."""
    import can

    main, side = os.openpty()
    tty.setraw(side)
    with can.Bus(interface="slcan", channel=os.ttyname(side), sleep_after_open=0) as client:
        began = time.perf_counter()
        run(client, main)
        took = time.perf_counter() - began
    os.close(main)
    os.close(side)
    return took / FRAMES


def their_lines_in() -> float:
    import can

    def run(client: Any, main: int) -> None:
        drain = threading.Thread(target=_drain, args=(main,), daemon=True)
        drain.start()
        for _ in range(FRAMES):
            client.send(can.Message(arbitration_id=0x123, data=b"\1\2", is_extended_id=False))

    return _client(run)


def _drain(main: int) -> None:
    try:
        while os.read(main, 65536):
            pass
    except OSError:
        pass


def their_lines_out() -> float:
    adapter, frame = opened(), CanFrame(0x123, b"\1\2")

    def run(client: Any, main: int) -> None:
        os.read(main, 100)  # the client's greeting
        for _ in range(FRAMES):
            os.write(main, adapter.received(frame, 0))
            assert client.recv(1)

    return _client(run)


def medians(works: tuple[Work | None, ...]) -> list[float]:
    """Median of each, in turns; 0 for what is not there."""
    found: list[list[float]] = [[] for _ in works]
    for _ in range(RUNS):
        for work, times in zip(works, found, strict=True):
            if work:
                times.append(work())
    return [statistics.median(times) if times else 0.0 for times in found]


def has_python_can() -> bool:
    try:
        import can
    except ImportError:
        return False
    return bool(can)


def main() -> None:
    is_there = has_python_can()
    pairs: dict[str, tuple[Work, Work, float | None]] = {
        "can_virtual_pair": (ours, theirs, 2),
        "slcan_line_in": (lines_in, their_lines_in, 1),
        "slcan_line_out": (lines_out, their_lines_out, 1),
    }
    for name, (mine, other, limit) in pairs.items():
        value, reference = medians((mine, other if is_there else None))
        about = {"reference": "python-can, or 0 without it"}
        report(name, value * 1e6, "us", reference * 1e6, limit if is_there else None, about)
        print(f"  {1 / value:,.0f} a second" + (f", python-can {1 / reference:,.0f}" if reference else ""))
    full: dict[str, Work] = {
        "can_full_bus_2": lambda: full_bus(2),
        "can_full_bus_100": lambda: full_bus(100),
        "can_full_bus_100_noise": lambda: full_bus(100, noise=1e-4),
        "can_full_bus_lonely": lambda: full_bus(1),
    }
    for name, work in full.items():
        report(name, medians((work,))[0], "s/s", 1, 0.5, {"reference": "one core"})


main()
