"""SYNC: its consumer with counter and window, and its producer (1005h, 1006h, 1007h, 1019h).

Source: CiA 301 version 4.2.0, 7.2.5 and 7.5.2.5 to 7.5.2.7, 7.5.2.22.
"""

from collections.abc import Callable

from bridges.can.canopen.abort_codes import AbortCode
from bridges.can.canopen.can_ids import ID_MASK
from bridges.can.canopen.node.application import SdoAbort, Value
from bridges.can.canopen.node.data_types import check_id
from bridges.can.canopen.node.emergency import Emergencies, ErrorCode
from bridges.can.canopen.node.object_dictionary import ObjectDictionary, SettingsOwner
from bridges.can.canopen.node.timers import Timers

_PRODUCES = 1 << 30
_US_NS = 1000
_OVERFLOW_MAX = 240
_LEAST_PERIOD_US = 100
"""Decision: at 1 Mbit/s SYNC alone takes half of it."""


class Sync(SettingsOwner):
    """SYNC of a node. ``send`` takes an identifier and bytes. ``synced`` is called with the counter, 0 where
    there is none, and the time, for each SYNC that comes or is sent; ``on_new_id`` when its identifier is
    another."""

    def __init__(
        self,
        dictionary: ObjectDictionary,
        timers: Timers,
        emergencies: Emergencies,
        send: Callable[[int, bytes], None],
        synced: Callable[[int, int], None],
        on_new_id: Callable[[], None],
    ) -> None:
        self._dictionary = dictionary
        self._emergencies = emergencies
        self._send = send
        self._synced = synced
        self._timer = timers.make(self._produce)
        self._cob_id = self._period_ns = self._window_ns = self._overflow = self._counter = 0
        self._is_running = False
        self._last_ns: int | None = None
        self._on_new_id = on_new_id
        dictionary.own((0x1005, 0x1006, 0x1007, 0x1019), self)

    @property
    def can_id(self) -> int:
        """Identifier under which SYNC is heard, or sent."""
        return self._cob_id & ID_MASK

    def load(self) -> None:
        """Take the settings from the dictionary."""
        number = self._dictionary.number
        self._cob_id = number(0x1005)
        self._period_ns, self._window_ns = number(0x1006) * _US_NS, number(0x1007) * _US_NS
        self._overflow = number(0x1019)

    def start(self, now_ns: int) -> None:
        """Begin, as the state is PRE-OPERATIONAL or OPERATIONAL."""
        if not self._is_running:
            self._is_running = True
            self._counter = 0
            self._restart(now_ns)

    def stop(self) -> None:
        """End, as the state is another."""
        self._is_running = False
        self._last_ns = None
        self._timer.stop()

    def hear(self, data: bytes, now_ns: int) -> None:
        """Take a SYNC of another node."""
        if len(data) != (1 if self._overflow else 0):
            self._emergencies.begin("sync", ErrorCode.SYNC_LENGTH, bytes((len(data),)))
            return
        if self._emergencies.lasting:
            self._emergencies.end("sync")
        self._last_ns = now_ns
        self._synced(data[0] if data else 0, now_ns)

    def is_open(self, now_ns: int) -> bool:
        """True if synchronous RPDOs are taken: the window (1007h) behind the last SYNC has not ended."""
        if not self._window_ns or self._last_ns is None:
            return True
        return now_ns - self._last_ns <= self._window_ns

    def _restart(self, now_ns: int) -> None:
        if self._is_running and self._cob_id & _PRODUCES and self._period_ns:
            self._timer.start(now_ns + self._period_ns)
        else:
            self._timer.stop()

    def _produce(self, now_ns: int) -> None:
        self._timer.start(now_ns + self._period_ns)
        if self._overflow:
            self._counter = self._counter % self._overflow + 1
        self._send(self.can_id, bytes((self._counter,)) if self._overflow else b"")
        self._last_ns = now_ns
        self._synced(self._counter if self._overflow else 0, now_ns)

    # ---- as objects ----

    def write(self, index: int, subindex: int, value: Value, now_ns: int) -> None:
        assert isinstance(value, int)
        if index == 0x1005:
            check_id(value & ~_PRODUCES & ~(1 << 31))
            if value & self._cob_id & _PRODUCES and (value ^ self._cob_id) & ID_MASK:
                raise SdoAbort(AbortCode.NOT_NOW, "the node produces SYNC: clear bit 30 first")
            self._cob_id = value
            self._counter = 0
            self._on_new_id()
        elif index == 0x1006:
            if 0 < value < _LEAST_PERIOD_US:
                raise SdoAbort(AbortCode.TOO_LOW, f"SYNC comes every {_LEAST_PERIOD_US} us at most")
            self._period_ns = value * _US_NS
        elif index == 0x1007:
            self._window_ns = value * _US_NS
        else:
            if self._period_ns:
                raise SdoAbort(AbortCode.NOT_NOW, "1006h is not 0")
            if value == 1 or value > _OVERFLOW_MAX:
                raise SdoAbort(AbortCode.VALUE)
            self._overflow = value
        if index in (0x1005, 0x1006):
            self._restart(now_ns)
