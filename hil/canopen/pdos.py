"""The PDOs of a node, and what they do in the order of the protocol."""

from collections.abc import Callable, Iterator

from hil.canopen.communication_entries import PDOS
from hil.canopen.emergency import Emergencies
from hil.canopen.object_dictionary import ObjectDictionary
from hil.canopen.pdo import Pdo
from hil.canopen.rpdo import Rpdo
from hil.canopen.sync import Sync
from hil.canopen.timers import Timers
from hil.canopen.tpdo import Tpdo

Handler = Callable[[bytes, int], None]
"""What takes the bytes of a frame, and the time."""


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
        numbers = range(1, PDOS + 1)
        self._dictionary = dictionary
        self._on_new_ids = on_new_ids
        self._rpdos = [
            Rpdo(number, dictionary, timers, emergencies, sync.is_open, self._change) for number in numbers
        ]
        self._tpdos = [Tpdo(number, dictionary, timers, send, self._change) for number in numbers]
        self._active: list[Tpdo] = []
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
        for rpdo in self._rpdos:
            rpdo.synced(now_ns)

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
        if self._is_operational and isinstance(pdo, Tpdo):
            self._start(pdo, now_ns)
        self._on_new_ids()

    def _start(self, tpdo: Tpdo, now_ns: int) -> None:
        self._active = [each for each in self._tpdos if each.is_used]
        tpdo.start(now_ns, counts=self._dictionary.number(0x1019) != 0)
