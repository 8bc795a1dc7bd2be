"""A bench with firmwares and ports of a test's own."""

from collections.abc import Callable
from typing import Any

from hil.core import Core
from hil.sim.bench import VIRTUAL, BenchHooks, BenchRuntime
from hil.sim.hardware import DeviceSpec
from hil.sim.twin import Twin
from hil.testing.memory_store import MemoryStore
from hil.vocab.axis_plan import AxisPlan
from hil.vocab.firmware import MAIN, Board, ByteAvailable, CoreEvent, Main
from hil.vocab.ports import PortHost, PortStats
from hil.vocab.time import SimTimeNs

PARAMETERS = {
    "inertia_kg_m2": 5.4e-6,
    "viscous_Nm_s_per_rad": 0.004,
    "torque_constant_Nm_per_A": 0.225,
    "sense_resistor_ohm": 0.15,
    "start_deg": 0.0,
    "load_torque_Nm": 0.0,
    "rotor_teeth": 50,
}


class MemoryPort:
    """A port in memory: what the session writes is kept; the client's side is set by the test."""

    address = "memory"

    def __init__(self, baud: int | None = None) -> None:
        self.baud = baud
        self.unread = 0
        self.got = bytearray()
        self.resumed = 0

    async def open(self, host: PortHost) -> None:
        return

    async def close(self) -> None:
        return

    def write(self, data: bytes) -> None:
        self.got += data

    def resume_reading(self) -> None:
        self.resumed += 1

    def backlog(self) -> int:
        return self.unread

    def client_baud(self) -> int | None:
        return self.baud

    def stats(self) -> PortStats:
        return PortStats(1, 1, 0, len(self.got), 0, 0)


class Echo:
    """Sends every byte back."""

    def __init__(self, board: Board) -> None:
        self.uart = board.uart

    def main(self) -> Main:
        while True:
            yield ByteAvailable()
            self.uart.write(bytes([self.uart.read()]))

    def interrupt(self, event: CoreEvent) -> None:
        return


class Bench:
    """Devices with a firmware of the test's own, on the virtual clock; ``heard``: all that they sent."""

    def __init__(self, around: BenchHooks = VIRTUAL) -> None:
        self.runtime = BenchRuntime("test", Core(8), MemoryStore(), around)
        self.heard: list[tuple[str, int, bytes]] = []

    def add(self, name: str, firmware: Callable[[Board], Any], baud: int | None = None) -> Twin:
        group = self.runtime.open_group()
        spec = DeviceSpec(
            name=name, profile="test", firmware=firmware, bauds={MAIN: baud}, nvm={}, power_up={}, facts={}
        )
        device = self.runtime.make(spec, {"axis": AxisPlan(PARAMETERS, law="mechaduino")}, group)
        device.uarts[MAIN].listeners.append(lambda at_ns, data: self.heard.append((name, at_ns, data)))
        self.runtime.add(group, device)
        return device

    def until(self, at_ns: int) -> None:
        self.runtime.advance(SimTimeNs(at_ns))
