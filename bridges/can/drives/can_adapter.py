"""Bus of python-can at one place: frames in on the event loop, frames out and the beat of SYNC by a thread.

python-can is imported with the first place that is opened: a bench without real CAN drives does without.
Its serial adapters wait until each frame has left the computer, which nobody else should wait for; and a SYNC
should wait for nobody.
"""

import asyncio
import errno
import logging
import os
import select
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from threading import Event, Thread
from typing import TYPE_CHECKING, Any

from bridges.can.drives.can_drive_address import CanPlace
from bridges.can.frames.can_frame import CanFrame
from hil.drives.drive_link import PlaceLost

if TYPE_CHECKING:
    from can import BusABC, Message

SEND_S = 1.0
"""Time for an adapter to take a frame. On a busy computer a program behind a pseudo-terminal may read nothing
for longer than 0.2 s."""
MOST_WAITING = 2000
"""Frames that wait for an adapter at most: one that takes none for so long is not there."""
STARTS_S = 2.0
"""Time for an adapter on USB to start: some are reset as their port is opened."""
BEAT_PRIORITY = 1
"""Real-time priority of the thread that sends, the least: it waits most of the time, and each SYNC in time is
worth more than what others do."""
_AT_A_TIME = 100
_CLOSES_S = 1.0
_BUS_OFF = 0x40
"""Bit of an error frame of SocketCAN (CAN_ERR_BUSOFF of linux/can/error.h)."""
_S7 = {800_000: 750_000}
"""Bit rates that python-can has under another number: its S7 is 750000, Lawicel's 800000."""

log = logging.getLogger("hil")


@dataclass(frozen=True)
class Beat:
    """Frames sent at an interval: ``frames`` makes those of one time, in the thread that sends them."""

    period_s: float
    frames: Callable[[], Iterable[CanFrame]]


class CanAdapter:
    """Bus at one place. ``hear``: called with each frame; ``lost``: called once, with the reason, when the
    bus is gone. Both on the event loop."""

    def __init__(
        self, place: CanPlace, hear: Callable[[CanFrame], None], lost: Callable[[str], None], beat: Beat
    ) -> None:
        self._place, self._hear, self._lost, self._beat = place, hear, lost, beat
        self._bus: BusABC | None = None
        self._loop = asyncio.get_running_loop()
        self._out: SimpleQueue[CanFrame | None] = SimpleQueue()
        self._ending = Event()
        self._fd: int | None = None
        self._threads: list[Thread] = []
        self.garbled = 0
        """Count of what came and was no frame."""
        self.unsent = 0
        """Frames for which the adapter had no room."""

    @property
    def is_open(self) -> bool:
        return self._bus is not None

    async def open(self) -> None:
        """Open the bus. Raises PlaceLost: that cannot be done now."""
        opening = self._loop.run_in_executor(None, open_bus, self._place)
        try:
            # Its thread cannot be stopped: what it opens after a cancellation is shut down then.
            bus = await asyncio.shield(opening)
        except asyncio.CancelledError:
            opening.add_done_callback(_shut_down_late)
            raise
        except Exception as error:  # of python-can, pyserial, termios, the socket: it cannot be had now
            raise PlaceLost(f"{self._place}: {reason(error)}") from None
        self._bus = bus
        self._ending.clear()
        # Another one: the thread of the last time may still wait at its own.
        self._out = SimpleQueue()
        self._threads = [Thread(target=self._write, args=(bus, self._out), daemon=True, name="hil-can-out")]
        self._fd = _fd_of(bus)
        if self._fd is None:
            self._threads.append(Thread(target=self._read, args=(bus,), daemon=True, name="hil-can-in"))
        else:
            self._loop.add_reader(self._fd, self._readable)
        for thread in self._threads:
            thread.start()

    def send(self, frame: CanFrame) -> None:
        """Send a frame when its turn comes. Raises PlaceLost."""
        if self._bus is None:
            raise PlaceLost(f"{self._place}: it is not open")
        if self._out.qsize() >= MOST_WAITING:
            self._end(f"{self._place}: the adapter takes no frames any more")
            raise PlaceLost(f"{self._place}: the adapter takes no frames any more")
        self._out.put(frame)

    async def close(self) -> None:
        """Close the bus; what waits is not sent."""
        bus = self._take_bus()
        if bus is None:
            return
        with suppress(TimeoutError):
            async with asyncio.timeout(_CLOSES_S):
                await self._loop.run_in_executor(None, self._shut_down, bus)

    def _take_bus(self) -> "BusABC | None":
        bus, self._bus = self._bus, None
        if self._fd is not None:
            self._loop.remove_reader(self._fd)
            self._fd = None
        return bus

    def _shut_down(self, bus: "BusABC") -> None:
        self._ending.set()
        self._out.put(None)
        for thread in self._threads:
            thread.join(_CLOSES_S)
        _shut_down(bus)

    def _end(self, why: str) -> None:
        """Say that the bus is gone, once."""
        bus = self._take_bus()
        if bus is not None:
            self._loop.run_in_executor(None, self._shut_down, bus)
            self._lost(why)

    # ---- out ----

    def _write(self, bus: "BusABC", out: "SimpleQueue[CanFrame | None]") -> None:
        with suppress(OSError):  # without the right the beat is as punctual as the computer is idle
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(BEAT_PRIORITY))
        try:
            due_s = time.monotonic()
            while not self._ending.is_set():
                if (left_s := due_s - time.monotonic()) <= 0:
                    for frame in self._beat.frames():
                        self._put(bus, frame)
                    # None is sent twice to catch up.
                    due_s = max(due_s + self._beat.period_s, time.monotonic())
                    continue
                with suppress(Empty):
                    if (waiting := out.get(timeout=left_s)) is None:
                        return
                    self._put(bus, waiting)
        except Exception as error:
            if not _is_of_the_system(error):
                log.exception("the bus %s", self._place)
            self._say_lost(f"{self._place}: {reason(error)}")

    def _put(self, bus: "BusABC", frame: CanFrame) -> None:
        from can import Message

        message = Message(
            arbitration_id=frame.id,
            is_extended_id=frame.is_extended,
            is_remote_frame=frame.is_remote,
            dlc=frame.dlc,
            data=None if frame.is_remote else frame.data,
        )
        try:
            bus.send(message, timeout=SEND_S)
        except Exception as error:
            if not _has_no_room(error):
                raise
            self.unsent += 1

    # ---- in ----

    def _readable(self) -> None:
        bus, fd = self._bus, self._fd
        if bus is None or fd is None:
            return
        for _ in range(_AT_A_TIME):
            self._take(lambda: bus.recv(0))
            if self._bus is None or not select.select([fd], [], [], 0)[0]:
                return

    def _take(self, receive: "Callable[[], Message | None]") -> None:
        """Take what can be read; the bus is gone if it cannot be read any more."""
        try:
            message = receive()
        except Exception as error:
            if not _is_of_the_system(error):
                self.garbled += 1  # a line of a serial adapter, or a datagram, that is no frame
                return
            self._end(f"{self._place}: {reason(error)}")
            return
        if message is not None:
            self._heard(message)

    def _heard(self, message: "Message") -> None:
        if message.is_error_frame:
            if message.arbitration_id & _BUS_OFF:
                self._end(f"{self._place}: the adapter is bus-off")
            return
        if message.is_fd:
            return
        dlc = message.dlc if message.is_remote_frame else 0
        self._hear(
            CanFrame(
                message.arbitration_id,
                bytes(message.data),
                message.is_extended_id,
                message.is_remote_frame,
                dlc,
            )
        )

    def _read(self, bus: "BusABC") -> None:
        while not self._ending.is_set():
            try:
                message = bus.recv(0.1)
            except Exception as error:
                if self._ending.is_set():
                    return
                if _is_of_the_system(error):
                    self._say_lost(f"{self._place}: {reason(error)}")
                    return
                self.garbled += 1
                continue
            if message is not None:
                with suppress(RuntimeError):  # the event loop has ended
                    self._loop.call_soon_threadsafe(self._heard, message)

    def _say_lost(self, why: str) -> None:
        with suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._end, why)


def open_bus(place: CanPlace) -> "BusABC":
    """Open a bus of python-can, which takes its time. Raises whatever it raises."""
    import can

    logging.getLogger("can").setLevel(logging.CRITICAL + 1)  # what it would log, the drives' state says, once
    options: dict[str, Any] = {}
    if place.interface == "slcan":
        is_usb = os.path.realpath(place.channel).startswith(("/dev/ttyUSB", "/dev/ttyACM"))
        options = {
            "tty_baudrate": place.baud,
            "bitrate": _S7.get(place.bit_rate or 0, place.bit_rate),
            "sleep_after_open": STARTS_S if is_usb else 0.0,
        }
    elif place.interface == "udp_multicast":
        options = {"port": place.port, "fd": False}
    return can.Bus(channel=place.channel, interface=place.interface, ignore_config=True, **options)


def reason(error: BaseException) -> str:
    """Words for an error of python-can: those of the system that are behind it, if there are."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, OSError) and cause.errno:
            return os.strerror(cause.errno)
        cause = cause.__cause__
    return str(error) or type(error).__name__


def _fd_of(bus: "BusABC") -> int | None:
    try:
        fd = bus.fileno()
    except (
        Exception
    ):  # each of python-can's buses says in its own way that it has no file; a thread reads then
        return None
    return fd if fd >= 0 else None


def _is_of_the_system(error: BaseException) -> bool:
    """True if the system is behind an error: the bus itself is gone, and not only a frame wrong."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, OSError) or getattr(cause, "error_code", None):
            return True
        cause = cause.__cause__
    return False


def _has_no_room(error: BaseException) -> bool:
    code = getattr(error, "error_code", None)
    return code in (errno.ENOBUFS, errno.EAGAIN) or "buffer full" in str(error)


def _shut_down(bus: "BusABC") -> None:
    with suppress(Exception):  # an adapter that was unplugged
        bus.shutdown()
    # One whose last command cannot be written keeps its port open.
    with suppress(Exception):
        getattr(bus, "serialPortOrig").close()  # noqa: B009


def _shut_down_late(opened: "asyncio.Future[BusABC]") -> None:
    if not opened.cancelled() and not opened.exception():
        _shut_down(opened.result())
