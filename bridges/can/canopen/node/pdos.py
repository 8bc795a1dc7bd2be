"""PDOs of a node: receive PDOs, whose bytes become values of entries; transmit PDOs, whose bytes are values
at their time; and what all of them do in the order of the protocol.

Source: CiA 301 version 4.2.0, 7.2.2 and 7.5.2.37.
"""

from collections.abc import Callable, Iterator
from typing import Any

from bridges.can.canopen.abort_codes import AbortCode
from bridges.can.canopen.can_ids import ID_MASK, NO_RTR
from bridges.can.canopen.node.application import SdoAbort, Value
from bridges.can.canopen.node.emergency import Emergencies, ErrorCode
from bridges.can.canopen.node.object_dictionary import ObjectDictionary, key_of
from bridges.can.canopen.node.pdo import (
    INHIBIT,
    MANUFACTURER_EVENT,
    PROFILE_EVENT,
    SYNC_ON_REQUEST,
    SYNC_START,
    SYNC_TYPE_MAX,
    Pdo,
)
from bridges.can.canopen.node.sync import Sync
from bridges.can.canopen.node.timers import Timers

_RECEIVED_TYPES = frozenset((*range(SYNC_TYPE_MAX + 1), MANUFACTURER_EVENT, PROFILE_EVENT))
_INFINITE = float("inf")


RPDOS, TPDOS = range(0x1400, 0x1600), range(0x1800, 0x1A00)
"""Objects with the parameters of PDOs, each of which has its mapping 200h above."""
_Target = tuple[int, int, int, Callable[[int, int, Value, int], object]]
"""Entry that is written: its key, index and sub-index, and by what."""


class Rpdo(Pdo):
    """Receive PDO ``number``, 1 to 512. ``is_open`` says whether synchronous ones are taken at a time."""

    def __init__(
        self,
        number: int,
        dictionary: ObjectDictionary,
        timers: Timers,
        emergencies: Emergencies,
        is_open: Callable[[int], bool],
        on_change: Callable[[Pdo, int], None],
    ) -> None:
        super().__init__(dictionary, 0x1400 + number - 1, _RECEIVED_TYPES, on_change)
        self._emergencies = emergencies
        self._is_open = is_open
        self._number = bytes((number & 0xFF,))
        self._causes = ("RPDO length", number), ("RPDO time-out", number)
        self._timer = timers.make(self._miss)
        self.held: bytes | None = None
        self._targets: tuple[_Target, ...] = ()
        self._size, self._unpack = self.mapping.layout.size, self.mapping.layout.unpack
        self._limits: tuple[tuple[float, float], ...] = ()
        """Lowest and highest value of each target; nothing if there are none."""

    def compile(self) -> None:
        entries = self.mapping.entries
        self.held = None  # its bytes are those of another mapping
        self._size, self._unpack = self.mapping.layout.size, self.mapping.layout.unpack
        targets = []
        for entry in entries:
            owner = self._dictionary.owner_of(entry.index)
            assert owner, "a service of the node would not be mapped"
            key = key_of(entry.index, entry.subindex)
            targets.append((key, entry.index, entry.subindex, owner.write))
        self._targets = tuple(targets)
        limits = [
            (-_INFINITE if each.low is None else each.low, _INFINITE if each.high is None else each.high)
            for each in entries
        ]
        self._limits = () if all(each == (-_INFINITE, _INFINITE) for each in limits) else tuple(limits)

    def stop(self) -> None:
        """Forget what was received, as the state is not OPERATIONAL."""
        self.held = None
        self._timer.stop()
        for cause in self._causes:
            self._emergencies.end(cause)

    def hear(self, data: bytes, now_ns: int) -> None:
        """Take a frame."""
        size = self._size
        if len(data) != size:
            if len(data) < size:
                self._emergencies.begin(self._causes[0], ErrorCode.PDO_TOO_SHORT, self._number)
                return
            self._emergencies.begin(self._causes[0], ErrorCode.PDO_TOO_LONG, self._number)
            data = data[:size]
        elif self._emergencies.lasting:
            self._emergencies.end(self._causes[0])
        if self.event_ns:
            self._timer.start(now_ns + self.event_ns)
            self._emergencies.end(self._causes[1])
        if self.type > SYNC_TYPE_MAX:
            self.deliver(data, now_ns)
        elif self._is_open(now_ns):
            self.held = data

    def deliver(self, data: bytes, now_ns: int) -> None:
        """Put in all values of a frame, then tell the application of each: it sees them together."""
        found = self._unpack(data)
        targets = self._targets
        if self._limits:
            taken = [low <= value <= high for (low, high), value in zip(self._limits, found, strict=True)]
            if not all(taken):
                targets = tuple(target for target, is_taken in zip(targets, taken, strict=True) if is_taken)
                found = tuple(value for value, is_taken in zip(found, taken, strict=True) if is_taken)
        values, former = self._dictionary.values, []
        for target, value in zip(targets, found, strict=True):
            key = target[0]
            former.append(values[key])
            values[key] = value
        for at, (key, index, subindex, write) in enumerate(targets):
            try:
                write(index, subindex, found[at], now_ns)
            except SdoAbort:
                values[key] = former[at]

    def _miss(self, now_ns: int) -> None:
        self._emergencies.begin(self._causes[1], ErrorCode.RPDO_TIME_OUT, self._number)


_SENT_TYPES = frozenset((*range(SYNC_TYPE_MAX + 1), *range(SYNC_ON_REQUEST, PROFILE_EVENT + 1)))
_INHIBIT_UNIT_NS = 100_000
_Read = Callable[[int, int, int], Value]


class Tpdo(Pdo):
    """Transmit PDO ``number``, 1 to 512. ``send`` takes an identifier and bytes."""

    def __init__(
        self,
        number: int,
        dictionary: ObjectDictionary,
        timers: Timers,
        send: Callable[[int, bytes], None],
        on_change: Callable[[Pdo, int], None],
    ) -> None:
        super().__init__(dictionary, 0x1800 + number - 1, _SENT_TYPES, on_change)
        self._sources: tuple[tuple[_Read | None, int, int, int], ...] = ()
        """Entries in their order: how it is read if it is live, its key, index and sub-index."""
        self._pack_values = self.mapping.layout.pack
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
        self._sources, self._pack_values = tuple(sources), self.mapping.layout.pack
        self.keys = frozenset(key for _, key, _, _ in sources)

    def set_more(self, subindex: int, value: int) -> None:
        if self.exists():
            raise SdoAbort(AbortCode.NOT_NOW, "the PDO exists: set bit 31 of its COB-ID first")
        if subindex == INHIBIT:
            self._inhibit_ns = value * _INHIBIT_UNIT_NS
        elif subindex == SYNC_START:
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
        self._send(self.cob_id & ID_MASK, data)

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
        return self._pack_values(*found)


Handler = Callable[[bytes, int], None]
"""Taker of a frame's bytes, with the time."""


class Pdos:
    """Receive and transmit PDOs. ``send`` takes an identifier and bytes; ``on_new_ids`` is called when other
    frames than before are to be heard."""

    def __init__(
        self,
        dictionary: ObjectDictionary,
        timers: Timers,
        emergencies: Emergencies,
        sync: Sync,
        send: Callable[[int, bytes], None],
        on_new_ids: Callable[[], None],
    ) -> None:
        self._dictionary = dictionary
        self._on_new_ids = on_new_ids
        self._rpdos = [
            Rpdo(index - 0x13FF, dictionary, timers, emergencies, sync.is_open, self._change)
            for index, _ in dictionary.objects()
            if index in RPDOS
        ]
        self._tpdos = [
            Tpdo(index - 0x17FF, dictionary, timers, send, self._change)
            for index, _ in dictionary.objects()
            if index in TPDOS
        ]
        self._active: list[Tpdo] = []
        self._receiving: list[Rpdo] = []
        """RPDOs that are used, or hold what came while they were."""
        self._is_operational = False
        self.has_events = False
        """True if ``flush`` has something to do."""

    def load(self) -> None:
        """Take the settings from the dictionary."""
        for pdo in (*self._rpdos, *self._tpdos):
            pdo.load()

    def enter(self, now_ns: int) -> None:
        """Begin, as the state is OPERATIONAL. Event-driven TPDOs are sent once."""
        self._is_operational = True
        self._note_receiving()
        for tpdo in self._tpdos:
            self._start(tpdo, now_ns)
        for tpdo in self._active:
            tpdo.has_event = self.has_events = True

    def leave(self) -> None:
        """End, as the state is another."""
        self._is_operational = self.has_events = False
        self._active = []
        for pdo in (*self._rpdos, *self._tpdos):
            pdo.stop()

    def take_held(self, now_ns: int) -> None:
        """Take the synchronous RPDOs, as SYNC has come."""
        for rpdo in self._receiving:
            data, rpdo.held = rpdo.held, None
            if data is not None:
                rpdo.deliver(data, now_ns)

    def sample(self, counter: int, now_ns: int) -> None:
        """Send the synchronous TPDOs, as SYNC has come."""
        for tpdo in self._active:
            tpdo.synced(counter, now_ns)

    def note_change(self, key: int) -> None:
        """Note that an entry has another value, as the application says."""
        for tpdo in self._active:
            if key in tpdo.keys:
                tpdo.has_event = self.has_events = True

    def flush(self, now_ns: int) -> None:
        """Send the event-driven TPDOs that have something new."""
        self.has_events = False
        for tpdo in self._active:
            if tpdo.has_event:
                tpdo.tell(now_ns)

    def routes(self) -> Iterator[tuple[int, Handler]]:
        """Go through the identifiers of data frames that are wanted, and who takes them."""
        for rpdo in self._rpdos:
            if rpdo.is_used:
                yield rpdo.can_id, rpdo.hear

    def remote_routes(self) -> Iterator[tuple[int, Handler]]:
        """Go through the identifiers of remote frames that are answered."""
        for tpdo in self._active:
            if tpdo.is_answering:
                yield tpdo.can_id, tpdo.hear_request

    def _change(self, pdo: Pdo, now_ns: int) -> None:
        """Do what follows from other parameters of a PDO."""
        if isinstance(pdo, Rpdo):
            self._note_receiving()
        elif self._is_operational and isinstance(pdo, Tpdo):
            self._start(pdo, now_ns)
        self._on_new_ids()

    def _note_receiving(self) -> None:
        self._receiving = [each for each in self._rpdos if each.is_used or each.held is not None]

    def _start(self, tpdo: Tpdo, now_ns: int) -> None:
        self._active = [each for each in self._tpdos if each.is_used]
        tpdo.start(now_ns, counts=self._dictionary.number(0x1019) != 0)
