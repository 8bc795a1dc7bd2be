"""Clients of a pty: counted by inotify's events, and checked where those may be wrong."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from virtual_ports.pty import terminal_settings
from virtual_ports.pty.inotify import ClientWatch
from virtual_ports.pty.pair import PtyPair

if TYPE_CHECKING:
    import asyncio

_AUDIT_AFTER_S = 0.02
_AUDIT_AGAIN_S = 0.2


class Clients:
    """Clients of a pty. ``came`` is called for each that opens; ``left(baud)`` when the last one has closed,
    with its baud, after the line was cleared of what it left. Both perhaps in the middle of a call.

    When two clients open or close within the same microsecond the kernel can merge the two (see
    ``inotify.py``): one ``came`` is missing then, and ``count`` is wrong until a byte or a close that does
    not fit makes ``_audit`` look, 20 ms later.

    Raises:
        OSError: no inotify instance or watch is left for this user.
    """

    def __init__(
        self,
        pair: PtyPair,
        loop: "asyncio.AbstractEventLoop",
        came: Callable[[], None],
        left: Callable[[int | None], None],
    ) -> None:
        self.count = 0
        self._pair = pair
        self._loop = loop
        self._came = came
        self._left = left
        self._baud_of_departed: int | None = None
        self._own_steps: list[int] = []
        self._audit_twice = False
        self._audit_timer: asyncio.TimerHandle | None = None
        self._is_closed = False
        self._watch = ClientWatch(pair.pts, self._changed)

    def notice(self) -> None:
        """Count clients that have come and gone until now."""
        if not self._is_closed:
            self._watch.drain()

    def doubt(self) -> None:
        """Look soon whether the count is right."""
        self._audit_in(_AUDIT_AFTER_S)

    def baud(self) -> int | None:
        """Baud of the client, or of the last one while bytes of it wait to be read."""
        return terminal_settings.baud(self._pair.master) if self.count else self._baud_of_departed

    def input_was_read(self) -> None:
        """Forget the baud of one that has left with its last byte."""
        if self._baud_of_departed is not None and not self._is_closed and not self._pair.has_input():
            self._baud_of_departed = None

    def _changed(self, steps: list[int], events_lost: bool) -> None:
        for own in self._own_steps:
            if own in steps:
                steps.remove(own)
        emptied, doubtful = False, events_lost
        for step in steps:
            if step > 0:
                self.count += 1
                self._came()
                continue
            # A client that was never seen to come, or one of several, another of which may have left unseen.
            doubtful |= self.count != 1
            self.count = max(self.count - 1, 0)
            emptied |= self.count == 0
        if emptied:
            self._last_left()
        with self._pair.failing_loudly():
            if -1 in steps and not emptied:
                # Nobody can tell whose stop it is, and it would hold up those who stay.
                terminal_settings.end_stop(self._pair.slave)
            terminal_settings.baud(self._pair.slave)  # after a hang-up nothing else would tell
        if doubtful:
            self.doubt()

    def _last_left(self) -> None:
        # A next client may be there already, but all that was written so far was for those before it.
        baud = None
        with self._pair.failing_loudly():
            # Also if the next is there: it would be held up forever.
            terminal_settings.let_go_on(self._pair.slave)
            terminal_settings.discard_unread(self._pair.slave)
            baud = terminal_settings.baud(self._pair.master)
        self._left(baud)
        self._reset_line()

    def _reset_line(self) -> None:
        if self.count or self._pair.is_dead or self._is_closed:
            return
        with self._pair.failing_loudly():
            if self._pair.has_input():
                self._baud_of_departed = terminal_settings.baud(self._pair.master) or self._baud_of_departed
            if self._watch.pending():  # perhaps the next client, whose settings must stay
                self._loop.call_soon(self._reset_line_later)
                return
            self._pair.rest()

    def _reset_line_later(self) -> None:
        self.notice()
        self._reset_line()

    def _audit_in(self, delay_s: float) -> None:
        if self._audit_timer is None:
            self._audit_timer = self._loop.call_later(delay_s, self._audit)
        else:
            self._audit_twice = True  # the one that is due may come too soon after this event

    def _audit(self) -> None:
        """Put a count right that merged or lost events have left wrong.

        Not done without a reason: our own slave has to go for a moment, and its coming back could be merged
        with the coming of a client.
        """
        self._audit_timer = None
        if self._pair.is_dead:
            return
        if self._audit_twice:
            self._audit_twice = False
            self.doubt()
        self.notice()
        nobody = False
        with self._pair.failing_loudly():
            # Exclusive since the last client left: somebody is there.
            if not terminal_settings.is_exclusive(self._pair.slave):
                self._own_steps = [-1, 1]
                nobody = self._pair.is_unused()
        if nobody and self.count:
            self.count = 0
            self._last_left()
        self.notice()
        self._own_steps = []
        if not nobody and not self.count and not self._pair.is_dead:
            self.count = 1
            self._audit_in(_AUDIT_AGAIN_S)  # it may have been a client in the middle of its close

    def close(self) -> None:
        """Tell nothing more. Call it once."""
        self._is_closed = True
        if self._audit_timer is not None:
            self._audit_timer.cancel()
        self._watch.close()
