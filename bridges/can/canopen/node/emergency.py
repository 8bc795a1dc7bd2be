"""Emergencies of a node: EMCY (1014h, 1015h), the error register (1001h), and the history (1003h).

Source: CiA 301 version 4.2.0, 7.2.7 and 7.5.2.2 to 7.5.2.18.
"""

from collections import deque
from collections.abc import Callable
from enum import IntEnum
from struct import Struct

from bridges.can.canopen.abort_codes import AbortCode
from bridges.can.canopen.can_ids import INVALID
from bridges.can.canopen.node.application import SdoAbort, Value
from bridges.can.canopen.node.data_types import check_cob_id
from bridges.can.canopen.node.object_dictionary import ObjectDictionary
from bridges.can.canopen.node.timers import Timers

HISTORY = 8
"""Errors that 1003h keeps, unless a maker's file says otherwise."""
COMMUNICATION_BIT, GENERIC_BIT = 0x10, 0x01
_WAITING = 16
"""EMCY that wait for the inhibit time, or for the end of STOPPED. Decision: of more the oldest is lost."""
_FRAME = Struct("<HB5s")
_INHIBIT_UNIT_NS = 100_000


class ErrorCode(IntEnum):
    """Error codes of communication (table 26), and of kept parameters that cannot be read."""

    NONE = 0x0000
    LOST_PARAMETERS = 0x6300
    OVERRUN = 0x8110
    ERROR_PASSIVE = 0x8120
    HEARTBEAT = 0x8130
    RECOVERED_BUS_OFF = 0x8140
    PDO_TOO_SHORT = 0x8210
    PDO_TOO_LONG = 0x8220
    SYNC_LENGTH = 0x8240
    RPDO_TIME_OUT = 0x8250


class Emergencies:
    """Producer of EMCY. ``send`` takes a COB-ID and eight bytes; it is called in ``flush`` and at times of
    ``timers`` only. ``is_silent``: true while the state of the node does not let EMCY out."""

    def __init__(
        self, dictionary: ObjectDictionary, timers: Timers, send: Callable[[int, bytes], None]
    ) -> None:
        self._dictionary = dictionary
        self._send = send
        self.waiting: deque[bytes] = deque(maxlen=_WAITING)
        """Messages that are not sent yet."""
        self._timer = timers.make(self.flush)
        self._history: deque[int] = deque(maxlen=dictionary.count(0x1003))
        self._profile_bits = 0
        self.lasting: set[object] = set()
        self._cob_id = INVALID
        self._inhibit_ns = 0
        self.is_silent = True
        dictionary.own((0x1001, 0x1003, 0x1014, 0x1015), self)

    @property
    def register(self) -> int:
        """Error register, as in 1001h."""
        bits = self._profile_bits | (COMMUNICATION_BIT if self.lasting else 0)
        return bits | GENERIC_BIT if bits else 0

    @property
    def last(self) -> int:
        """Last error code of the history; 0 if there is none."""
        return self._history[0] & 0xFFFF if self._history else 0

    def report(self, code: int, register_bits: int, manufacturer: bytes = b"") -> None:
        """Report an error of the profile, with bits that are set from now on; or, code 0, that it is over."""
        if code:
            self._profile_bits |= register_bits
        else:
            self._profile_bits &= ~register_bits
        self._put(code, manufacturer)

    def begin(self, cause: object, code: ErrorCode, manufacturer: bytes = b"") -> None:
        """Report an error of communication, once until the same cause has ended."""
        if cause not in self.lasting:
            self.lasting.add(cause)
            self._put(code, manufacturer)

    def end(self, cause: object) -> None:
        """End what ``begin`` has begun, if so."""
        if cause in self.lasting:
            self.lasting.remove(cause)
            self._put(ErrorCode.NONE, b"")

    def has(self, cause: object) -> bool:
        """True if what ``begin`` has begun goes on."""
        return cause in self.lasting

    def load(self) -> None:
        """Take the settings from the dictionary, and forget the errors of communication."""
        self._cob_id = self._dictionary.number(0x1014)
        self._inhibit_ns = self._dictionary.number(0x1015) * _INHIBIT_UNIT_NS
        self.lasting.clear()
        self._timer.stop()

    def reset_profile(self) -> None:
        """Forget the errors of the profile, the history, and what waits."""
        self._profile_bits = 0
        self.waiting.clear()
        self._history.clear()

    def flush(self, now_ns: int) -> None:
        """Send what waits, as the inhibit time lets it."""
        while self.waiting and not self.is_silent and not self._timer.is_running:
            data = self.waiting.popleft()
            if not self._cob_id & INVALID:
                self._send(self._cob_id, data)
                if self._inhibit_ns:
                    self._timer.start(now_ns + self._inhibit_ns)

    def _put(self, code: int, manufacturer: bytes) -> None:
        self.waiting.append(_FRAME.pack(code, self.register, manufacturer[:5]))
        if code:
            self._history.appendleft(code | int.from_bytes(manufacturer[:2], "little") << 16)

    # ---- as objects ----

    def read(self, index: int, subindex: int, now_ns: int) -> Value:
        if index == 0x1001:
            return self.register
        if subindex == 0:
            return len(self._history)
        if subindex > len(self._history):
            raise SdoAbort(AbortCode.NO_DATA)
        return self._history[subindex - 1]

    def write(self, index: int, subindex: int, value: Value, now_ns: int) -> None:
        assert isinstance(value, int)
        if index == 0x1003:
            if value:
                raise SdoAbort(AbortCode.VALUE)
            self._history.clear()
        elif index == 0x1014:
            check_cob_id(self._cob_id, value)
            self._cob_id = value
        elif index == 0x1015:
            if not self._cob_id & INVALID:
                raise SdoAbort(AbortCode.NOT_NOW)
            self._inhibit_ns = value * _INHIBIT_UNIT_NS
