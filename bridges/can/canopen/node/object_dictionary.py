"""Object dictionary of a node: entries, their values, and who is told of them."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from typing import Protocol

from bridges.can.canopen.abort_codes import AbortCode
from bridges.can.canopen.node.application import Access, Entry, PendingWrite, SdoAbort, Value
from bridges.can.canopen.node.data_types import check_length, check_limits, pack, unpack

_WRITABLE = (Access.RW, Access.WO)


class ObjectOwner(Protocol):
    """Owner of objects: a service of the node, or the application."""

    def read(self, index: int, subindex: int, now_ns: int) -> Value:
        """Read an entry that is live. Raises SdoAbort."""

    def write(self, index: int, subindex: int, value: Value, now_ns: int) -> PendingWrite | None:
        """Take a value, which the dictionary has already. Raises SdoAbort: it gets the former one back.
        Returns what tells how it ends if that takes time; only of an entry that is live."""


class SettingsOwner:
    """Owner of settings: none of its entries is live."""

    def read(self, index: int, subindex: int, now_ns: int) -> Value:
        raise AssertionError(f"{index:04X}h:{subindex} is not live")


def key_of(index: int, subindex: int) -> int:
    """Key of an entry: its index and sub-index as one number."""
    return index << 8 | subindex


class ObjectDictionary:
    """Entries with their values, in the order of their keys. ``names``: of objects that have sub-indices.

    Raises:
        ValueError: a default value is not of its type.
    """

    def __init__(self, entries: Iterable[Entry], names: Mapping[int, str], profile: ObjectOwner) -> None:
        self.names = names
        self._all = {
            key_of(each.index, each.subindex): each
            for each in sorted(entries, key=lambda each: (each.index, each.subindex))
        }
        self.entries = {key: each for key, each in self._all.items() if not each.is_hidden}
        """Objects that clients see."""
        self._counts = Counter(key >> 8 for key in self._all if key & 0xFF)
        self.values: dict[int, Value] = {}
        self._by_index: dict[int, list[Entry]] = defaultdict(list)
        for entry in self.entries.values():
            pack(entry.data_type, entry.default)
            self._by_index[entry.index].append(entry)
        self._profile = profile
        self._owners: dict[int, ObjectOwner] = {}

    def own(self, indexes: Iterable[int], owner: ObjectOwner) -> None:
        """Give objects below 2000h to a service of the node; the others are the profile's."""
        self._owners |= dict.fromkeys(indexes, owner)

    def owner_of(self, index: int) -> ObjectOwner | None:
        """Owner that is told of an object; None for those below 2000h that no service has."""
        return self._profile if index >= 0x2000 else self._owners.get(index)

    def objects(self) -> Iterator[tuple[int, list[Entry]]]:
        """Go through the indexes with their entries."""
        yield from self._by_index.items()

    def count(self, index: int) -> int:
        """Count the sub-indices of an object above 0, hidden ones too."""
        return self._counts[index]

    def find(self, index: int, subindex: int) -> Entry:
        """Find an entry. Raises SdoAbort."""
        entry = self.entries.get(index << 8 | subindex)
        if entry is None:
            raise SdoAbort(AbortCode.NO_SUBINDEX if index in self._by_index else AbortCode.NO_OBJECT)
        return entry

    def find_writable(self, index: int, subindex: int) -> Entry:
        """Find an entry that clients may write. Raises SdoAbort."""
        entry = self.find(index, subindex)
        if entry.access not in _WRITABLE:
            raise SdoAbort(AbortCode.READ_ONLY)
        return entry

    def read(self, entry: Entry, now_ns: int) -> Value:
        """Read what an entry is now. Raises SdoAbort."""
        owner = self.owner_of(entry.index) if entry.is_live else None
        if owner is None:
            return self.values[key_of(entry.index, entry.subindex)]
        return owner.read(entry.index, entry.subindex, now_ns)

    def upload(self, index: int, subindex: int, now_ns: int) -> bytes:
        """Read an entry for a client. Raises SdoAbort."""
        entry = self.find(index, subindex)
        if entry.access is Access.WO:
            raise SdoAbort(AbortCode.WRITE_ONLY)
        return pack(entry.data_type, self.read(entry, now_ns))

    def download(self, entry: Entry, data: bytes, now_ns: int) -> PendingWrite | None:
        """Write what a client sends, as ``write``. Raises SdoAbort: nothing was written."""
        check_length(entry, len(data))
        value = unpack(entry.data_type, data)
        check_limits(entry, value)
        return self.write(entry, value, now_ns)

    def write(self, entry: Entry, value: Value, now_ns: int) -> PendingWrite | None:
        """Write a checked value and tell its owner, whose answer it returns. Raises SdoAbort: nothing was
        written."""
        key = key_of(entry.index, entry.subindex)
        former = self.values[key]
        self.values[key] = value
        owner = self.owner_of(entry.index)
        if owner is None:
            return None
        try:
            return owner.write(entry.index, entry.subindex, value, now_ns)
        except SdoAbort:
            self.values[key] = former
            raise

    def number(self, index: int, subindex: int = 0) -> int:
        """Tell the value of an entry of an integer type that is not live."""
        value = self.values[key_of(index, subindex)]
        assert isinstance(value, int)
        return value

    def default_of(self, entry: Entry, node_id: int) -> Value:
        """Tell the value of an entry that nothing has changed."""
        if entry.adds_node_id and not isinstance(entry.default, bytes):
            return entry.default + node_id
        return entry.default

    def reset(self, node_id: int, kept: Mapping[int, bytes], *, profile_too: bool) -> None:
        """Set all values as they are at power-on: ``kept`` by keys, or the defaults. Without ``profile_too``
        only the objects below 2000h."""
        for key, entry in self._all.items():
            if not profile_too and entry.index >= 0x2000:
                continue
            if key in kept:
                self.values[key] = unpack(entry.data_type, kept[key])
            else:
                self.values[key] = self.default_of(entry, node_id)
