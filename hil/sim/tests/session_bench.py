"""A bench with firmwares and ports of a test's own."""

from collections.abc import Callable, Mapping
from typing import Any

from hil.core import Core
from hil.sim.bench import BenchRuntime
from hil.sim.device import Device
from hil.vocab.axis_plan import AxisPlan
from hil.vocab.firmware import Board, ByteAvailable, CoreEvent, Main
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


class NoStore:
    def commit(self, device: Device, sections: Mapping[str, bytes]) -> None:
        device.commit_done(True)


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

    def __init__(self) -> None:
        self.runtime = BenchRuntime("test", Core(8))
        self.heard: list[tuple[str, int, bytes]] = []
        self.runtime.listeners.append(
            lambda device, port, at_ns, data: self.heard.append((device.name, at_ns, data))
        )

    def add(self, name: str, firmware: Callable[[Board], Any], baud: int | None = None) -> Device:
        group, axis = self.runtime.open_group(AxisPlan(PARAMETERS))
        device = Device(
            name,
            "test",
            axis,
            firmware,
            baud=baud,
            network_baud=None,
            nvm={},
            power_up={},
            facts={},
            store=NoStore(),
            sent=self.runtime.sent,
        )  # fmt: skip
        self.runtime.add(group, device)
        return device

    def until(self, at_ns: int) -> None:
        self.runtime.advance(SimTimeNs(at_ns))
