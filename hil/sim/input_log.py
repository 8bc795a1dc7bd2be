"""The input log of a run: enough to run it again, exactly, on the virtual clock.

A text file of JSON lines. The first is the header: format, version, the program's version, the wall's date of
time 0, the speed, the configuration, and each device's memory at the start. The others are inputs
(``inputs.encode_line``), and, for comparison, what devices sent: ``at_ns``, ``device``, ``sent`` (hexadecimal
digits), ``state`` (CRC-32 of the axes' snapshots at that time; null for what an interrupt sent, and where it
was not kept). ``port`` is in lines of another UART than the first.
``device`` of an input is the address of what it is for: a device, an axis of one with several, a tap, a
segment. Reloads and events (``noted_events``) have lines of
their own. Once a second come a checksum of all that stands before and some totals (``log_checks``). The last
line says why the log ends: one without it was cut. ``log_reading`` reads it.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

from hil.core import Snapshot
from hil.sim.inputs import LOG_FORMAT, LOG_VERSION, Logged, encode_line, quoted
from hil.sim.log_checks import STOPPED, LineSink, LogChecks
from hil.sim.noted_events import NotedEvent, encode_event
from hil.sim.reloads import Memories, Reloaded, encode_reload, memories_text
from hil.sim.state_checksum import StateChecksums, state_checksum
from hil.sim.twin import Twin
from hil.vocab.time import SimTimeNs


@dataclass(frozen=True)
class Sent:
    """Bytes that a device sent, and a checksum of its axes' state at that time. ``port``: name of the
    UART; empty: the first."""

    at_ns: SimTimeNs
    device: str
    data: bytes
    state: int | None
    port: str = ""


def sent_now(device: Twin, port: str, at_ns: SimTimeNs, data: bytes) -> Sent:
    """Record what a device sends now."""
    snapshots = _snapshots(device)
    state = None if snapshots is None else state_checksum(snapshots)
    return Sent(at_ns, device.name, data, state, logged_port(device, port))


def _snapshots(device: Twin) -> list[Snapshot] | None:
    """State of a device that sends. Bytes that an interrupt sent have none: it is noticed later than it
    happened, at a time that depends on the machine's load."""
    return None if device.interrupting else [axis.glance() for axis in device.axes.values()]


def logged_port(device: Twin, port: str) -> str:
    """Name of a UART in the log: empty, it is the first."""
    return "" if port == device.uarts.first else port


@dataclass(frozen=True)
class InputLog:
    """Input log as read back."""

    config: dict[str, Any]
    memories: dict[str, dict[str, bytes]]
    inputs: list[Logged]
    sent: Sequence[Sent]
    cut: str = ""
    """Reason why answers to the last inputs may be missing, for people; empty: the log is whole."""
    name: str = ""
    """Name of the log's file."""
    lines: Sequence[int] = field(default_factory=list)
    """Line numbers of the inputs, counted from 1."""
    program: str = "another program"
    """Program that wrote it."""
    unpacked: object = None
    """Folder of what it came with, which goes with it."""
    version: int = LOG_VERSION
    begun: str | None = None
    """Wall's date of time 0, as in 2026-11-29T00:09:16.123456Z; None: it had none, or was not kept."""
    speed: float = 1.0
    end_ns: int = 0
    """Time up to which the log describes the run."""
    why: str = ""
    """Reason in its end line (``log_checks.ENDS``); empty: it has none."""
    reloads: Sequence["ReloadPlace"] = ()
    events: Sequence[NotedEvent] = ()
    """Events of the bench; one that others joined is there again."""
    ports: dict[str, str] = field(default_factory=dict)
    """Kinds of the bench's ports by their labels, where they were kept."""
    forked_from: str = ""
    """Recording that the run went on from, and when, for people; empty: it is no fork."""
    damage: str = ""
    """Place and reason of what cannot be read, for people; all from there on is left out."""

    def where(self, index: int) -> str:
        return place(self.name, self.lines[index])


SentRecord = tuple[SimTimeNs, str, bytes, str, list[Snapshot] | None]
"""Record of what a device sent: time, device, bytes, port (empty: the first), state."""
LogRecord = Logged | Reloaded | NotedEvent | SentRecord


class ReloadPlace(NamedTuple):
    """Reload in a log, and how many inputs and pieces that were sent stand before it."""

    reload: Reloaded
    inputs: int
    sent: int


class InputLogSink(Protocol):
    """Receiver of all inputs of a bench with their effective times, and of all that its devices send."""

    def write(self, logged: Logged) -> None:
        """Receive an input."""

    def sent(self, device: Twin, port: str, at_ns: SimTimeNs, data: bytes) -> None:
        """Receive what a device sends; a bench's listener."""


NOTHING_MORE: Mapping[str, object] = {}


class InputLogWriter:
    """Writer of an input log to an open text file, which the caller flushes and closes.

    ``later``: called with each record that begins to wait for ``write_waiting``, which has to be called
    soon, for what waits, the header too, is not in the file; None: nothing waits. What a client waits for is
    then not held up by texts. ``clock``: the bench's time and the wall's date; None: the time is that of the
    last record, and there is no date. ``about``: more keys of the header: ``ports``, ``forked_from``."""

    def __init__(
        self,
        file: LineSink,
        program: str,
        config: Mapping[str, object],
        memories: Memories,
        later: Callable[[int], object] | None = None,
        clock: Callable[[], tuple[int, str]] | None = None,
        about: Mapping[str, object] = NOTHING_MORE,
    ) -> None:
        self._waiting: list[LogRecord] = []
        self._checksums = StateChecksums()
        self._later = later or (lambda waiting: self.write_waiting())
        speed = config.get("speed", 1.0)
        self._header: dict[str, object] = {
            "format": LOG_FORMAT,
            "version": LOG_VERSION,
            "program": program,
            "begun": None,
            "speed": speed,
            "config": config,
            "nvm": memories_text(memories),
            **about,
        }
        self.checks = LogChecks(file, clock)
        self._is_over = False
        if later is None:
            self.begin()

    def begin(self, begun: str | None = None) -> None:
        """Write the header, if it is not written; ``begun``: the wall's date of time 0."""
        if self._header:
            header, self._header = self._header | {"begun": begun}, {}
            self.checks.write_line(json.dumps(header, separators=(",", ":")) + "\n")

    def write(self, logged: Logged) -> None:
        self.add(logged)

    def sent(self, device: Twin, port: str, at_ns: SimTimeNs, data: bytes) -> None:
        """Write down what a device sent; a bench's listener."""
        if not self._is_over:
            self.add((at_ns, device.name, data, logged_port(device, port), _snapshots(device)))

    def add(self, record: LogRecord) -> None:
        """Write down a record."""
        if not self._is_over:
            self._waiting.append(record)
            self._later(len(self._waiting))

    def write_waiting(self, at_most: int | None = None) -> int:
        """Write the first ``at_most`` records that wait, or all; answers how many wait still."""
        self.begin()
        records, self._waiting[:at_most] = self._waiting[:at_most], []
        add = self.checks.add
        for record in records:
            if isinstance(record, Logged):
                add(record.at_ns, encode_line(record) + "\n", record)
            elif isinstance(record, Reloaded):
                add(record.at_ns, encode_reload(record) + "\n", None)
            elif isinstance(record, NotedEvent):
                add(record.at_ns, encode_event(record) + "\n", None)
            else:
                add(record[0], self._sent_line(record), None)
        self.checks.hand_on()
        return len(self._waiting)

    def _sent_line(self, record: SentRecord) -> str:
        at_ns, device, data, port, snapshots = record
        state = "null" if snapshots is None else self._checksums.of(device, snapshots)
        on = f',"port":{quoted(port)}' if port else ""
        return f'{{"at_ns":{at_ns},"device":{quoted(device)},"sent":"{data.hex()}","state":{state}{on}}}\n'

    def end(self, why: str = STOPPED) -> None:
        """Write down that the log ends here, why, and that nothing is missing. What comes later is
        dropped."""
        self.write_waiting()
        self.checks.end(why)
        self.drop()

    def drop(self) -> None:
        """Drop what waits, and all that comes."""
        self._is_over = True
        self._waiting.clear()


def place(name: str, line: int) -> str:
    """Format a line of a log, for people."""
    return f"{name}:{line}" if name else f"line {line}"
