"""Parts that receive and transmit PDOs share: the communication parameters, and a mapping.

Source: CiA 301 version 4.2.0, 7.5.2.35 and 7.5.2.37.
"""

from collections.abc import Callable

from hil.canopen.application import SdoAbort, Value
from hil.canopen.can_ids import ID_MASK, INVALID, check_cob_id
from hil.canopen.object_dictionary import ObjectDictionary, SettingsOwner
from hil.canopen.pdo_mapping import PdoMapping
from hil.vocab.time import NS_PER_MS
from hil.wire.canopen.abort_codes import AbortCode

COB_ID, TYPE, INHIBIT, EVENT_TIMER, SYNC_START = 1, 2, 3, 5, 6
SYNC_TYPE_MAX = 240
SYNC_ON_REQUEST, ON_REQUEST, MANUFACTURER_EVENT, PROFILE_EVENT = 252, 253, 254, 255
_EVENT_TYPES = (MANUFACTURER_EVENT, PROFILE_EVENT)


class Pdo(SettingsOwner):
    """Parameters of a PDO, the object ``index``, and its mapping, the object ``index`` + 200h. ``on_change``
    is called with the time when a client has changed the parameters."""

    def __init__(
        self,
        dictionary: ObjectDictionary,
        index: int,
        types: frozenset[int],
        on_change: Callable[["Pdo", int], None],
    ) -> None:
        self.cob_id = INVALID
        self.type = PROFILE_EVENT
        self.event_ns = 0
        self._index = index
        self._types = types
        self._dictionary = dictionary
        self._on_change = on_change
        self.mapping = PdoMapping(dictionary, index + 0x200, self.exists, self.compile)
        dictionary.own((index,), self)

    def exists(self) -> bool:
        return not self.cob_id & INVALID

    @property
    def is_used(self) -> bool:
        """True if it exists and has something mapped."""
        return not self.cob_id & INVALID and self.mapping.size > 0

    @property
    def can_id(self) -> int:
        return self.cob_id & ID_MASK

    @property
    def is_synchronous(self) -> bool:
        return self.type <= SYNC_TYPE_MAX

    @property
    def is_event_driven(self) -> bool:
        return self.type in _EVENT_TYPES

    def load(self) -> None:
        """Take the settings from the dictionary."""
        number = self._dictionary.number
        self.cob_id, self.type = number(self._index, COB_ID), number(self._index, TYPE)
        self.event_ns = number(self._index, EVENT_TIMER) * NS_PER_MS
        self.mapping.load()
        self.compile()

    def compile(self) -> None:
        """Work out what is needed for each PDO."""

    def stop(self) -> None:
        """End, as the state is not OPERATIONAL."""

    def set_more(self, subindex: int, value: int) -> None:
        """Take one of the parameters that not all PDOs have. Raises SdoAbort."""

    def write(self, index: int, subindex: int, value: Value, now_ns: int) -> None:
        assert isinstance(value, int)
        if subindex == COB_ID:
            check_cob_id(self.cob_id, value)
            self.cob_id = value
        elif subindex == TYPE:
            if value not in self._types:
                raise SdoAbort(AbortCode.VALUE, "this transmission type is reserved, or not for this PDO")
            self.type = value
        elif subindex == EVENT_TIMER:
            self.event_ns = value * NS_PER_MS
        else:
            self.set_more(subindex, value)
        self._on_change(self, now_ns)
