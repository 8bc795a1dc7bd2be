"""The input log of a run: enough to run it again, exactly, on the virtual clock.

A text file of JSON lines. The first is the header: format, version, the program's version, the configuration,
and each device's memory at the start. The others are inputs (``inputs.encode_line``), and, for comparison,
what devices sent: ``at_ns``, ``device``, ``sent`` (hexadecimal digits), ``state`` (CRC-32 of the axes'
snapshots at that time; null for what an interrupt sent, and where it was not kept). ``port`` is in lines of
another UART than the first.
``device`` of an input is the address of what it is for: a device, an axis of one with several, a tap, a
segment. The last line is ``{"end":true}``: a log without it was cut.
"""

import base64
import json
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

from hil.core import Snapshot
from hil.sim.input_reading import decode, hexadecimal, read_line, taken, text, time_ns, whole
from hil.sim.inputs import LOG_FORMAT, LOG_VERSION, OLD_VERSIONS, InputLogError, Logged, encode_line, quoted
from hil.sim.state_checksum import StateChecksums, state_checksum
from hil.sim.twin import Twin
from hil.vocab.time import SimTimeNs

Memories = Mapping[str, Mapping[str, bytes]]
"""Non-volatile sections of each device, by name."""


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
    sent: list[Sent]
    cut: str = ""
    """Reason why answers to the last inputs may be missing, for people; empty: the log is whole."""
    name: str = ""
    """Name of the log's file."""
    lines: list[int] = field(default_factory=list)
    """Line numbers of the inputs, counted from 1."""
    program: str = "another program"
    """Program that wrote it."""
    version: int = LOG_VERSION

    def where(self, index: int) -> str:
        return place(self.name, self.lines[index])


class LineSink(Protocol):
    """Destination of lines."""

    def write(self, text: str, /) -> object:
        """Append a text to the destination."""


LogRecord = Logged | tuple[SimTimeNs, str, bytes, str, list[Snapshot] | None]
"""Input, or what a device sent: time, device, bytes, port (empty: the first), state."""


class InputLogSink(Protocol):
    """Receiver of all inputs of a bench with their effective times, and of all that its devices send."""

    def write(self, logged: Logged) -> None:
        """Receive an input."""

    def sent(self, device: Twin, port: str, at_ns: SimTimeNs, data: bytes) -> None:
        """Receive what a device sends; a bench's listener."""


class InputLogWriter:
    """Writer of an input log to an open text file, which the caller flushes and closes.

    ``later``: called with each record that begins to wait for ``write_waiting``, which has to be called
    soon, for what waits is not in the file; None: nothing waits. What a client waits for is then not held up
    by texts."""

    def __init__(
        self,
        file: LineSink,
        program: str,
        config: Mapping[str, object],
        memories: Memories,
        later: Callable[[int], object] | None = None,
    ) -> None:
        self.file = file
        self._waiting: list[LogRecord] = []
        self._checksums = StateChecksums()
        self._later = later or (lambda waiting: self.write_waiting())
        nvm = {
            device: {name: base64.b64encode(data).decode() for name, data in sections.items()}
            for device, sections in memories.items()
        }
        header = {
            "format": LOG_FORMAT,
            "version": LOG_VERSION,
            "program": program,
            "config": config,
            "nvm": nvm,
        }
        file.write(json.dumps(header, separators=(",", ":")) + "\n")

    def write(self, logged: Logged) -> None:
        self.add(logged)

    def sent(self, device: Twin, port: str, at_ns: SimTimeNs, data: bytes) -> None:
        """Write down what a device sent; a bench's listener."""
        self.add((at_ns, device.name, data, logged_port(device, port), _snapshots(device)))

    def add(self, record: LogRecord) -> None:
        """Write down a record."""
        self._waiting.append(record)
        self._later(len(self._waiting))

    def write_waiting(self, at_most: int | None = None) -> int:
        """Write the first ``at_most`` records that wait, or all; answers how many wait still."""
        records, self._waiting[:at_most] = self._waiting[:at_most], []
        self.file.write("".join([self._line(record) for record in records]))
        return len(self._waiting)

    def _line(self, record: LogRecord) -> str:
        if isinstance(record, Logged):
            return encode_line(record) + "\n"
        at_ns, device, data, port, snapshots = record
        state = "null" if snapshots is None else self._checksums.of(device, snapshots)
        on = f',"port":{quoted(port)}' if port else ""
        return f'{{"at_ns":{at_ns},"device":{quoted(device)},"sent":"{data.hex()}","state":{state}{on}}}\n'

    def end(self) -> None:
        """Write down that the run ended here, and that nothing is missing."""
        self.write_waiting()
        self.file.write(END_LINE)


END_LINE = '{"end":true}\n'
KILLED = "its last lines are missing: the program that writes it runs on, was killed, or had no room left"
NOT_TOLD = "logs of version 1 do not say whether their last lines are missing"


def place(name: str, line: int) -> str:
    """Format a line of a log, for people."""
    return f"{name}:{line}" if name else f"line {line}"


def read_input_log(lines: Iterable[str | bytes], name: str = "") -> InputLog:
    """Read a log; a last line without its end (the writer was killed) is left out. ``name``: of its file.

    Raises:
        InputLogError: this is not an input log, or not of a version that is known here; says where.
    """
    log, is_ended = None, False
    for number, line in enumerate(lines, start=1):
        if line[-1:] not in ("\n", b"\n"):
            break
        try:
            if is_ended:
                raise InputLogError("this is a line behind the log's end")
            if log is None:
                log = _header(read_line(line), name)
            else:
                is_ended = _take(log, read_line(line), number)
        except InputLogError as error:
            raise InputLogError(f"{place(name, number)}: {error}; {REMEDY}") from None
    if log is None:
        raise InputLogError(f"{place(name, 1)}: this is not an input log: it has no whole line; {REMEDY}")
    if is_ended:
        return log
    return replace(log, cut=NOT_TOLD if log.version in OLD_VERSIONS else KILLED)


def _take(log: InputLog, values: dict[str, Any], number: int) -> bool:
    """Take the values of a line into the log; answers whether it was the end."""
    if values == {"end": True}:
        return True
    if "sent" in values:
        log.sent.append(_decode_sent(values))
    else:
        log.inputs.append(decode(values))
        log.lines.append(number)
    return False


REMEDY = "take a log as `hil serve --log` wrote it"


def _header(values: dict[str, Any], name: str) -> InputLog:
    if values.get("format") != LOG_FORMAT:
        raise InputLogError("this is not an input log")
    program = ascii(values.get("program", "another program"))[:80].strip("'")
    version, known = values.get("version"), (*OLD_VERSIONS, LOG_VERSION)
    if version not in known or not isinstance(version, int) or isinstance(version, bool):
        said, reads = ascii(version)[:80], " and ".join(map(str, known))
        raise InputLogError(f"the log has version {said}, of {program}; this program reads {reads}")
    config, nvm = values.get("config"), values.get("nvm")
    if not isinstance(config, dict) or not isinstance(nvm, dict):
        raise InputLogError("the header has to have config and nvm, both objects")
    memories = {}
    for device, sections in nvm.items():
        if not isinstance(sections, dict):
            raise InputLogError(f"nvm of {device[:40]!r} is no object")
        memories[device] = {section: _memory(content) for section, content in sections.items()}
    return InputLog(config, memories, [], [], name=name, program=program, version=version)


def _memory(content: object) -> bytes:
    with suppress(ValueError):
        if isinstance(content, str):
            return base64.b64decode(content, validate=True)
    raise InputLogError("the content of a memory has to be base64")


def _decode_sent(values: dict[str, Any]) -> Sent:
    at_ns, device = taken(values, "at_ns", time_ns), taken(values, "device", text)
    data = taken(values, "sent", hexadecimal)
    state = taken(values, "state", lambda state: None if state is None else whole(state, range(1 << 32)))
    port = taken({"port": ""} | values, "port", text)
    return Sent(SimTimeNs(at_ns), device, data, state, port)
