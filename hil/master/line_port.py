"""A port of a line in an event loop: a serial port or pty, ``socket://`` or ``rfc2217://``, by pyserial."""

import asyncio
import os
import termios
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from hil.master.line_place import LineUnreachable
from hil.net.echo_guard import EchoGuard
from hil.net.port_client import close_serial
from hil.net.serial_words import not_opened
from hil.vocab.line_format import EIGHT_N_1, LineFormat
from hil.wire.echo import Echo

_PIECE = 4096
_READER_LOOK_S = 0.2
"""Time after which a thread that reads looks whether it is still wanted."""
ERRORS = (OSError, ValueError, termios.error)
"""Exceptions of pyserial: its own are OSErrors."""


class LinePort:
    """Port that is open. ``received`` gets what comes and is no echo, ``lost`` the reason when it has gone;
    both are called in the loop."""

    def __init__(
        self,
        port: Any,
        address: str,
        received: Callable[[bytes], None],
        lost: Callable[[str], None],
        echo: Echo,
    ) -> None:
        self.address = address
        self._port = port
        self._guard = EchoGuard(echo, received, address)
        self._received, self._lost = self._guard.received, lost
        self._loop = asyncio.get_running_loop()
        self._is_open = True
        self._fd = _descriptor(port)
        if self._fd is not None:
            self._loop.add_reader(self._fd, self._readable)
        else:
            threading.Thread(target=self._read_on, name=f"line {address}", daemon=True).start()

    @classmethod
    async def open(
        cls,
        address: str,
        baud: int,
        received: Callable[[bytes], None],
        lost: Callable[[str], None],
        echo: Echo,
        line_format: LineFormat = EIGHT_N_1,
    ) -> "LinePort":
        """Open a port. Raises LineUnreachable: it cannot be opened."""
        try:
            port = await asyncio.to_thread(_opened, address, baud, line_format)
        except ERRORS as error:
            raise LineUnreachable(f"{address}: {not_opened(address, error)}", is_mistake=False) from None
        return cls(port, address, received, lost, echo)

    def write(self, data: bytes) -> None:
        """Send bytes."""
        if not self._is_open:
            return
        self._guard.sent(data)
        try:
            self._port.write(data)
        except ERRORS as error:
            self._gone(reason(error))

    def close(self) -> None:
        """Close the port; nothing is called any more."""
        if self._is_open:
            self._is_open = False
            self._guard.close()
            if self._fd is not None:
                self._loop.remove_reader(self._fd)
            close_serial(self._port)

    def _readable(self) -> None:
        try:
            data = self._port.read(_PIECE)
        except ERRORS as error:
            self._gone(reason(error))
            return
        if data:
            self._received(data)

    def _read_on(self) -> None:
        while self._is_open:
            try:
                if data := self._port.read(1):
                    data += self._port.read(self._port.in_waiting)
            except ERRORS as error:
                why = reason(error)
                with suppress(RuntimeError):  # the loop has ended
                    self._loop.call_soon_threadsafe(self._gone, why)
                return
            if data:
                with suppress(RuntimeError):
                    self._loop.call_soon_threadsafe(self._hand_on, data)

    def _hand_on(self, data: bytes) -> None:
        if self._is_open:
            self._received(data)

    def _gone(self, why: str) -> None:
        if self._is_open:
            self.close()
            self._lost(why)


def _opened(address: str, baud: int, line_format: LineFormat) -> Any:
    import serial

    has_parity = not os.path.realpath(address).startswith("/dev/pts/")  # a pty refuses it
    port: Any = serial.serial_for_url(
        address,
        baud,
        bytesize=line_format.data_bits,
        parity=line_format.parity if has_parity else "N",
        stopbits=line_format.stop_bits,
        do_not_open=True,
    )
    port.timeout = 0 if not address.startswith("rfc2217://") else _READER_LOOK_S
    if address.startswith("/"):
        port.exclusive = True
    port.open()
    if hasattr(port, "set_low_latency_mode"):
        with suppress(*ERRORS):  # an adapter's driver has it, a pty has not
            port.set_low_latency_mode(True)
    return port


def _descriptor(port: Any) -> int | None:
    """File descriptor that says when something has come; None: it has none."""
    with suppress(*ERRORS, AttributeError):
        return int(port.fileno())
    return None


def reason(error: Exception) -> str:
    """Words of the system for an error of a port."""
    if isinstance(error, termios.error):
        return str(error.args[-1])
    if isinstance(error, OSError) and error.errno and error.errno > 0:
        return os.strerror(error.errno)
    said = str(error)
    if "readiness to read" in said or "disconnected" in said:
        return "it was disconnected"
    return said
