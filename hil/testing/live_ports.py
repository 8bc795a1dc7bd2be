"""Ports and taps of a bench that is served, as tests of any kind of bench use them."""

import time
from collections.abc import Callable

from hil.testing.faces import PortFace, TapFace
from hil.testing.given import checked_bytes
from hil.testing.live_desk import LiveDesk
from hil.testing.live_traffic import LiveTraffic
from hil.testing.unsupported import RealTimeFace, UnsupportedHere
from hil.vocab.time import SimTimeNs
from hil.vocab.verbs import VerbRefused
from hil.wire.pcapng import RecordKind

MOST_BYTES = 2048
"""Number of bytes that are typed by one request."""
_AGAIN_S = 0.005


class Hearing:
    """Reading of what has come from one source. ``traffic``: answers the records that it is among."""

    def __init__(self, name: str, traffic: Callable[[], LiveTraffic]) -> None:
        self._name, self._traffic, self._since = name, traffic, 0

    def read_timed(self) -> list[tuple[SimTimeNs, bytes]]:
        """Read all that has come since the last call, with times."""
        fresh, self._since = self._traffic().of(self._name, self._since, RecordKind.RX)
        return [(SimTimeNs(each.at_ns), each.data) for each in fresh]


class LivePort(str, RealTimeFace):
    """Port of a device, which a test types at beside the programs that have it open, and of which it reads
    all that has come since the boards answered, or since the first read if the bench has no capture.

    It is its own path or URL, too, for programs and for pyserial: benches that are served have always
    answered that.
    """

    def __new__(cls, address: str, name: str, desk: LiveDesk, hearing: Hearing) -> "LivePort":
        made = super().__new__(cls, address)
        made._name, made._desk, made._hearing = name, desk, hearing
        return made

    _name: str
    _desk: LiveDesk
    _hearing: Hearing

    @property
    def kind(self) -> str:  # type: ignore[override]
        return self._desk.kind

    def _virtual(self) -> tuple[type, frozenset[str]]:
        return PortFace, frozenset({"timeline"})

    def write(self, data: bytes, client_baud: int | None = None) -> None:
        """Type bytes at the device, from now on as fast as it takes them."""
        __tracebackhide__ = True
        data = checked_bytes(data)
        if client_baud:
            raise UnsupportedHere(self.kind, "client_baud: open the port with b.serial and that speed")
        for begin in range(0, len(data), MOST_BYTES):
            self._type(data[begin : begin + MOST_BYTES])

    def _type(self, piece: bytes) -> None:
        while True:
            try:
                self._desk.do("send", self._name, device=self._name, data=piece.hex())
                return
            except VerbRefused as error:
                if error.code != "not_now" or self._name in self._desk.real:
                    raise
            time.sleep(_AGAIN_S)  # the board has not taken yet what was typed before

    def read(self) -> bytes:
        """Read everything that has come since the last call."""
        return b"".join(data for _, data in self.read_timed())

    def read_timed(self) -> list[tuple[SimTimeNs, bytes]]:
        """Read as ``read``, with the time at which each piece reached the port: late by the daemon's own
        delay, some 0.1 ms on a computer that is not busy."""
        return self._hearing.read_timed()


class LiveTap(RealTimeFace):
    """Tap on a segment or a bus. It is heard from when the test has first named it."""

    def __init__(self, name: str, desk: LiveDesk, hearing: Hearing) -> None:
        self._name, self._desk, self._hearing = name, desk, hearing

    @property
    def kind(self) -> str:  # type: ignore[override]
        return self._desk.kind

    def _virtual(self) -> tuple[type, frozenset[str]]:
        return TapFace, frozenset()

    def write(self, data: bytes) -> None:
        """Send bytes on the wire, or when what was written before has gone out."""
        __tracebackhide__ = True
        self._desk.do("play", self._name, tap=self._name, bursts=[[0, checked_bytes(data).hex()]])

    def read(self) -> bytes:
        """Read what was complete on the wire since the last call."""
        return b"".join(data for _, data in self._hearing.read_timed())
