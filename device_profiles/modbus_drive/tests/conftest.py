"""A drive on an RS485 line, and a master that speaks to it, in simulated time."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import pytest

from bridges.modbus.protocol.client_side import Answer, encode, parse_answer, read, write
from bridges.modbus.protocol.frame import encode as frame
from bridges.modbus.protocol.pdu import Refused, Request, Table
from hil.testing import Bench

INPUT, HOLDING = Table.INPUT_REGISTERS, Table.HOLDING_REGISTERS
UNIT = 1


class Master:
    """Master with one drive, m1. Registers are those of the built-in map, unless ``map`` says others."""

    def __init__(self, device: dict[str, Any], bench: dict[str, Any]) -> None:
        segment = {
            "baud": 115200,
            "modbus": {"units": {"m1": UNIT}, "response_ms": 0},
            "taps": {"plc": {"port": "memory"}},
        }
        device = {"profile": "modbus_drive", **device}
        self.bench = Bench({"bench": "t", "devices": {"m1": device}, "segments": {"bus": segment}, **bench})
        self.drive = self.bench.device("m1")
        self.axis = self.bench.axis("m1")

    def ask(self, request: Request) -> Any:
        """Send a request; answers what was read, or the number of an exception."""
        try:
            return self.raw(request).values
        except Refused as error:
            return int(error.code)

    def raw(self, request: Request) -> Answer:
        """Send a request; answers all that comes. Raises Refused: an exception."""
        tap = self.bench.tap("bus.plc")
        tap.read()
        pdu = encode(request)
        tap.write(frame(UNIT, pdu[0], pdu[1:]))
        self.bench.run(ms=25)
        return parse_answer(request, tap.read()[1:-2])

    def run(self, ms: float) -> None:
        self.bench.run(ms=ms)

    def told(self, address: int, count: int = 1) -> tuple[int, ...]:
        """Input registers."""
        values: tuple[int, ...] = self.ask(read(INPUT, address, count))
        return values

    def kept(self, address: int, count: int = 1) -> tuple[int, ...]:
        """Holding registers."""
        values: tuple[int, ...] = self.ask(read(HOLDING, address, count))
        return values

    def put(self, address: int, *words: int) -> Any:
        """Write holding registers; answers (), or the number of an exception."""
        return self.ask(write(HOLDING, address, words))

    def target(self, position_deg: float, *, control: Sequence[int] = ()) -> Any:
        """Write the set-point, and what comes behind it up to the control word."""
        number = round(position_deg * 100) & 0xFFFF_FFFF
        return self.put(0, number >> 16, number & 0xFFFF, *control)

    @property
    def position_deg(self) -> float:
        """Position that the registers tell."""
        high, low = self.told(0, 2)
        number = high << 16 | low
        return (number - (number >> 31 << 32)) / 100

    @property
    def status(self) -> set[str]:
        """Bits of the status word."""
        (word,) = self.told(4)
        return {name for bit, name in enumerate(("enabled", "moving", "fault")) if word >> bit & 1}


@pytest.fixture
def master() -> Iterator[Callable[..., Master]]:
    """Maker of masters, each with a bench of its own, at which the drive is ready."""
    made: list[Master] = []

    def make(device: dict[str, Any] | None = None, **bench: Any) -> Master:
        one = Master(device or {}, bench)
        one.run(250)
        made.append(one)
        return one

    yield make
    for each in made:
        each.bench.close()
