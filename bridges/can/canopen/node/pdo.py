"""Parts that receive and transmit PDOs share: the communication parameters, and a mapping: which entries the
bytes are, and the procedure by which a client changes that.

Source: CiA 301 version 4.2.0, 7.5.2.35 to 7.5.2.38.
"""

from collections.abc import Callable, Sequence
from struct import Struct

from bridges.can.canopen.abort_codes import AbortCode
from bridges.can.canopen.can_ids import ID_MASK, INVALID
from bridges.can.canopen.node.application import Access, DataType, Entry, SdoAbort, Value
from bridges.can.canopen.node.communication_entries import mapping_value
from bridges.can.canopen.node.data_types import STRUCTS, check_cob_id, size_of
from bridges.can.canopen.node.object_dictionary import ObjectDictionary, SettingsOwner
from bridges.can.frames.can_frame import DATA_MAX
from hil.vocab.time import NS_PER_MS

_RPDO, _TPDO = "rpdo", "tpdo"
DUMMIES = (
    DataType.INTEGER8,
    DataType.INTEGER16,
    DataType.INTEGER32,
    DataType.UNSIGNED8,
    DataType.UNSIGNED16,
    DataType.UNSIGNED32,
)
"""Types that an RPDO may have in place of an entry: their bytes are not used."""
_DUMMY_VALUES = {type_ << 16 | 8 * size_of(type_): size_of(type_) for type_ in DUMMIES}


class PdoMapping(SettingsOwner):
    """Mapping of one PDO, the object ``index``. ``is_in_use`` says whether the PDO exists: then the mapping
    cannot change. ``on_change`` is called when it has."""

    def __init__(
        self,
        dictionary: ObjectDictionary,
        index: int,
        is_in_use: Callable[[], bool],
        on_change: Callable[[], None],
    ) -> None:
        self.index = index
        self.entries: Sequence[Entry] = ()
        """Entries whose values are in the PDO, dummies left out."""
        self.layout = Struct("<")
        self._dictionary = dictionary
        self._is_in_use = is_in_use
        self._on_change = on_change
        self._is_tpdo = index >= 0x1A00
        dictionary.own((index,), self)

    @property
    def size(self) -> int:
        """Number of bytes; 0 while nothing is mapped."""
        return self.layout.size

    def load(self) -> None:
        """Take the mapping from the dictionary. One that cannot be is none: what was kept may be older than
        the dictionary."""
        try:
            self._compile(self._dictionary.number(self.index))
        except SdoAbort:
            self._dictionary.values[self.index << 8] = 0
            self._compile(0)

    def write(self, index: int, subindex: int, value: Value, now_ns: int) -> None:
        assert isinstance(value, int)
        if self._is_in_use():
            raise SdoAbort(AbortCode.NOT_NOW, "the PDO exists: set bit 31 of its COB-ID first")
        if subindex == 0:
            self._compile(value)
            self._on_change()
            return
        if self._dictionary.number(self.index):
            raise SdoAbort(AbortCode.NOT_NOW, "the mapping is in force: write 0 to its sub-index 0 first")
        if value:
            self._resolve(value)

    def _compile(self, count: int) -> None:
        form, entries = "<", []
        if count > self._dictionary.count(self.index):
            raise SdoAbort(AbortCode.PDO_LENGTH, "the mapping has no place for so many")
        for at in range(count):
            value = self._dictionary.number(self.index, 1 + at)
            entry = self._resolve(value)
            if entry is None:
                form += f"{_DUMMY_VALUES[value]}x"
            else:
                entries.append(entry)
                form += STRUCTS[entry.data_type].format[1:]
        layout = Struct(form)
        if layout.size > DATA_MAX:
            raise SdoAbort(AbortCode.PDO_LENGTH)
        self.layout, self.entries = layout, tuple(entries)

    def _resolve(self, value: int) -> Entry | None:
        """Find what a value of the mapping means; None for a dummy. Raises SdoAbort."""
        if not self._is_tpdo and value in _DUMMY_VALUES:
            return None
        entry = self._dictionary.find(value >> 16, value >> 8 & 0xFF)
        way = _TPDO if self._is_tpdo else _RPDO
        forbidden = (Access.WO,) if self._is_tpdo else (Access.RO, Access.CONST)
        if entry.mapping not in (way, "both") or entry.access in forbidden:
            raise SdoAbort(AbortCode.NOT_MAPPABLE)
        if value != mapping_value(entry) or entry.data_type not in STRUCTS:
            raise SdoAbort(AbortCode.NOT_MAPPABLE, "the length in bits is not that of the object")
        return entry


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
