"""A bus of python-can: ``virtual``, which this process has, or ``socketcan``, which Linux has.

Where a bus has a file descriptor the event loop waits for it, and else a thread.
"""

import asyncio
import errno
import logging
import threading
from collections import deque
from typing import Any

from bridges.can.channels.channel_medium import AT_A_TIME, Take, frame_of, message_of
from bridges.can.channels.channel_options import LOAD_CAN, NO_CAN
from bridges.can.frames.can_frame import CanFrame
from hil.vocab.bridge_protocol import BridgeError

_END_LOOK_S = 0.1
"""Time between two looks of the thread at whether it has to end."""
_NAP_S = 0.001
_MOST_HELD = 4096
"""Messages of the thread that wait for the event loop."""

log = logging.getLogger("hil")


class PythonCanMedium:
    """Bus of an interface, by the name of its channel. A ``bridges.can.channels.channel_medium.Medium``."""

    def __init__(self, interface: str, channel: str) -> None:
        self._interface, self._channel = interface, channel
        self.rejected = self.strangers = 0
        self.failure = ""
        self._bus: Any = None
        self._take: Take = lambda frames: None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._descriptor = -1
        self._thread: threading.Thread | None = None
        self._may_read, self._is_closing = threading.Event(), threading.Event()
        self._came: deque[Any] = deque()
        self._lock = threading.Lock()
        self._is_draining = False
        """True if the event loop will take what has come; with the lock."""

    def open(self, loop: asyncio.AbstractEventLoop, take: Take) -> None:
        import can

        self._loop, self._take = loop, take
        more: Any = {"preserve_timestamps": True} if self._interface == "virtual" else {}
        try:
            self._bus = can.Bus(self._channel, self._interface, ignore_config=True, **more)
        except (can.CanError, OSError) as error:
            cause = getattr(error, "strerror", None) or str(error)
            is_unknown = getattr(error, "errno", 0) == errno.EAFNOSUPPORT
            said = f"{NO_CAN}; {LOAD_CAN}" if is_unknown else cause
            raise BridgeError(f"{self._interface} {self._channel}: {said}") from None
        try:
            self._descriptor = self._bus.fileno()
        except NotImplementedError:
            self._thread = threading.Thread(target=self._wait, name="hil-can", daemon=True)
            self._thread.start()
        self.hold(False)

    def hold(self, is_held: bool) -> None:
        if is_held:
            self._may_read.clear()
        else:
            self._may_read.set()
            if self._thread and self._loop:
                self._loop.call_soon(self._drain)
        if self._loop and self._descriptor >= 0:
            if is_held:
                self._loop.remove_reader(self._descriptor)
            else:
                self._loop.add_reader(self._descriptor, self._read)

    def send(self, frame: CanFrame, at_s: float) -> bool:
        from can import CanError

        try:
            self._bus.send(message_of(frame, at_s), timeout=0)
        except (CanError, OSError):
            return False
        return True

    async def close(self) -> None:
        self._is_closing.set()
        self._may_read.set()
        if self._loop and self._descriptor >= 0:
            self._loop.remove_reader(self._descriptor)
        if self._thread:
            await asyncio.to_thread(self._thread.join)
        if self._bus:
            self._bus.shutdown()
        self._bus, self._descriptor, self._thread = None, -1, None

    # ---- the event loop ----

    def _read(self) -> None:
        messages: list[Any] = []
        try:
            while len(messages) < AT_A_TIME and (message := self._bus.recv(0)):
                messages.append(message)
        except Exception as error:  # an interface that was taken down, and what else python-can raises
            self._fail(error)
        self._took(messages)

    def _took(self, messages: list[Any]) -> None:
        frames = [frame for frame in map(frame_of, messages) if frame]
        self.rejected += len(messages) - len(frames)
        if frames:
            self._take(frames)

    def _drain(self) -> None:
        """Take what the thread has heard, in pieces, so that others have their turns."""
        if self._is_closing.is_set() or not self._may_read.is_set():
            with self._lock:
                self._is_draining = False
            return
        messages: list[Any] = []
        with self._lock:
            while self._came and len(messages) < AT_A_TIME:
                messages.append(self._came.popleft())
            self._is_draining = bool(self._came)
        if self._is_draining and self._loop:
            self._loop.call_soon(self._drain)
        self._took(messages)

    def _fail(self, error: Exception) -> None:
        self.failure = str(error)
        log.error("can: %s %s: %s; nothing comes from it any more", self._interface, self._channel, error)
        self.hold(True)

    # ---- the thread ----

    def _wait(self) -> None:
        assert self._loop
        while not self._is_closing.is_set():
            self._may_read.wait()
            try:
                message = self._bus.recv(_END_LOOK_S)
            except Exception as error:  # whatever python-can raises
                self._loop.call_soon_threadsafe(self._fail, error)
                return
            if message:
                self._note(message)
            while len(self._came) >= _MOST_HELD and not self._is_closing.wait(_NAP_S):
                pass

    def _note(self, message: Any) -> None:
        with self._lock:
            self._came.append(message)
            is_draining, self._is_draining = self._is_draining, True
        if not is_draining and self._loop:
            self._loop.call_soon_threadsafe(self._drain)
