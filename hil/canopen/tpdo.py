"""Transmit PDO: values of entries become the bytes of a frame, at their time.

Source: CiA 301 version 4.2.0, 7.2.2 and 7.5.2.37.
"""

from collections.abc import Callable
from typing import Any

from hil.canopen.application import SdoAbort, Value
from hil.canopen.can_ids import NO_RTR
from hil.canopen.object_dictionary import ObjectDictionary, key_of
from hil.canopen.pdo import (
    INHIBIT,
    PROFILE_EVENT,
    SYNC_ON_REQUEST,
    SYNC_START,
    SYNC_TYPE_MAX,
    Pdo,
)
from hil.canopen.timers import Timers
from hil.wire.canopen.abort_codes import AbortCode

_TYPES = frozenset((*range(SYNC_TYPE_MAX + 1), *range(SYNC_ON_REQUEST, PROFILE_EVENT + 1)))
_INHIBIT_UNIT_NS = 100_000
_Read = Callable[[int, int, int], Value]


class Tpdo(Pdo):
    """Transmit PDO ``number``, 1 to 4. ``send`` takes an identifier and bytes."""

    def __init__(
        self,
        number: int,
        dictionary: ObjectDictionary,
        timers: Timers,
        send: Callable[[int, bytes], None],
        on_change: Callable[[Pdo, int], None],
    ) -> None:
        super().__init__(dictionary, 0x1800 + number - 1, _TYPES, on_change)
        self._sources: tuple[tuple[_Read | None, int, int, int], ...] = ()
        """Entries in their order: how it is read if it is live, its key, index and sub-index."""
        self.keys: frozenset[int] = frozenset()
        self.has_event = False
        """True if something has changed since it was sent."""
        self._send = send
        self._event_timer = timers.make(self.tell)
        self._inhibit_timer = timers.make(self._end_inhibit)
        self._inhibit_ns = self._sync_start = 0
        self._count = 0
        """Number of SYNC up to the next PDO; 0: the SYNC with the start value is awaited."""
        self._sample: bytes | None = None

    @property
    def is_answering(self) -> bool:
        """True if it is sent on request."""
        return not self.cob_id & NO_RTR

    def load(self) -> None:
        number = self._dictionary.number
        self._inhibit_ns = number(self._index, INHIBIT) * _INHIBIT_UNIT_NS
        self._sync_start = number(self._index, SYNC_START)
        super().load()

    def compile(self) -> None:
        sources = []
        for entry in self.mapping.entries:
            owner = self._dictionary.owner_of(entry.index) if entry.is_live else None
            key = key_of(entry.index, entry.subindex)
            sources.append((owner.read if owner else None, key, entry.index, entry.subindex))
        self._sources = tuple(sources)
        self.keys = frozenset(key for _, key, _, _ in sources)

    def set_more(self, subindex: int, value: int) -> None:
        if self.exists():
            raise SdoAbort(AbortCode.NOT_NOW, "the PDO exists: set bit 31 of its COB-ID first")
        if subindex == INHIBIT:
            self._inhibit_ns = value * _INHIBIT_UNIT_NS
        else:
            self._sync_start = value

    def start(self, now_ns: int, *, counts: bool) -> None:
        """Begin again: the state is OPERATIONAL, or something was set. ``counts``: SYNC has a counter."""
        self.stop()
        if self.is_used:
            self._count = 0 if counts and self._sync_start else max(self.type, 1)
            self._restart_event_timer(now_ns)

    def stop(self) -> None:
        self.has_event = False
        self._sample = None
        self._event_timer.stop()
        self._inhibit_timer.stop()

    def synced(self, counter: int, now_ns: int) -> None:
        """Do what is due at a SYNC."""
        if self.type > SYNC_TYPE_MAX:
            if self.type == SYNC_ON_REQUEST:
                self._sample = self._pack(now_ns)
            return
        if self._count == 0:
            if counter not in (0, self._sync_start):  # 0: there is no counter any more
                return
            self._count = 1
        if self.type == 0:
            if self.has_event:
                self._put(self._pack(now_ns))
            return
        self._count -= 1
        if self._count == 0:
            self._count = self.type
            self._put(self._pack(now_ns))

    def hear_request(self, _: bytes, now_ns: int) -> None:
        """Answer a remote frame."""
        if self.type == SYNC_ON_REQUEST:
            if self._sample is not None:
                self._put(self._sample)
        else:
            self._put(self._pack(now_ns))

    def tell(self, now_ns: int) -> None:
        """Send it if it is event-driven, now or as soon as the inhibit time lets it."""
        if not self.is_event_driven:
            return
        if self._inhibit_timer.is_running:
            self.has_event = True
            return
        self._put(self._pack(now_ns))
        self._restart_event_timer(now_ns)
        if self._inhibit_ns:
            self._inhibit_timer.start(now_ns + self._inhibit_ns)

    def _end_inhibit(self, now_ns: int) -> None:
        if self.has_event:
            self.tell(now_ns)

    def _restart_event_timer(self, now_ns: int) -> None:
        if self.event_ns and self.is_event_driven:
            self._event_timer.start(now_ns + self.event_ns)

    def _put(self, data: bytes) -> None:
        self.has_event = False
        self._send(self.can_id, data)

    def _pack(self, now_ns: int) -> bytes:
        values = self._dictionary.values
        found: list[Any] = []
        for read, key, index, subindex in self._sources:
            if read is None:
                found.append(values[key])
                continue
            try:
                found.append(read(index, subindex, now_ns))
            except SdoAbort:  # what was read last is what the PDO has
                found.append(values[key])
        return self.mapping.layout.pack(*found)
