"""Receive PDO: bytes of a frame become values of entries.

Source: CiA 301 version 4.2.0, 7.2.2.
"""

from collections.abc import Callable

from hil.canopen.application import SdoAbort, Value
from hil.canopen.emergency import Emergencies, ErrorCode
from hil.canopen.object_dictionary import ObjectDictionary, key_of
from hil.canopen.pdo import MANUFACTURER_EVENT, PROFILE_EVENT, SYNC_TYPE_MAX, Pdo
from hil.canopen.timers import Timers

_TYPES = frozenset((*range(SYNC_TYPE_MAX + 1), MANUFACTURER_EVENT, PROFILE_EVENT))
_INFINITE = float("inf")


_Target = tuple[int, int, int, Callable[[int, int, Value, int], object]]
"""Entry that is written: its key, index and sub-index, and by what."""


class Rpdo(Pdo):
    """Receive PDO ``number``, 1 to 4. ``is_open`` says whether synchronous ones are taken at a time."""

    def __init__(
        self,
        number: int,
        dictionary: ObjectDictionary,
        timers: Timers,
        emergencies: Emergencies,
        is_open: Callable[[int], bool],
        on_change: Callable[[Pdo, int], None],
    ) -> None:
        super().__init__(dictionary, 0x1400 + number - 1, _TYPES, on_change)
        self._emergencies = emergencies
        self._is_open = is_open
        self._number = bytes((number,))
        self._causes = ("RPDO length", number), ("RPDO time-out", number)
        self._timer = timers.make(self._miss)
        self._held: bytes | None = None
        self._targets: tuple[_Target, ...] = ()
        self._limits: tuple[tuple[float, float], ...] = ()
        """Lowest and highest value of each target; nothing if there are none."""

    def compile(self) -> None:
        entries = self.mapping.entries
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
        self._held = None
        self._timer.stop()
        for cause in self._causes:
            self._emergencies.end(cause)

    def hear(self, data: bytes, now_ns: int) -> None:
        """Take a frame."""
        size = self.mapping.size
        if len(data) != size:
            if len(data) < size:
                self._emergencies.begin(self._causes[0], ErrorCode.PDO_TOO_SHORT, self._number)
                return
            self._emergencies.begin(self._causes[0], ErrorCode.PDO_TOO_LONG, self._number)
            data = data[:size]
        else:
            self._emergencies.end(self._causes[0])
        if self.event_ns:
            self._timer.start(now_ns + self.event_ns)
            self._emergencies.end(self._causes[1])
        if self.type > SYNC_TYPE_MAX:
            self._take(data, now_ns)
        elif self._is_open(now_ns):
            self._held = data

    def synced(self, now_ns: int) -> None:
        """Take what was received since the last SYNC, if it is synchronous."""
        if self._held is not None:
            data, self._held = self._held, None
            self._take(data, now_ns)

    def _take(self, data: bytes, now_ns: int) -> None:
        """Take all values, then tell the application of each: it sees them together."""
        found = self.mapping.layout.unpack(data)
        targets = self._targets
        if self._limits:
            taken = [low <= value <= high for (low, high), value in zip(self._limits, found, strict=True)]
            if not all(taken):
                targets = tuple(target for target, is_taken in zip(targets, taken, strict=True) if is_taken)
                found = tuple(value for value, is_taken in zip(found, taken, strict=True) if is_taken)
        values = self._dictionary.values
        former = [values[target[0]] for target in targets]
        for target, value in zip(targets, found, strict=True):
            values[target[0]] = value
        for at, (key, index, subindex, write) in enumerate(targets):
            try:
                write(index, subindex, found[at], now_ns)
            except SdoAbort:
                values[key] = former[at]

    def _miss(self, now_ns: int) -> None:
        self._emergencies.begin(self._causes[1], ErrorCode.RPDO_TIME_OUT, self._number)
