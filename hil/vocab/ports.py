"""Contract between a port and the rest of the daemon.

A port is where bytes enter: a pty, a tcp listener. It moves bytes and counts them; it knows no device and no
simulated time. Everything here runs on the daemon's event loop, in its thread.
"""

from collections.abc import Callable
from enum import IntEnum, StrEnum
from pathlib import Path
from typing import Protocol, runtime_checkable

from hil.vocab.late_dataclass import dataclass
from hil.vocab.line_format import LineFormat

TOUCH_BAUD = 1200
"""Rate of the touch: a board with native USB resets when its port is closed at it. Arduino platform
specification, "1200 bps bootloader reset"; CDC.cpp of the Arduino SAMD core. The core waits ``TOUCH_S``
before, and the bootloader runs first."""
TOUCH_S = 0.25
"""Time between the touch and the reset: ``initiateReset(250)``, CDC.cpp of the Arduino SAMD core."""
Tap = Callable[[str, bytes], None]
"""Called with what passes at a port: the direction, "board" or "client", and the bytes."""


@dataclass(frozen=True)
class UsbIdentity:
    """Identity of what is on the USB for a board: its own processor, or an adapter in front of its UART."""

    vendor_id: int
    product_id: int
    manufacturer: str
    product: str
    is_native: bool
    """True if the board's own processor is on the USB: it comes and goes with the board's power, and sends
    only while the host has DTR or RTS on."""
    release_bcd: int = 0x0100
    """Release of the device, in decimal digits of four bits."""


ADAPTER = UsbIdentity(0x0525, 0xA4A7, "hil", "Serial adapter (virtual)", is_native=False)
"""Identity of a board whose profile says none: that of Linux's own serial gadget with a CDC-ACM function,
drivers/usb/gadget/legacy/serial.c."""


@dataclass(frozen=True)
class PortContext:
    """Surroundings of a port. ``device``: its address, as ``m1`` or ``s1.network``."""

    bench: str
    device: str
    runtime_dir: Path
    """The bench's own runtime directory; stable names (symlinks) live here."""
    group: str | None = None
    """Group of what a port shows to other users, unless its own options name one."""
    usb: UsbIdentity = ADAPTER
    """Identity of the board on a USB."""


class EchoState(StrEnum):
    """Knowledge of a line's adapter: whether what is sent there comes back."""

    UNKNOWN = "unknown yet"
    YES = "yes"
    NO = "no"
    UNSOUGHT = "not looked for"
    """Nobody knows what is an answer there: a terminal may echo what is typed."""


@dataclass(frozen=True)
class EchoStats:
    """Echo of a line's adapter. ``collisions``: number of times that what was sent came back damaged."""

    state: EchoState
    dropped_bytes: int = 0
    collisions: int = 0

    def as_dict(self) -> dict[str, str | int]:
        """The same for JSON."""
        return {"state": str(self.state), "bytes": self.dropped_bytes, "collisions": self.collisions}


class Sole(IntEnum):
    """Knowledge of bytes that go out on a line: whether another station may send the same soon."""

    UNSURE = 0
    """One may, as an answer that equals its question."""
    HERE = 1
    """None may answer with them, but one may ask with them: an answer given here that equals its question."""
    ALONE = 2
    """None does."""


SoleOf = Callable[[bytes], Sole | None]
"""Says it of bytes that go out; None: something is missing at their end, or they are nothing known."""


@dataclass(frozen=True)
class PortStats:
    """Counters since the port was opened; exact."""

    clients: int
    """Clients that have the port open now."""
    connects: int
    """Clients that ever opened it."""
    rx_bytes: int
    """Bytes that came from clients and were handed to the device."""
    tx_bytes: int
    """Bytes that were handed to the operating system for clients."""
    dropped_bytes: int
    """Bytes of the device that no client got, because one that has the port open does not read."""
    unheard_bytes: int
    """Bytes of the device that were dropped because nobody had the port open."""
    turned_away: int = 0
    """Clients for which there was no place, and times that no place could be made."""
    away: str | None = None
    """Reason why nobody is there, in the system's words, for a port that is a client itself."""
    echo: EchoStats | None = None
    """Echo of its adapter, for a port that has one."""


class PortHost(Protocol):
    """Interface that a port calls: the link between it and its device."""

    def received(self, data: bytes) -> None:
        """Take bytes from a client, in order, as they came. Never more than ``room()``."""

    def room(self) -> int:
        """Number of bytes that the device can take now. At 0 the port stops reading its clients until
        ``Port.resume_reading``, so that a client is held up as a USB host is, and nothing is lost."""

    def drained(self) -> None:
        """Note that what waited for a slow client has gone: ``Port.backlog`` is 0 again."""

    def client_left(self, baud: int | None) -> None:
        """Note that the last client has closed the port; ``baud`` as ``Port.client_baud`` said before that.
        Ports whose clients have no baud need not tell."""

    def port_failed(self, reason: str) -> None:
        """Note that the port cannot go on (its file descriptor is dead). Called once."""


@runtime_checkable
class LineHost(Protocol):
    """Host that hears when its line is opened. Beside ``PortHost``."""

    def line_opened(self) -> None:
        """Note that a first client has opened the port, or that clients' DTR has come on: a board whose RESET
        hangs on it is reset. It comes before the bytes that are sent after it."""


class Port(Protocol):
    """Door for bytes, made by the ``make`` function of ``virtual_ports/<kind>/port.py``."""

    @property
    def address(self) -> str:
        """Address that a user types: a path, or a ``socket://`` URL. Valid after ``open``."""

    async def open(self, host: PortHost) -> None:
        """Make the port reachable. Raises PortError: it cannot be opened, with what to do about it."""

    def write(self, data: bytes) -> None:
        """Send bytes of the device, due now. Never blocks; what does not fit is counted as dropped."""

    def resume_reading(self) -> None:
        """Read clients again: the device has room."""

    def backlog(self) -> int:
        """Number of bytes of the device that wait for a client to read. The device is held up by it, as a
        board is whose host does not read; only past the port's own limit are bytes dropped."""

    def client_baud(self) -> int | None:
        """Baud that a client has set, or None where that means nothing or none was chosen."""

    def stats(self) -> PortStats:
        """Counters now."""

    async def close(self) -> None:
        """Close, and leave nothing behind: no file descriptor, symlink or task. Safe to call twice."""


@runtime_checkable
class PowerPort(Protocol):
    """Port that is a part of the board, and gone while the board has no power. Beside ``Port``."""

    def power(self, is_on: bool) -> None:
        """Note the board's power; safe to call twice. A reset is off and on."""


@runtime_checkable
class FormatPort(Protocol):
    """Port whose clients choose the format of their characters. Beside ``Port``."""

    def client_format(self) -> LineFormat:
        """Format that a client has set."""

    def tell_errors(self, *, framing: bool, parity: bool) -> None:
        """Tell clients that the last bytes came with these errors."""


@runtime_checkable
class EchoPort(Protocol):
    """Port at an adapter that may echo what it sends. Beside ``Port``."""

    def tell_sole(self, sole: SoleOf, *, in_pieces: bool) -> None:
        """Look for an echo by what says whether others may send the same bytes. ``in_pieces``: what
        belongs together is written in pieces."""


class PortError(Exception):
    """Error of a port that could not be opened: ``str(error)`` says why, and the remedy, in one line.
    ``option``: the one of its options that is in the way; without one the text says which port it is."""

    def __init__(self, why: str, option: str = "") -> None:
        super().__init__(why)
        self.option = option
