"""Keywords at ports and taps: what is typed, and what should come."""

import re
from collections.abc import Callable
from datetime import timedelta

import serial
from robot.api import Failure

from hil.robot.bench_kind import AtBench, BenchKind, refusals

_SECOND = timedelta(seconds=1)
_SHOWN = 2000
"""Maximum of characters that a failure shows of what came."""


class OpenPort:
    """Port that keywords have open. ``heard``: what came and nobody has read yet."""

    def __init__(self, port: serial.Serial, kind: BenchKind) -> None:
        self._port, self._kind = port, kind
        self.heard = ""
        self.close = port.close

    def write(self, data: bytes) -> None:
        self._port.write(data)

    def poll(self) -> None:
        """Hear what has come; no time passes."""
        self._port.timeout = 0
        while data := self._port.read(4096):
            self.heard += data.decode("latin-1")

    def read_until(self, end: Callable[[str], int], within_s: float) -> str | None:
        """Read up to ``end``, a place in what is heard, -1: not there yet; None: it does not come in time."""
        last_s = self._kind.now_s + within_s
        self.poll()
        while (place := end(self.heard)) < 0:
            left_s = last_s - self._kind.now_s
            self._port.timeout = max(left_s, 0) / self._kind.speed
            if left_s <= 0 or not (data := self._port.read(1)):
                return None
            self.heard += data.decode("latin-1")
        text, self.heard = self.heard[:place], self.heard[place:]
        return text


class PortKeywords(AtBench):
    """Keywords at ports."""

    def __init__(self) -> None:
        self._ports: dict[str, OpenPort] = {}

    def _port(self, name: str) -> OpenPort:
        if name not in self._ports:
            self.open_port(name)
        return self._ports[name]

    def open_port(self, port: str, baud: int | None = None) -> None:
        """Open a port or a tap, at the line's speed or at ``baud``.

        Other keywords open a port by themselves. This one is for a test that needs what comes before: a
        port hears from when it is open.

        | Open Port    m1
        | Power Cycle    m1
        | Line Should Come    m1    Mechaduino 0.X    within=5 s
        """
        with refusals():
            if old := self._ports.pop(port, None):
                old.close()
            self._ports[port] = OpenPort(self._kind.open_port(port, baud), self._kind)

    def type(self, port: str, text: bytes) -> None:
        r"""Type at a port or a tap, as a client does.

        Characters are bytes: ``\r`` is a carriage return, ``\x02`` a byte by its number.

        | Type    s1    m3000v150\r
        """
        with refusals():
            self._port(port).write(text)

    def line_should_come(
        self, port: str, text: str, within: timedelta = _SECOND, regexp: bool = False
    ) -> str:
        """Wait for a line that has ``text`` in it; lines before it are skipped. Answers the line.

        With ``regexp`` the text is a regular expression. The failure shows what came instead.

        | Line Should Come    m1    Angle: 90.
        | Line Should Come    m1    raw encoder: \\\\d+    within=200 ms    regexp=True
        """
        pattern = re.compile(text if regexp else re.escape(text))
        at, skipped = self._port(port), list[str]()
        last_s = self._kind.now_s + within.total_seconds()
        while (line := at.read_until(_line_end, last_s - self._kind.now_s)) is not None:
            line = line.rstrip("\r\n")
            if pattern.search(line):
                return line
            skipped.append(line)
        came = [*skipped, *filter(None, [at.heard])]
        raise Failure(f"{port}: no line with {text!r} within {_said(within)}; {_shown(came)}")

    def text_should_come(self, port: str, text: str, within: timedelta = _SECOND) -> str:
        """Wait for a text, such as a prompt, wherever lines end. Answers all up to it.

        | Text Should Come    s1    SAC>
        """
        at = self._port(port)
        came = at.read_until(
            lambda heard: place + len(text) if (place := heard.find(text)) >= 0 else -1,
            within.total_seconds(),
        )
        if came is None:
            raise Failure(
                f"{port}: {text!r} did not come within {_said(within)}; {_shown(at.heard.splitlines())}"
            )
        return came

    def nothing_should_come(self, port: str, within: timedelta = _SECOND) -> None:
        """Let time pass and fail if anything comes, or has come and was not read.

        | Type    m1    z
        | Nothing Should Come    m1    within=200 ms
        """
        at = self._port(port)
        at.read_until(lambda heard: 0 if heard else -1, within.total_seconds())
        if at.heard:
            raise Failure(f"{port}: {_shown(at.heard.splitlines())}")

    def read_port(self, port: str) -> str:
        """Answer what has come at a port and was not read yet. No time passes."""
        at = self._port(port)
        at.poll()
        text, at.heard = at.heard, ""
        return text


def _line_end(heard: str) -> int:
    return heard.find("\n") + 1 or -1


def _said(duration: timedelta) -> str:
    return f"{duration.total_seconds():g} s"


def _shown(lines: list[str]) -> str:
    if not lines:
        return "nothing came"
    text = "\n".join(lines)
    return "what came:\n" + ("..." + text[-_SHOWN:] if len(text) > _SHOWN else text)
