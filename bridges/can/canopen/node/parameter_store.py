"""Store of a node without power: parameters (1010h, 1011h), and its node id and bit rate (LSS).

A section is ``COP1``, the CRC-32 of what follows, node id (one byte), bit rate (four), and for each kept
value its index (two), sub-index (one), length (two) and bytes; all little-endian.

Source: CiA 301 version 4.2.0, 7.5.2.13 and 7.5.2.14; the section is ours.
"""

import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from struct import Struct
from zlib import crc32

from bridges.can.canopen.abort_codes import AbortCode
from bridges.can.canopen.can_ids import NODE_ID_MAX, UNCONFIGURED
from bridges.can.canopen.node.application import PendingWrite, SdoAbort, Value
from bridges.can.canopen.node.data_types import longest, pack, size_of
from bridges.can.canopen.node.object_dictionary import ObjectDictionary, key_of

_MAGIC = b"COP1"
_CRC, _LSS, _VALUE = Struct("<I"), Struct("<BI"), Struct("<HBH")
Keep = Callable[[bytes, Callable[[bool, int], None]], None]
"""Stores a section. Its second argument is called once, at once or later, with whether the section is
durable, and the time."""
_SAVE, _LOAD = (int.from_bytes(word, "little") for word in (b"save", b"load"))
_ON_COMMAND = 1
"""Value of 1010h and 1011h: it is done when the word is written, and not otherwise."""
_GROUPS = {
    1: range(0x1000, 0x10000),
    2: range(0x1000, 0x2000),
    3: range(0x6000, 0xA000),
    4: range(0x2000, 0x6000),
}
"""Indexes that a sub-index of 1010h and 1011h is for."""
_OTHER = _GROUPS[4]
"""Indexes of those sub-indices that a maker defines."""


@dataclass
class KeptSection:
    """Content of a section. ``node_id`` and ``bit_rate`` are what LSS has stored, 0 if nothing; ``values``
    the bytes of those that differ from their defaults, by keys."""

    node_id: int = 0
    bit_rate: int = 0
    values: dict[int, bytes] = field(default_factory=dict)

    def encode(self) -> bytes:
        parts = [_LSS.pack(self.node_id, self.bit_rate)]
        for key, data in sorted(self.values.items()):
            parts += (_VALUE.pack(key >> 8, key & 0xFF, len(data)), data)
        body = b"".join(parts)
        return _MAGIC + _CRC.pack(crc32(body)) + body


def decode(section: bytes) -> KeptSection:
    """Decode a section. Raises ValueError: it is none, or damaged."""
    body = section[len(_MAGIC) + _CRC.size :]
    try:
        (crc,) = _CRC.unpack_from(section, len(_MAGIC))
        if not section.startswith(_MAGIC) or crc != crc32(body):
            raise ValueError("the CRC is wrong")
        kept = KeptSection(*_LSS.unpack_from(body))
        at = _LSS.size
        while at < len(body):
            index, subindex, length = _VALUE.unpack_from(body, at)
            at += _VALUE.size
            kept.values[key_of(index, subindex)] = body[at : at + length]
            at += length
    except struct.error:
        raise ValueError("it ends early") from None
    if not (kept.node_id <= NODE_ID_MAX or kept.node_id == UNCONFIGURED):
        raise ValueError(f"node id {kept.node_id}")
    return kept


class ParameterStore:
    """Objects 1010h and 1011h. ``section`` is what is kept now, nothing at first; ``keep`` is called to store
    another, one at a time."""

    def __init__(self, dictionary: ObjectDictionary, section: bytes, keep: Keep) -> None:
        self.kept = KeptSection()
        self.is_damaged = False
        """True if the section cannot be read: then nothing is kept."""
        try:
            self.kept = decode(section) if section else self.kept
        except ValueError:
            self.is_damaged = True
        self.node_id = 0
        """Node id in use: some defaults follow from it."""
        self.is_storing = False
        """True while it is not known whether a section is durable: ``kept`` is the one before."""
        self.on_stored: Callable[[int], None] = lambda now_ns: None
        """Called when ``is_storing`` has ended, with the time."""
        self._dictionary = dictionary
        self._keep = keep
        dictionary.own((0x1010, 0x1011), self)

    def values(self) -> dict[int, bytes]:
        """List the kept values that the dictionary can have: a section may be older than it is."""
        return {
            key: data
            for key, data in self.kept.values.items()
            if (entry := self._dictionary.entries.get(key)) is not None
            and entry.is_stored
            and size_of(entry.data_type) <= len(data) <= longest(entry)
        }

    def keep_lss(self, node_id: int, bit_rate: int) -> PendingWrite:
        """Keep the settings of LSS. Raises SdoAbort: another section is being stored."""
        return self._store(KeptSection(node_id, bit_rate, self.kept.values))

    def read(self, index: int, subindex: int, now_ns: int) -> Value:
        told = self._dictionary.values[key_of(index, subindex)]
        return told if isinstance(told, bytes) else told or _ON_COMMAND

    def write(self, index: int, subindex: int, value: Value, now_ns: int) -> PendingWrite:
        word = _SAVE if index == 0x1010 else _LOAD
        if value not in (word, word.to_bytes(4, "little")):
            raise SdoAbort(AbortCode.NOT_STORED, "this is not the word that is asked for")
        group = _GROUPS.get(subindex, _OTHER)
        values = {key: data for key, data in self.kept.values.items() if key >> 8 not in group}
        if word == _SAVE:
            for entry in self._dictionary.entries.values():
                if entry.is_stored and entry.index in group:
                    value = self._dictionary.read(entry, now_ns)
                    if value != self._dictionary.default_of(entry, self.node_id):
                        values[key_of(entry.index, entry.subindex)] = pack(entry.data_type, value)
        return self._store(KeptSection(self.kept.node_id, self.kept.bit_rate, values))

    def _store(self, kept: KeptSection) -> PendingWrite:
        if self.is_storing:
            raise SdoAbort(AbortCode.NOT_NOW, "the memory is being written")
        self.is_storing = True
        pending = PendingWrite()
        self._keep(kept.encode(), partial(self._stored, kept, pending))
        return pending

    def _stored(self, kept: KeptSection, pending: PendingWrite, durable: bool, now_ns: int) -> None:
        self.is_storing = False
        if durable:
            self.kept = kept
        pending.end(0 if durable else AbortCode.HARDWARE, now_ns)
        self.on_stored(now_ns)
