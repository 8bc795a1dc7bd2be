"""An open serial port as the event loop sees it: by its file descriptor, or by threads where it has none."""

import asyncio
import errno
import os
import queue
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

import serial

from hil.net.port_client import close_serial
from hil.net.traffic import Outgoing, Traffic
from hil.vocab.ports import PortHost

READ_BYTES = 65536
QUEUE_BYTES = 1024 * 1024
"""Maximum length that waits for a slow line, nearly five minutes at 38400 baud."""
_THREAD_READ_S = 0.05


Lost = Callable[[str], None]
"""Called once, in the event loop's thread, when the line is dead, with the reason."""


def open_serial(url: str, baud: int, rs485: bool = False) -> Any:
    """Open by pyserial; may block for seconds. ``rs485``: with the kernel's RS485 mode.

    Raises:
        OSError, ValueError: it cannot be opened, or has no such mode.
    """
    port = serial.serial_for_url(url, baud, do_not_open=True)
    port.timeout = 0
    if "://" not in url:
        # Two programs at one line would get a part each of what comes; only a device node can be locked.
        port.exclusive = True
        port.write_timeout = 0
    if rs485:
        from serial.rs485 import RS485Settings

        port.rs485_mode = RS485Settings()
    port.open()
    return port


def why(error: Exception, url: str = "") -> str:
    """Describe an error of pyserial or the system in a few words. ``url``: of the port that was not opened,
    for what to do."""
    if url and "://" not in url and os.path.isfile(url):
        return "this is no serial port, but a file; write a path as in /dev/ttyUSB0"
    if url and getattr(error, "errno", None) == errno.ENOENT:
        return f"{os.strerror(errno.ENOENT)}; plug it in, or correct its path"
    return os.strerror(error.errno) if isinstance(error, OSError) and error.errno else str(error)


class FdLine:
    """Line of a device node or a socket. ``traffic`` counts what passes, and what is dropped."""

    def __init__(
        self, port: Any, host: PortHost, lost: Lost, traffic: Traffic, loop: asyncio.AbstractEventLoop
    ) -> None:
        self._port = port
        self._fd: int = port.fileno()
        self._host = host
        self._lost = lost
        self._traffic = traffic
        self._loop = loop
        self._reading = False
        self._open = True
        send = partial(os.write, self._fd)
        self._out = Outgoing(
            self._fd, send, loop, traffic, self._drained, lambda error: self._die(why(error)), QUEUE_BYTES
        )
        self.resume()

    @property
    def backlog(self) -> int:
        return self._out.backlog_bytes

    def write(self, data: bytes) -> None:
        """Send or queue bytes. Never blocks; what finds no room is dropped."""
        self._out.write(data)

    def _drained(self) -> None:
        if self._open:
            self._loop.call_soon(self._host.drained)  # not in the middle of a write

    def resume(self) -> None:
        if self._open and not self._reading:
            self._reading = True
            self._loop.add_reader(self._fd, self._readable)

    def _readable(self) -> None:
        room = self._host.room()
        if room <= 0:
            self._reading = False
            self._loop.remove_reader(self._fd)
            return
        try:
            data = os.read(self._fd, min(room, READ_BYTES))
        except BlockingIOError:
            return
        except OSError as error:
            self._die(why(error))
            return
        if data:
            self._traffic.rx_bytes += len(data)
            self._host.received(data)
        else:
            self._die("it has gone")

    def _die(self, reason: str) -> None:
        if self._open:
            self.close()
            self._loop.call_soon(self._lost, reason)  # not in the middle of a write

    def close(self) -> None:
        """Close the line, and drop what was not sent."""
        if self._open:
            self._open = False
            self._out.stop()
            self._loop.remove_reader(self._fd)
            close_serial(self._port)


class ThreadLine:
    """Line of a port without a file descriptor (RFC 2217): a thread that reads, and one that writes."""

    def __init__(
        self, port: Any, host: PortHost, lost: Lost, traffic: Traffic, loop: asyncio.AbstractEventLoop
    ) -> None:
        self._port = port
        self._host = host
        self._lost = lost
        self._traffic = traffic
        self._loop = loop
        self._open = True
        self._backlog = 0
        self._unread = bytearray()
        self._may_read = threading.Event()
        self._may_read.set()
        self._writes: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        port.timeout = _THREAD_READ_S
        self._threads = [
            threading.Thread(target=run, name=f"serial-{name}", daemon=True)
            for name, run in (("read", self._read), ("write", self._write))
        ]
        for thread in self._threads:
            thread.start()

    @property
    def backlog(self) -> int:
        return self._backlog

    def resume(self) -> None:
        self._deliver()

    def _tell(self, call: Callable[..., None], *arguments: object) -> None:
        with suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(call, *arguments)

    def _read(self) -> None:
        while self._open:
            self._may_read.wait()
            try:
                # One byte first: a read of more waits until all of them are there, or its time is over.
                data = self._port.read(1)
                if data and (more := self._port.in_waiting):
                    data += self._port.read(more)
            except (OSError, TypeError, AttributeError) as error:  # pyserial's own after a close elsewhere
                self._tell(self._die, why(error))
                return
            if data:
                self._tell(self._received, data)

    def _received(self, data: bytes) -> None:
        self._unread += data
        self._deliver()

    def _deliver(self) -> None:
        """Hand on as much as there is room for; a rest stops the reading."""
        while self._open and self._unread and (room := self._host.room()) > 0:
            data = bytes(self._unread[:room])
            del self._unread[:room]
            self._traffic.rx_bytes += len(data)
            self._host.received(data)
        if self._unread and self._open:
            self._may_read.clear()
        else:
            self._may_read.set()

    def write(self, data: bytes) -> None:
        """Queue bytes. Never blocks; what finds no room is dropped."""
        taken = data[: QUEUE_BYTES - self._backlog] if self._open else b""
        self._traffic.dropped_bytes += len(data) - len(taken)
        self._backlog += len(taken)
        if taken:
            self._writes.put(taken)

    def _write(self) -> None:
        while data := self._writes.get():
            try:
                self._port.write(data)
            except (OSError, TypeError, AttributeError) as error:
                # On to the end of the queue: `close` puts there what ends this thread.
                self._tell(self._die, why(error))
                continue
            self._tell(self._written, len(data))
        close_serial(self._port)  # sleeps for 0.3 s

    def _written(self, count: int) -> None:
        self._backlog -= count
        self._traffic.tx_bytes += count
        if self._open and not self._backlog:
            self._host.drained()

    def _die(self, reason: str) -> None:
        if self._open:
            self.close()
            self._traffic.dropped_bytes += self._backlog
            self._lost(reason)

    def close(self) -> None:
        """End both threads; what waits is not sent."""
        if self._open:
            self._open = False
            self._may_read.set()
            self._writes.put(b"")
