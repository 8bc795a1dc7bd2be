"""Client's side of both programs: lines on standard input, JSON on standard output."""

import json
import os
from typing import TextIO

from hil.arduino.protocol import Message

_READ_BYTES = 65536


class InputLines:
    """Lines from a file descriptor. Read when it is readable, and ``ended`` is false."""

    def __init__(self, fd: int) -> None:
        self.fd = fd
        self.ended = False
        self._pending = b""

    def read(self) -> list[str]:
        """Read the lines that are complete now."""
        data = os.read(self.fd, _READ_BYTES)
        self.ended = not data
        *lines, self._pending = (self._pending + data).split(b"\n")
        return [line.decode(errors="replace") for line in lines]


def send(messages: list[Message], out: TextIO) -> None:
    """Write one line of JSON for each message."""
    for message in messages:
        out.write(json.dumps(message) + "\n")
    out.flush()
