"""Output in real time: what a firmware sends in a group's turn goes on its line, whatever the turn was
for."""

import asyncio
import select
from collections.abc import Callable

import pytest
from session_bench import Bench, MemoryPort

from hil.live.lines import PacedLines
from hil.live.port_link import PortLink
from hil.live.sim_backends import UartBackend
from hil.sim.bench import BenchHooks
from hil.sim.given_fault import fault_refusal
from hil.sim.inputs import Bytes, CommitDone, Do, Pin, Reset, SetField
from hil.vocab.firmware import Board, ByteAvailable, CoreEvent, Delay, Main
from hil.vocab.time import FOREVER
from hil.vocab.verbs import Verb

BAUD = 1_000_000
PATIENCE_S = 90.0


class Clock:
    """Says something after a millisecond, and then takes bytes."""

    def __init__(self, board: Board) -> None:
        self.uart = board.uart

    def main(self) -> Main:
        yield Delay(1_000_000)
        self.uart.write(b"!")
        while True:
            yield ByteAvailable()
            self.uart.read()

    def interrupt(self, event: CoreEvent) -> None:
        return


class RealTime:
    """One device whose firmware is due, or has hung since its start; nobody has called ``service``."""

    def __init__(self, firmware: type[Clock] = Clock, *, hangs: bool = False) -> None:
        self.loop = asyncio.new_event_loop()
        self.lines = PacedLines(self.loop, lambda: self.runtime.now_ns)
        bench = Bench(BenchHooks(turn_over=self.lines.turn_over))
        self.runtime = bench.runtime
        self.device = bench.add("m1", firmware, BAUD)
        self.port = MemoryPort(BAUD)
        self.link = PortLink[UartBackend]("m1", self.port)
        self.link.occupy(UartBackend(self.runtime, self.lines, self.link, self.device))
        self.port.resumed = 0
        self.device.verbs = {"beep": Verb("beep", "", run=lambda firmware: None)}
        load = fault_refusal("shaft_load", "m1", {"torque_Nm": 0.01})
        self.fault = self.runtime.inject(fault_refusal("node_hang", "m1", {}) if hangs else load)
        self.runtime.real_time.start(1_000_000, 1.0, 0, -1)

    def __enter__(self) -> "RealTime":
        return self

    def __exit__(self, *_: object) -> None:
        self.runtime.stop()
        self.loop.close()

    def heard(self) -> bytes:
        """Bytes that a client has once all that is due soon has come."""
        self.loop.run_until_complete(asyncio.sleep(0))
        self.lines.release(FOREVER)
        return bytes(self.port.got)


WAYS: dict[str, Callable[[RealTime], object]] = {
    "bytes": lambda real: real.runtime.apply_to(real.device, Bytes(b"x")),
    "a client's bytes": lambda real: real.link.received(b"x"),
    "a pin": lambda real: real.runtime.apply_to(real.device, Pin("D3", 1)),
    "a field": lambda real: real.runtime.apply_to(real.device, SetField("load_torque_Nm", 0.0)),
    "a reset": lambda real: real.runtime.apply_to(real.device, Reset()),
    "an answer of the store": lambda real: real.runtime.apply_to(real.device, CommitDone(True)),
    "a verb": lambda real: real.runtime.apply_to(real.device, Do("beep", ())),
    "a fault": lambda real: real.runtime.inject(fault_refusal("shaft_load", "m1", {"torque_Nm": 0.01})),
    "a fault's end": lambda real: real.runtime.clear_fault(real.fault),
    "a look": lambda real: real.runtime.snapshot("m1"),
    "the core": lambda real: real.runtime.real_time.service(),
}


@pytest.mark.parametrize("way", WAYS.values(), ids=WAYS)
def test_it_goes_on_whatever_the_turn_was_for(way: Callable[[RealTime], object]) -> None:
    with RealTime() as real:
        assert select.select([real.runtime.core.event_fd], [], [], PATIENCE_S)[0]
        assert real.heard() == b""
        way(real)
        assert real.heard() == b"!"


def test_what_is_sent_at_the_very_start_goes_on() -> None:
    class Hello(Clock):
        def main(self) -> Main:
            self.uart.write(b"hello")
            yield ByteAvailable()

    with RealTime(Hello) as real:
        assert real.heard() == b"hello"


def test_a_port_that_was_held_up_reads_on_when_a_fault_ends() -> None:
    with RealTime(hangs=True) as real:
        while real.link.room():
            real.link.received(bytes(real.link.room()))
        real.heard()
        assert real.port.resumed == 0
        end_ns = real.runtime.now_ns + 10_000_000  # by then all of it has arrived
        while real.runtime.now_ns < end_ns:
            select.select([], [], [], 0.01)
        real.runtime.clear_fault(real.fault)
        real.heard()
        assert real.port.resumed == 1
