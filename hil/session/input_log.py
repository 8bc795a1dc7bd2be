"""The input log of a run: enough to run it again, exactly, on the virtual clock.

A text file of JSON lines. The first is the header: format, version, the program's version, the
configuration, and each device's memory at the start. The others are inputs (``inputs.encode_line``),
and, for comparison, what devices sent: ``at_ns``, ``device``, ``sent`` (hexadecimal digits), ``state``
(CRC-32 of the axis's snapshot at that time; null for what an interrupt sent). ``port`` stands in those of
another serial interface than the main one.
"""

import base64
import json
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from hil.session.device import Device
from hil.session.inputs import LOG_FORMAT, LOG_VERSION, InputLogError, Logged, decode_line, encode_line
from hil.vocab.firmware import MAIN
from hil.vocab.time import SimTimeNs

Memories = Mapping[str, Mapping[str, bytes]]
"""Non-volatile sections of each device."""


@dataclass(frozen=True)
class Sent:
    """Bytes a device sent, and a checksum of its axis's state at that very time."""

    at_ns: SimTimeNs
    device: str
    data: bytes
    state: int | None
    port: str = MAIN


def sent_now(device: Device, port: str, at_ns: SimTimeNs, data: bytes) -> Sent:
    """What a device sends now. What an interrupt sent has no state: it is noticed later than it happened,
    at a time that depends on the machine's load."""
    state = None if device.interrupting else zlib.crc32(repr(device.axis.snapshot()).encode())
    return Sent(at_ns, device.name, data, state, port)


@dataclass(frozen=True)
class InputLog:
    """A log as read back."""

    config: dict[str, Any]
    memories: dict[str, dict[str, bytes]]
    inputs: list[Logged]
    sent: list[Sent]
    cut: bool = False
    """Its writer was killed, or had no room left: answers to the last inputs are missing."""


class Text(Protocol):
    """Where lines go."""

    def write(self, text: str, /) -> object:
        """Append."""


class InputLogWriter:
    """Appends to an open text file. The caller flushes and closes it."""

    def __init__(self, file: Text, program: str, config: Mapping[str, object], memories: Memories) -> None:
        self.file = file
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
        self.file.write(encode_line(logged) + "\n")

    def sent(self, device: Device, port: str, at_ns: SimTimeNs, data: bytes) -> None:
        """Note what a device sent; a bench's listener."""
        state = sent_now(device, port, at_ns, data).state
        line = {"at_ns": at_ns, "device": device.name, "sent": data.hex(), "state": state}
        if port != MAIN:
            line["port"] = port
        self.file.write(json.dumps(line, separators=(",", ":")) + "\n")


def read_input_log(lines: Iterable[str]) -> InputLog:
    """Read a log; a last line without its end (the writer was killed) is left out.

    Raises:
        InputLogError: this is not an input log, or not of a version that is known here.
    """
    try:
        texts = list(lines)
        cut = bool(texts) and not texts[-1].endswith("\n")
        if cut:
            texts.pop()
        header = json.loads(texts[0])
        if header["format"] != LOG_FORMAT:
            raise InputLogError("this is not an input log")
        if header["version"] != LOG_VERSION:
            raise InputLogError(f"the log has version {header['version']}; this program reads {LOG_VERSION}")
        memories = {
            device: {name: base64.b64decode(data) for name, data in sections.items()}
            for device, sections in header["nvm"].items()
        }
        sent = [_decode_sent(text) for text in texts[1:] if '"sent":' in text]
        inputs = [decode_line(text) for text in texts[1:] if '"sent":' not in text]
        return InputLog(header["config"], memories, inputs, sent, cut)
    except (ValueError, KeyError, TypeError, IndexError, AttributeError) as error:
        raise InputLogError(f"this is not an input log: {error!r}") from error


def _decode_sent(text: str) -> Sent:
    line = json.loads(text)
    data, port = bytes.fromhex(line["sent"]), line.get("port", MAIN)
    return Sent(SimTimeNs(line["at_ns"]), line["device"], data, line["state"], port)
