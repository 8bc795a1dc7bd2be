"""Reader of an input log, line by line, also while it grows.

What is whole can be had of a log that was cut or damaged: its lines up to its end, or up to the last check
before the first line that is wrong.
"""

import re
import zlib
from array import array
from collections.abc import Iterable
from dataclasses import replace
from typing import Any, NamedTuple

from hil.sim.input_log import InputLog, ReloadPlace, place
from hil.sim.input_reading import decode, hexadecimal, number, read_line, taken, text, time_ns, whole
from hil.sim.inputs import LOG_FORMAT, LOG_VERSION, OLD_VERSIONS, Bytes, InputLogError, Logged
from hil.sim.log_checks import ENDS, STOPPED
from hil.sim.noted_events import NotedEvent, decode_event
from hil.sim.reloads import decode_reload, memories_of
from hil.sim.sent_pieces import SentPieces
from hil.vocab.time import NS_PER_S, SimTimeNs

KILLED = "its last lines are missing: the program that writes it runs on, was killed, or had no room left"
NOT_TOLD = "logs of version 1 do not say whether their last lines are missing"
REMEDY = "take a log as `hil serve --log` wrote it"
NO_RECORDING = "this is no recording"
THERE_ARE = "`hil recordings` lists those that are there"
_U32 = range(1 << 32)
_AT = rb'\{"at_ns":(0|[1-9]\d{0,17}),"device":"([ !#-\[\]-~]*)",'
_SENT = re.compile(
    _AT + rb'"sent":"((?:[0-9a-f]{2})*)","state":(null|0|[1-9]\d{0,9})(?:,"port":"([ !#-\[\]-~]*)")?\}\n'
)
_TYPED = re.compile(
    _AT + rb'"input":"bytes","data":"((?:[0-9a-f]{2})*)","client_baud":(null|[1-9]\d{0,9})\}\n'
)
"""The two most frequent lines, as they are written: read so, a log of an hour takes a fifth of the time."""
_KEPT_TYPED = 4096
"""Number of inputs of bytes that are kept to stand for equal ones: a master polls in the same words."""


class _Checked(NamedTuple):
    """Place up to which the checks confirm the log: numbers of lines, inputs, pieces and others, and the
    time."""

    line: int = 0
    inputs: int = 0
    sent: int = 0
    end_ns: int = 0
    reloads: int = 0
    events: int = 0


class LogReading:
    """Reading of a log. ``name``: of its file, for messages."""

    def __init__(self, name: str = "") -> None:
        self._name = name
        self._header: InputLog | None = None
        self._inputs: list[Logged] = []
        self._lines = array("Q")
        self._sent = SentPieces()
        self._reloads: list[ReloadPlace] = []
        self._events: list[NotedEvent] = []
        self._crc = self._number = self._end_ns = 0
        self._good = 0
        """Number of the last line that is right, as far as it tells by itself."""
        self._why: str | None = None
        self._checked = _Checked()
        self._typed: dict[tuple[bytes, bytes], Bytes] = {}
        self._names: dict[bytes, str] = {}

    def add(self, line: str | bytes) -> None:
        """Add the next line, with its end.

        Raises:
            InputLogError: it is wrong, or says that one before it is; says where.
        """
        self._number += 1
        data = line if isinstance(line, bytes) else line.encode(errors="surrogatepass")
        try:
            if self._why is not None:
                raise InputLogError("this is a line behind the log's end")
            if self._header is None:
                self._header = _header(_first(line), self._name)
                self._note_checked()
            elif not self._take_frequent(data):
                self._take(read_line(line))
        except InputLogError as error:
            remedy = THERE_ARE if str(error) == NO_RECORDING else REMEDY
            raise InputLogError(f"{place(self._name, self._number)}: {error}; {remedy}") from None
        self._crc = zlib.crc32(data, self._crc)
        self._good = self._number

    def log(self, damage: str = "") -> InputLog:
        """Log as read so far. ``damage``: the error of the line that was added last, or of one that cannot be
        had: what no check confirms is left out then.

        Raises:
            InputLogError: there is not even a header.
        """
        if self._header is None:
            missing = f"{NO_RECORDING}: it has no whole line"
            raise InputLogError(damage or f"{place(self._name, 1)}: {missing}; {THERE_ARE}")
        cut = self._cut()
        if damage:
            self._leave_out()
            after = f"{self._end_ns / NS_PER_S:.9f}".rstrip("0").rstrip(".")
            cut = damage = (
                f"{damage}; all from line {self._checked.line + 1} on, after {after} s, is left out"
            )
        return replace(
            self._header,
            inputs=self._inputs,
            lines=self._lines,
            sent=self._sent,
            reloads=self._reloads,
            events=self._events,
            cut=cut,
            end_ns=self._end_ns,
            why=self._why or "",
            damage=damage,
        )

    def _cut(self) -> str:
        if self._why is None:
            return NOT_TOLD if self._header and self._header.version == 1 else KILLED
        return ENDS.get(self._why, f"its end says {self._why[:40]!r}")

    def _leave_out(self) -> None:
        """Leave out what no check confirms; without checks, only the line that is wrong."""
        if self._header and self._header.version in OLD_VERSIONS:
            self._checked = self._here(self._good)
        at = self._checked
        del self._inputs[at.inputs :]
        del self._lines[at.inputs :]
        self._sent.cut(at.sent)
        del self._reloads[at.reloads :]
        del self._events[at.events :]
        self._end_ns = at.end_ns
        self._why = None

    def _note_checked(self) -> None:
        self._checked = self._here(self._number)

    def _here(self, line: int) -> _Checked:
        """Place behind all that was read."""
        inputs, sent, reloads, events = map(len, (self._inputs, self._sent, self._reloads, self._events))
        return _Checked(line, inputs, sent, self._end_ns, reloads, events)

    def _take_frequent(self, line: bytes) -> bool:
        """Take a line of the two most frequent forms; answers whether it was one."""
        if found := _SENT.fullmatch(line):
            at, device, data, state, port = found.groups()
            if len(state) == 10 and int(state) not in _U32:
                return False
            value = None if state == b"null" else int(state)
            name = self._name_of(device)
            self._sent.append(int(at), name, bytes.fromhex(data.decode()), value, (port or b"").decode())
        elif found := _TYPED.fullmatch(line):
            at, device, data, baud = found.groups()
            if (given := self._typed.get((data, baud))) is None:
                if len(self._typed) == _KEPT_TYPED:
                    self._typed.clear()
                chosen = None if baud == b"null" else int(baud)
                given = self._typed[data, baud] = Bytes(bytes.fromhex(data.decode()), chosen)
            self._inputs.append(Logged(SimTimeNs(int(at)), self._name_of(device), given))
            self._lines.append(self._number)
        else:
            return False
        self._end_ns = max(self._end_ns, int(at))
        return True

    def _name_of(self, device: bytes) -> str:
        if (name := self._names.get(device)) is None:
            name = self._names[device] = device.decode()
        return name

    def _take(self, values: dict[str, Any]) -> None:
        assert self._header is not None
        if "end" in values:
            self._take_end(values, has_checks=self._header.version not in OLD_VERSIONS)
        elif "check" in values and self._header.version not in OLD_VERSIONS:
            self._take_check(values)
        elif "sent" in values:
            self._take_sent(values)
        elif "reload" in values and self._header.version not in OLD_VERSIONS:
            reload = decode_reload(values)
            self._reloads.append(ReloadPlace(reload, len(self._inputs), len(self._sent)))
            self._end_ns = max(self._end_ns, reload.at_ns)
        elif "event" in values and self._header.version not in OLD_VERSIONS:
            self._events.append(decode_event(values))
        else:
            logged = decode(values)
            self._inputs.append(logged)
            self._lines.append(self._number)
            self._end_ns = max(self._end_ns, logged.at_ns)

    def _take_end(self, values: dict[str, Any], *, has_checks: bool) -> None:
        if not has_checks and values != {"end": True}:
            raise InputLogError("this line is damaged: its end is wrong")
        why = taken(values, "why", text) if has_checks else STOPPED
        if has_checks:
            self._take_check(values)
        self._why = why

    def _take_check(self, values: dict[str, Any]) -> None:
        at_ns, crc = taken(values, "at_ns", time_ns), taken(values, "check", lambda crc: whole(crc, _U32))
        lines = taken(values, "lines", whole)
        if lines != self._number - 1:
            raise InputLogError(f"{lines} lines have to stand before this one: some are missing, or too many")
        if crc != self._crc:
            raise InputLogError("its checksum is that of other lines: some before it were changed")
        self._end_ns = max(self._end_ns, at_ns)
        self._note_checked()

    def _take_sent(self, values: dict[str, Any]) -> None:
        at_ns, device = taken(values, "at_ns", time_ns), taken(values, "device", text)
        data = taken(values, "sent", hexadecimal)
        state = taken(values, "state", lambda state: None if state is None else whole(state, _U32))
        port = taken({"port": ""} | values, "port", text)
        self._sent.append(at_ns, device, data, state, port)
        self._end_ns = max(self._end_ns, at_ns)


def read_input_log(lines: Iterable[str | bytes], name: str = "", *, strict: bool = True) -> InputLog:
    """Read a log; a last line without its end (the writer was killed) is left out. ``name``: of its file;
    ``strict``: a log that is damaged is refused, otherwise it is read as far as it is whole.

    Raises:
        InputLogError: this is no recording, or not of a version that is known here; says where.
    """
    reading = LogReading(name)
    try:
        for line in lines:
            if line[-1:] not in ("\n", b"\n"):
                break
            reading.add(line)
    except InputLogError as error:
        if strict:
            raise
        return reading.log(str(error))
    return reading.log()


def _first(line: str | bytes) -> dict[str, Any]:
    try:
        return read_line(line)
    except InputLogError:
        raise InputLogError(NO_RECORDING) from None


def _header(values: dict[str, Any], name: str) -> InputLog:
    if values.get("format") != LOG_FORMAT:
        raise InputLogError(NO_RECORDING)
    program = ascii(values.get("program", "another program"))[:80].strip("'")
    version, known = values.get("version"), (*OLD_VERSIONS, LOG_VERSION)
    if version not in known or not isinstance(version, int) or isinstance(version, bool):
        said, reads = ascii(version)[:80], f"{', '.join(map(str, OLD_VERSIONS))} and {LOG_VERSION}"
        raise InputLogError(f"the log has version {said}, of {program}; this program reads {reads}")
    config, nvm = values.get("config"), values.get("nvm")
    if not isinstance(config, dict) or not isinstance(nvm, dict):
        raise InputLogError("the header has to have config and nvm, both objects")
    memories = memories_of(nvm)
    begun = taken({"begun": None} | values, "begun", lambda begun: None if begun is None else text(begun))
    speed = taken({"speed": 1.0} | values, "speed", number)
    read = InputLog(
        config, memories, [], [], name=name, program=program, version=version, begun=begun, speed=speed
    )
    ports, forked_from = values.get("ports", {}), taken({"forked_from": ""} | values, "forked_from", text)
    if not isinstance(ports, dict) or not all(isinstance(kind, str) for kind in ports.values()):
        raise InputLogError("ports in the header have to be an object of texts")
    return replace(read, ports=ports, forked_from=forked_from)
