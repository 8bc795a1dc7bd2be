"""LSS slave: a master finds the node by its identity, and gives it a node id and a bit rate.

Source: CiA 305 version 2.2.0, 4; 4.4 (switch state selective), 4.7 (identification), 4.8 (fastscan).
"""

from collections.abc import Callable, Sequence
from enum import Enum, auto
from functools import partial
from struct import Struct

from bridges.can.canopen.can_ids import NODE_ID_MAX, UNCONFIGURED
from bridges.can.canopen.node.application import PendingWrite, SdoAbort
from bridges.can.canopen.node.timers import Timers
from hil.vocab.time import NS_PER_MS

_ANYBODY = 0x80
_BITS = 32


class AddressMatch:
    """Messages of a series, each with a number to be compared. ``checks``: one for each message."""

    def __init__(self, checks: Sequence[Callable[[int], bool]]) -> None:
        self._checks = checks
        self._next = 0

    def reset(self) -> None:
        self._next = 0

    def match(self, step: int, number: int) -> bool:
        """Match a message; true if it is the last and all have matched, in their order."""
        if step == 0:
            self._next = 0
        is_right = step == self._next and self._checks[step](number)
        self._next = self._next + 1 if is_right else 0
        if self._next == len(self._checks):
            self._next = 0
            return True
        return False


def selection(address: Sequence[int]) -> AddressMatch:
    """Make the match of "switch state selective": all four numbers are those of the address."""
    return AddressMatch([number.__eq__ for number in address])


def identification(address: Sequence[int]) -> AddressMatch:
    """Make the match of "identify remote slave": vendor and product, then ranges of the other two."""
    vendor, product, revision, serial = address
    return AddressMatch(
        [vendor.__eq__, product.__eq__, revision.__ge__, revision.__le__, serial.__ge__, serial.__le__]
    )


class Scanned(Enum):
    """Meaning of a message of fastscan to a slave."""

    OTHER = auto()
    FITS = auto()
    SELECTED = auto()


class FastScan:
    """Search for slaves bit by bit: the master asks, and who fits answers."""

    def __init__(self, address: Sequence[int]) -> None:
        self._address = address
        self._at = 0
        """Number of the address that is compared now, 0 to 3."""

    def reset(self) -> None:
        self._at = 0

    def match(self, number: int, bit: int, at: int, following: int) -> Scanned:
        """Match a message: bits of ``number`` from 31 down to ``bit`` are to be those of the address's number
        ``at``; once bit 0 fits too, ``following`` is the next. If that is an earlier one, the slave is
        selected."""
        if bit == _ANYBODY:
            self._at = 0
            return Scanned.FITS
        if at != self._at or max(at, following) >= len(self._address) or bit >= _BITS:
            return Scanned.OTHER
        if (number ^ self._address[at]) >> bit:
            return Scanned.OTHER
        if bit == 0:
            self._at = following
            if following < at:
                self._at = 0
                return Scanned.SELECTED
        return Scanned.FITS


BIT_RATES = {0: 1_000_000, 1: 800_000, 2: 500_000, 3: 250_000, 4: 125_000, 6: 50_000, 7: 20_000, 8: 10_000}
"""Bits per second by the index of table 0 (table 1 of CiA 305). 5 is reserved, 9 means to find out."""
_SWITCH_GLOBAL, _NODE_ID, _BIT_TIMING, _ACTIVATE, _STORE = 0x04, 0x11, 0x13, 0x15, 0x17
_SELECT_FROM, _SELECTED = 0x40, 0x44
_IDENTIFY_FROM, _IDENTIFIED = 0x46, 0x4F
_IDENTIFY_UNCONFIGURED, _UNCONFIGURED_IDENTIFIED = 0x4C, 0x50
_FAST_SCAN = 0x51
_INQUIRE_FROM, _INQUIRE_NODE_ID = 0x5A, 0x5E
_OK, _REFUSED, _STORE_FAILED = 0, 1, 2
_FRAME_SIZE = 8
_FIELDS, _ANSWER = Struct("<BIBBB"), Struct("<BI3x")


class LssSlave:
    """LSS slave of a node with an ``address``: vendor, product, revision and serial number.

    ``send`` takes eight bytes. ``keep`` stores ``node_id`` and ``bit_rate``, and raises SdoAbort if it cannot
    now. ``on_node_id`` is called when a node without an id has one; ``on_bit_rate`` with a rate when it is
    to be used from now on. ``is_quiet`` is true for the delays before and behind that: the node neither sends
    nor hears.
    """

    def __init__(
        self,
        address: Sequence[int],
        timers: Timers,
        send: Callable[[bytes], None],
        keep: Callable[[int, int], PendingWrite],
        on_node_id: Callable[[int], None],
        on_bit_rate: Callable[[int], None],
    ) -> None:
        self.node_id = UNCONFIGURED
        """Node id from the next "reset communication" on."""
        self.active_node_id = UNCONFIGURED
        self.bit_rate = 0
        """Bits per second from the next "activate" or power-up on."""
        self.is_there = True
        """False of a maker's node without LSS: nobody is heard."""
        self.is_quiet = False
        self._address = address
        self._send = send
        self._keep = keep
        self._on_node_id = on_node_id
        self._on_bit_rate = on_bit_rate
        self._stored: PendingWrite | None = None
        """Store whose end the master is to be told."""
        self._is_configuring = False
        self._selection = selection(address)
        self._identification = identification(address)
        self._fast_scan = FastScan(address)
        self._delay_ns = 0
        self._switch = timers.make(self._use_bit_rate)
        self._resume = timers.make(self._end_quiet)

    def power_up(self, node_id: int, bit_rate: int) -> None:
        """Begin with what was stored."""
        self.node_id, self.bit_rate, self.is_quiet = node_id, bit_rate, False

    def reset(self) -> None:
        """Wait, as after a reset."""
        self._stored = None
        self._is_configuring = False
        self._selection.reset()
        self._identification.reset()
        self._fast_scan.reset()

    def hear(self, data: bytes, now_ns: int) -> None:
        """Take a frame of the master. What is none of LSS gets no answer."""
        if len(data) != _FRAME_SIZE:
            return
        command, number, *rest = _FIELDS.unpack(data)
        if command == _SWITCH_GLOBAL:
            self._switch_global(data[1], now_ns)
        elif _SELECT_FROM <= command < _SELECTED:
            if not self._is_configuring and self._selection.match(command - _SELECT_FROM, number):
                self._is_configuring = True
                self._answer(_SELECTED)
        elif _IDENTIFY_FROM <= command < _IDENTIFY_UNCONFIGURED:
            if self._identification.match(command - _IDENTIFY_FROM, number):
                self._answer(_IDENTIFIED)
        elif command in (_IDENTIFY_UNCONFIGURED, _FAST_SCAN):
            if self.active_node_id == self.node_id == UNCONFIGURED:
                self._find_unconfigured(command, number, *rest)
        elif self._is_configuring:
            self._configure(command, data, now_ns)

    def _switch_global(self, state: int, now_ns: int) -> None:
        if state > 1:
            return
        self._is_configuring = state == 1
        self._selection.reset()
        if not self._is_configuring and self.active_node_id == UNCONFIGURED != self.node_id:
            self._on_node_id(now_ns)

    def _find_unconfigured(self, command: int, number: int, bit: int, at: int, following: int) -> None:
        if command == _IDENTIFY_UNCONFIGURED:
            self._answer(_UNCONFIGURED_IDENTIFIED)
        elif not self._is_configuring:
            scanned = self._fast_scan.match(number, bit, at, following)
            self._is_configuring = scanned is Scanned.SELECTED
            if scanned is not Scanned.OTHER:
                self._answer(_IDENTIFIED)

    def _configure(self, command: int, data: bytes, now_ns: int) -> None:
        """Do what only a slave does that was selected."""
        if command == _NODE_ID:
            is_good = 1 <= data[1] <= NODE_ID_MAX or data[1] == UNCONFIGURED
            self.node_id = data[1] if is_good else self.node_id
            self._answer(command, _OK if is_good else _REFUSED)
        elif command == _BIT_TIMING:
            bit_rate = BIT_RATES.get(data[2]) if data[1] == 0 else None
            self.bit_rate = bit_rate or self.bit_rate
            self._answer(command, _OK if bit_rate else _REFUSED)
        elif command == _ACTIVATE:
            self.is_quiet = True
            self._delay_ns = int.from_bytes(data[1:3], "little") * NS_PER_MS
            self._switch.start(now_ns + self._delay_ns)
        elif command == _STORE:
            self._store()
        elif _INQUIRE_FROM <= command < _INQUIRE_NODE_ID:
            self._answer(command, self._address[command - _INQUIRE_FROM])
        elif command == _INQUIRE_NODE_ID:
            self._answer(command, self.active_node_id)

    def _store(self) -> None:
        """Store the settings. The answer follows when they are stored."""
        try:
            pending = self._keep(self.node_id, self.bit_rate)
        except SdoAbort:
            self._answer(_STORE, _STORE_FAILED)
        else:
            self._stored = pending
            pending.then(partial(self._tell, pending))

    def _tell(self, pending: PendingWrite, code: int, now_ns: int) -> None:
        if self._stored is pending:
            self._stored = None
            self._answer(_STORE, _STORE_FAILED if code else _OK)

    def _answer(self, command: int, number: int = 0) -> None:
        self._send(_ANSWER.pack(command, number))

    def _use_bit_rate(self, now_ns: int) -> None:
        self._on_bit_rate(self.bit_rate)
        self._resume.start(now_ns + self._delay_ns)

    def _end_quiet(self, now_ns: int) -> None:
        self.is_quiet = False
