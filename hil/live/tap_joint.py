"""Joins one port to one tap, as ``session`` joins a port to a device."""

from hil.live.joint import BACKLOG_HOLD_BYTES, Lines
from hil.sim.bench import BenchRuntime
from hil.sim.inputs import Bytes
from hil.sim.station import Tap
from hil.vocab.ports import Port
from hil.vocab.ports import Tap as Listener
from hil.vocab.time import SimTimeNs


class TapSession:
    """The port's host."""

    def __init__(self, bench: BenchRuntime, tap: Tap, port: Port, lines: Lines) -> None:
        self.tap = tap
        self.port = port
        self.port_failure: str | None = None
        self.taps: list[Listener] = []
        self._bench = bench
        self._lines = lines
        self._held = False
        self._is_fresh = False
        tap.listeners.append(self._has_heard)

    def received(self, data: bytes) -> None:
        for listener in self.taps:
            listener("board", data)
        self._bench.give(self.tap, Bytes(data, self.port.client_baud()))

    def room(self) -> int:
        is_full = self.port.backlog() > BACKLOG_HOLD_BYTES
        room = 0 if is_full else self.tap.room(self._bench.now_ns)
        if room == 0 and not self._held:
            self._held = True
            self._lines.schedule(self)
        self._held = room == 0
        self._lines.hold(self, self._held)
        return room

    def drained(self) -> None:
        self.refresh()

    def client_left(self, baud: int | None) -> None:
        """The tap stays on the wire."""

    def port_failed(self, reason: str) -> None:
        self.port_failure = reason

    def refresh(self) -> None:
        if self._held and self.room():
            self.port.resume_reading()

    def _has_heard(self) -> None:
        if not self._is_fresh:
            self._is_fresh = True
            self._lines.fresh.append(self)

    def flush(self) -> None:
        """What was heard has its times already."""
        self._is_fresh = False

    def release(self, now_ns: SimTimeNs) -> SimTimeNs:
        due_ns = self.tap.next_ns
        if due_ns <= now_ns and (data := self.tap.take(min(now_ns, self._bench.known_ns(self.tap.name)))):
            for listener in self.taps:
                listener("client", data)
            self.port.write(data)
        if not self._held:
            return self.tap.next_ns
        if self.tap.room_ns <= now_ns:
            self.refresh()
        return self.tap.next_ns if not self._held else min(self.tap.next_ns, self.tap.room_ns)
