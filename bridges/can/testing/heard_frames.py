"""Frames that a test has heard on a CAN bus, in memory or in real time, and waits for them."""

from typing import Any, NamedTuple

from bridges.can.frames.can_frame import CanFrame
from hil.vocab.time import NS_PER_MS, SimTimeNs

PATIENCE_MS = 1000.0
SLICE_MS = 1.0


class HeardFrame(NamedTuple):
    """Frame that was on the bus, and the time at which its last bit ended."""

    at_ns: SimTimeNs
    frame: CanFrame


class HeardFrames:
    """Frames of others on a bus, read by a test. ``bench``: the bench that the bus is of."""

    def __init__(self, bench: Any, name: str) -> None:
        self.bench, self.name = bench, name
        self.heard: list[HeardFrame] = []
        """All frames so far, as far as they were read or waited for in real time."""
        self._read = 0

    def _refresh(self) -> None:
        """Hear what has come, where that is not heard at once."""

    def read(self) -> list[HeardFrame]:
        """Read all frames since the last call."""
        self._refresh()
        fresh, self._read = self.heard[self._read :], len(self.heard)
        return fresh

    def expect(self, can_id: int, data: bytes | None = None, *, within_ms: float = PATIENCE_MS) -> HeardFrame:
        """Let time pass until a frame comes with this identifier, and this data unless None; frames before it
        are read with it. Fails if none comes."""
        end_ns = self.bench.now_ns + round(within_ms * NS_PER_MS)
        while True:
            self._refresh()
            while self._read < len(self.heard):
                heard = self.heard[self._read]
                self._read += 1
                if heard.frame.id == can_id and data in (None, heard.frame.data):
                    return heard
            left_ms = (end_ns - self.bench.now_ns) / NS_PER_MS
            if left_ms <= 0:
                wanted = f"{can_id:03X}#" + ("" if data is None else data.hex().upper())
                last = ", ".join(str(each.frame) for each in self.heard[-5:]) or "nothing"
                raise AssertionError(f"no {wanted} on {self.name} within {within_ms:g} ms; the last: {last}")
            self.bench.run(min(left_ms, SLICE_MS))
