"""Joins a port to what is behind it: here a byte changes hands. ``docs/follow-a-byte.md`` walks this file.

In:  port -> ``PortLink.received`` -> the backend: a twin's UART, a tap of a segment, a real board's line.
Out: the backend -> ``PortLink.send`` -> port.
"""

from typing import Generic, Protocol, TypeVar

from hil.net.line_openings import tell_opened
from hil.vocab.line_format import LineFormat
from hil.vocab.ports import FormatPort, Port, Tap

BACKLOG_HOLD_BYTES = 64 * 1024
"""Maximum that waits for a client to read before a twin takes no more commands: a board is held up in print()
by a host that does not read. As much waits on each way to a real board."""


class Backend(Protocol):
    """Backend of a port: what takes its clients' bytes, and sends them answers."""

    def room(self) -> int:
        """Number of bytes of clients that can be taken now."""

    def hold(self, is_held: bool) -> None:
        """Hold clients' bytes from now on, or no more; the backend calls ``refresh`` when there is room."""

    def feed(self, data: bytes) -> None:
        """Take bytes of clients, never more than ``room()``."""

    def refresh(self) -> None:
        """Go on: clients have read what waited for them."""

    def client_left(self, baud: int | None) -> None:
        """Note that the last client has closed the port, at this baud."""

    def leave(self) -> None:
        """Let go of the link, which is another's now: what has not reached the port is lost."""


BackendKind = TypeVar("BackendKind", bound=Backend)


class PortLink(Generic[BackendKind]):
    """Link of a port and what is behind it: the port's host (``hil.vocab.ports.PortHost``). ``label``: the
    place's name, as ``s1.network``. Vacant until ``occupy``: clients can connect, and what they send waits.
    """

    def __init__(self, label: str, port: Port) -> None:
        self.label = label
        self.port = port
        self.failure: str | None = None
        """Reason why the port cannot go on."""
        self.listeners: list[Tap] = []
        """Called with all that passes at the port: the direction, and the bytes."""
        self.listeners_beside: list[Tap] = []
        """Called with what verbs type at the board beside its port."""
        self._formatted = port if isinstance(port, FormatPort) else None
        self.is_held = False
        """True while the port is kept from reading because the end has no room."""
        self.is_shut = False
        """True while what clients send is not delivered: the bench is leased."""
        self.undelivered_bytes = 0
        """Number of bytes that were not delivered since it was shut."""
        self._backend: BackendKind | None = None

    @property
    def backend(self) -> BackendKind:
        """Backend of the port. Not for a vacant link."""
        assert self._backend is not None, f"{self.label} is vacant"
        return self._backend

    def occupy(self, backend: BackendKind) -> None:
        """Put this behind the port from now on."""
        # Nothing behind a port means no room: it was not read.
        self._backend = backend
        self.is_held = False
        self.port.resume_reading()

    def vacate(self) -> None:
        """Leave nothing behind the port: clients are held up."""
        if self._backend:
            self._backend.leave()
            self._backend = None

    # ---- PortHost ----

    def room(self) -> int:
        if self._backend is None:
            return 0
        room = self._backend.room()
        if self.is_held and room:
            self.is_held = False
            self._backend.hold(False)
            self.port.resume_reading()
        elif not self.is_held and not room:
            self.is_held = True
            self._backend.hold(True)
            room = self._backend.room()  # room may have come meanwhile, of which the port was told
        return room

    def received(self, data: bytes) -> None:
        """Take bytes from a client: they take effect now."""
        if self.is_shut:
            self.undelivered_bytes += len(data)
            return
        assert self._backend is not None  # who has no backend has no room, and nothing was read
        self._backend.feed(data)

    def drained(self) -> None:
        if self._backend:
            self._backend.refresh()

    def client_left(self, baud: int | None) -> None:
        if self._backend and not self.is_shut:
            self._backend.client_left(baud)

    def line_opened(self) -> None:
        """Let the backend know, if it is one that hears of that (``LineHost``)."""
        if not self.is_shut:
            tell_opened(self._backend)

    def port_failed(self, reason: str) -> None:
        self.failure = reason

    # ---- for the backend ----

    def client_format(self) -> LineFormat | None:
        """Format in which clients send and read characters; None: the port does not say."""
        return self._formatted.client_format() if self._formatted else None

    def refresh(self) -> None:
        """Let the port read on if it was held up and there is room again."""
        if self.is_held:
            self.room()

    def tell(self, towards: str, data: bytes) -> None:
        for listener in self.listeners:
            listener(towards, data)

    def tell_errors(self, *, framing: bool, parity: bool) -> None:
        """Tell clients of errors in what they get."""
        if self._formatted:
            self._formatted.tell_errors(framing=framing, parity=parity)

    def send(self, data: bytes) -> None:
        """Send bytes to clients, due now."""
        self.port.write(data)
        for listener in self.listeners:
            listener("client", data)
