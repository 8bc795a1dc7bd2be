"""CAN bus of a bench that is served, with a node of the test's own on it."""

from typing import TYPE_CHECKING

from bridges.can.frames.can_frame import CanFrame
from bridges.can.frames.socketcan import unpack
from bridges.can.testing.can_faces import TESTER, CanBusFace
from bridges.can.testing.heard_frames import HeardFrame, HeardFrames
from hil.testing.given import checked_bytes
from hil.testing.unsupported import RealTimeFace
from hil.vocab.time import SimTimeNs

if TYPE_CHECKING:
    from hil.testing.served_bench import ServedBench


class ServedCanBus(HeardFrames, RealTimeFace):
    """A bus, with a node of the test's own on it, ``can0.tester``, that hears all frames of others."""

    def __init__(self, bench: "ServedBench", name: str) -> None:
        __tracebackhide__ = True
        super().__init__(bench, name)
        self._desk = bench.desk
        self._node: str = self._desk.do("attach", name, bus=name, node=TESTER)["node"]
        self._traffic = bench.hear(name)
        self._since = 0

    @property
    def kind(self) -> str:  # type: ignore[override]
        return self._desk.kind

    def _virtual(self) -> tuple[type, frozenset[str]]:
        return CanBusFace, frozenset({"bus"})

    def send(self, can_id: int, data: bytes = b"", *, is_extended: bool = False) -> None:
        """Send a frame now."""
        __tracebackhide__ = True
        self.send_frame(CanFrame(can_id, checked_bytes(data), is_extended))

    def send_frame(self, frame: CanFrame) -> None:
        """Send as ``send``, any frame."""
        __tracebackhide__ = True
        answer = self._desk.do("transmit", self._node, channel=self._node, frames=[str(frame)])
        if answer["refused"]:
            raise RuntimeError(f"{self._node}: too many frames wait already")

    def _refresh(self) -> None:
        fresh, self._since = self._traffic.of(self.name, self._since, 0)
        for each in fresh:
            frame = unpack(each.data)
            if isinstance(frame, CanFrame) and each.comment != self._node:
                self.heard.append(HeardFrame(SimTimeNs(each.at_ns), frame))
