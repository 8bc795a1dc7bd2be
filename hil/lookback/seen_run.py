"""Recorded run that keeps the last that passed at its ports and on its wires."""

from collections import defaultdict, deque
from collections.abc import Callable
from dataclasses import asdict
from typing import Any, NamedTuple

from hil.lookback.growing_log import GrowingLog
from hil.recorded.recorded_run import RecordedRun
from hil.sim.inputs import Bytes, InputLogError, Logged
from hil.sim.twin import Twin
from hil.vocab.time import SimTimeNs
from hil.vocab.verbs import VerbRefused

PORT_BYTES = 16 * 1024
"""Maximum of the bytes that are kept of a port: what a terminal shows, and some more."""
PORT_PIECES = 4096
WIRE_EVENTS = 2000
"""Number of events that are kept of a wire."""
MOST_NOTES = 300
"""Maximum number of notes between two reports."""


class Passed(NamedTuple):
    """Bytes at a port: ``to`` is "board" or "client"."""

    at_ns: SimTimeNs
    to: str
    data: bytes


class PortTail:
    """Last bytes at a port, both ways."""

    def __init__(self) -> None:
        self.pieces: deque[Passed] = deque()
        self._bytes = 0

    def add(self, piece: Passed) -> None:
        self.pieces.append(piece)
        self._bytes += len(piece.data)
        while self._bytes > PORT_BYTES or len(self.pieces) > PORT_PIECES:
            self._bytes -= len(self.pieces.popleft().data)


class SeenRun:
    """Run of a log that may grow. A receiver of its inputs, as a log is.

    Raises:
        InputLogError, ConfigError: as ``RecordedRun``.
    """

    def __init__(self, growing: GrowingLog) -> None:
        self.growing = growing
        self.run = RecordedRun(growing.log, on_refused=self._note_refused)
        self.ports: dict[str, PortTail] = defaultdict(PortTail)
        self.wires: dict[str, deque[Any]] = {}
        self.notes: list[dict[str, Any]] = []
        """Refusals and stops that nobody was told of, for a time line."""
        runtime = self.run.runtime
        self.run.listeners.append(self.sent)
        runtime.log = self
        for device in runtime.devices.values():
            for uart in device.uarts:
                self.ports[device.uarts.label(device.name, uart)] = PortTail()
        for name, wire in runtime.wires.items():
            self.wires[name] = deque(maxlen=WIRE_EVENTS)
            wire.watchers.append(self.wires[name].append)
        self._failed = set[str]()

    def run_until(self, until_ns: SimTimeNs, is_wanted: Callable[[], bool] = lambda: True) -> None:
        """Go on to a time, with what has been logged until now. ``is_wanted``: asked now and then.

        Raises:
            InputLogError: the bench cannot take an input of the log.
            NotWanted: nobody waits for it any more.
        """
        self.read_on()
        while self.run.now_ns < until_ns:
            if not is_wanted():
                raise NotWanted
            self.run.run_until(SimTimeNs(min(until_ns, self.run.now_ns + _SLICE_NS)))

    def read_on(self) -> None:
        """Take what was logged since. Raises InputLogError: it is damaged."""
        before = len(self.growing.log.inputs)
        first = self.growing.read_on()
        if first < before:
            raise InputLogError(self.growing.problem)
        self.run.extend(first)

    def write(self, logged: Logged) -> None:
        """Keep what a client sent to a port."""
        given, device = logged.input, self.run.runtime.devices.get(logged.device)
        if device and isinstance(given, Bytes):
            label = device.uarts.label(device.name, given.port or device.uarts.first)
            self.ports[label].add(Passed(logged.at_ns, "board", given.data))

    def sent(self, device: Twin, port: str, at_ns: SimTimeNs, data: bytes) -> None:
        """Keep what a device sent; a listener."""
        if port in device.uarts:
            self.ports[device.uarts.label(device.name, port)].add(Passed(at_ns, "client", data))

    def take_notes(self) -> list[dict[str, Any]]:
        """Notes since the last call."""
        for name, device in self.run.runtime.devices.items():
            if device.failed and name not in self._failed:
                self._failed.add(name)
                self._note("stops", self.run.now_ns, name, f"{name} stopped: {device.failed}")
        notes, self.notes = self.notes, []
        return notes

    def faults(self) -> list[dict[str, Any]]:
        """Faults that are active, as the operation ``faults`` lists them."""
        found = self.run.runtime.faults
        return [
            {"number": number, **asdict(fault), "begin_ns": found.begin_ns[number]}
            for number, fault in found.active.items()
        ]

    def _note_refused(self, index: int, refusal: VerbRefused) -> None:
        logged = self.growing.log.inputs[index]
        self._note("refusals", logged.at_ns, logged.device, str(refusal))

    def _note(self, lane: str, at_ns: SimTimeNs, of: str, text: str) -> None:
        if len(self.notes) < MOST_NOTES:
            self.notes.append({"lane": lane, "at_ns": at_ns, "of": of, "text": text[:200]})


_SLICE_NS = SimTimeNs(5_000_000_000)


class NotWanted(Exception):
    """End of work for which nobody waits any more."""
