"""Edges of a board's outputs, kept from the bench's start."""

from functools import partial

from hil.core import CoreMotion
from hil.sim.bench import BenchRuntime
from hil.sim.device import Device
from hil.sim.uart import DeviceUart
from hil.vocab.axis_plan import OUTPUTS
from hil.vocab.firmware import NETWORK
from hil.vocab.time import SimTimeNs
from hil.wire.serial_line import character_ns

TX_ENABLE = "TxEn"
"""The output that switches a board's RS485 driver on, high while any of its ports sends; boards with two
serial interfaces have it."""


class Outputs:
    """Of one device."""

    def __init__(self, runtime: BenchRuntime, device: Device) -> None:
        self._runtime = runtime
        self._motion = device.axis if isinstance(device.axis, CoreMotion) else None
        self._edges: list[tuple[SimTimeNs, str, int]] = []
        self._busy: list[tuple[SimTimeNs, SimTimeNs]] = []
        self.names = [*OUTPUTS] if self._motion else []
        if self._motion:
            self._motion.record_edges(True)
        if NETWORK in device.uarts:
            self.names.append(TX_ENABLE)
            for uart in device.uarts.values():
                uart.listeners.append(partial(self._sends, uart))

    def edges(self, output: str) -> list[tuple[SimTimeNs, int]]:
        """All so far: (simulated time, level)."""
        if output == TX_ENABLE:
            return self._transmissions()
        if self._motion:
            self._edges += [(SimTimeNs(at), name, level) for at, name, level in self._motion.take_edges()]
        return [(at_ns, level) for at_ns, name, level in self._edges if name == output]

    def _transmissions(self) -> list[tuple[SimTimeNs, int]]:
        edges: list[tuple[SimTimeNs, int]] = []
        for start_ns, end_ns in sorted(self._busy):
            if edges and start_ns <= edges[-1][0]:
                edges[-1] = (max(end_ns, edges[-1][0]), 0)
            else:
                edges += [(start_ns, 1), (end_ns, 0)]
        return [edge for edge in edges if edge[0] <= self._runtime.now_ns]

    def _sends(self, uart: DeviceUart, at_ns: SimTimeNs, data: bytes) -> None:
        if uart.baud:
            self._busy.append((at_ns, SimTimeNs(at_ns + character_ns(len(data), uart.baud))))
