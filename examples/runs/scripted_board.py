"""A board in thirty lines behind a serial port: as much of a Mechaduino's menu as a run types at."""

import os
import re
import threading
import time
import tty
from pathlib import Path

READINGS_S = 0.1
_SET_POINT = re.compile(rb"r(-?\d+(?:\.\d+)?)\n")


class ScriptedBoard:
    """Board that answers at ``link`` until ``close``. ``told``: every set-point, in degrees."""

    def __init__(self, link: Path) -> None:
        self.told: list[float] = []
        self._angle_deg = 12.34
        self._link = link
        self._master, slave = os.openpty()
        tty.setraw(slave)
        link.symlink_to(os.ttyname(slave))
        self._slave = slave  # kept open: the port is there while nobody uses it
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        waiting = b""
        while data := os.read(self._master, 1000):
            waiting += data
            while waiting and not (waiting[:1] == b"r" and b"\n" not in waiting):
                waiting = self._command(waiting)

    def _command(self, typed: bytes) -> bytes:
        """Carry out what was typed first; the rest of it."""
        if match := _SET_POINT.match(typed):
            self._angle_deg = float(match[1])
            self.told.append(self._angle_deg)
            self._say(f"Enter setpoint:\r\n{self._angle_deg:.2f}\r\n")
            return typed[match.end() :]
        if typed[:1] == b"y":
            time.sleep(READINGS_S)
            self._say(f"New setpoint {self._angle_deg:.2f}\r\n")
        return typed[1:]  # x, n, and what the menu does not know, say nothing

    def _say(self, text: str) -> None:
        os.write(self._master, text.encode())

    def close(self) -> None:
        self._link.unlink()
