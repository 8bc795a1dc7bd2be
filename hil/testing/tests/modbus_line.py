"""A segment with Modbus nodes and a master at a tap, which asks and reads answers with their times."""

import struct
from collections.abc import Mapping
from typing import Any, NamedTuple

from bridges.modbus.protocol.client_side import Answer, encode, parse_answer
from bridges.modbus.protocol.frame import Frame
from bridges.modbus.protocol.frame import encode as frame
from bridges.modbus.protocol.pdu import Request
from hil.testing import Bench
from hil.vocab.segment import SegmentEvent

M1: dict[str, Any] = {"profile": "mechaduino", "flash": {"table": "identity"}}
DEVICES: Mapping[str, Any] = {"m1": M1, "s1": {"profile": "sac"}}
MASTER = "bus0.master"


class Timed(NamedTuple):
    """A frame on the wire: when its first start bit was, and who sent it."""

    at_ns: int
    who: str
    raw: bytes


def config(devices: Mapping[str, Any] = DEVICES, **segment: Any) -> dict[str, Any]:
    units = {name: at for at, name in enumerate(devices, 1)}
    wire = {"modbus": {"units": units}, "baud": 19200, "format": "8E1", "taps": {"master": {}}} | segment
    return {"bench": "t", "devices": dict(devices), "segments": {"bus0": wire}}


class Line:
    """A bench that has booted, and its wire."""

    def __init__(self, bench: Bench, boot_ms: float = 4000) -> None:
        self.bench = bench
        self.master = bench.tap(MASTER)
        self.wire: list[Timed] = []
        bench.segment("bus0").watchers.append(self._heard)
        bench.run(ms=boot_ms)

    def _heard(self, event: SegmentEvent) -> None:
        self.wire.append(Timed(event.at_ns, event.about, event.data))

    def send(self, raw: bytes, ms: float = 60) -> bytes:
        """Send bytes, and answer what comes within a time."""
        self.master.write(raw)
        self.bench.run(ms=ms)
        return self.master.read()

    def ask(self, unit: int, request: Request, ms: float = 60) -> Answer:
        """Send a request; answers what comes. Raises Refused: an exception."""
        raw = self.send(frame(unit, request.function, encode(request)[1:]), ms)
        assert raw, "no answer"
        assert not Frame(0, raw).fault, raw.hex(" ")
        assert raw[0] == unit
        return parse_answer(request, raw[1:-2])


def f32(value: float) -> tuple[int, int]:
    """Registers of an f32."""
    high, low = struct.unpack(">2H", struct.pack(">f", value))
    return high, low
