"""CRC-32 of axes' snapshots, as the input log has it: of their texts, most of whose pieces stay the same."""

import zlib
from collections.abc import Hashable, Mapping, Sequence
from itertools import compress
from operator import itemgetter, ne
from struct import Struct

from hil.core.fields import Snapshot


def state_checksum(snapshots: Sequence[Snapshot]) -> int:
    """CRC-32 of the state of a device's axes."""
    return zlib.crc32("".join(map(repr, snapshots)).encode())


class StateChecksums:
    """Checksums as ``state_checksum`` has them, for many snapshots of the same axes: of a value that is the
    same as in the axis's last snapshot the text is kept."""

    def __init__(self) -> None:
        self._texts: dict[Hashable, _SnapshotText] = {}

    def of(self, device: str, snapshots: Sequence[Snapshot]) -> int:
        """Checksum of the state of a device's axes."""
        return zlib.crc32("".join([self._text((device, n), s) for n, s in enumerate(snapshots)]).encode())

    def _text(self, axis: Hashable, snapshot: Snapshot) -> str:
        kept = self._texts.get(axis)
        # A reload may have put a device with another kind of axis in its place.
        if kept is None or kept.names is not snapshot.names:
            kept = self._texts[axis] = _SnapshotText(snapshot)
        return kept.of(snapshot)


class _SnapshotText:
    """Text of an axis's snapshots, as ``repr`` makes it, of one after the other."""

    def __init__(self, snapshot: Snapshot) -> None:
        self.names: Mapping[str, int] = snapshot.names
        self._labels = [f"{name}=" for name in self.names]
        indices = list(self.names.values())
        self._choose = itemgetter(*indices, indices[0])  # of one alone it would be no tuple
        types = ["d" if isinstance(value, float) else "q" for value in self._choose(snapshot.values)]
        self._as_bits = Struct("<" + "".join(types))
        self._bits = Struct(f"<{len(types)}Q")
        self._places = range(len(self._labels))
        self._last: Sequence[int | None] = (None,) * len(types)
        self._pieces = [""] * len(self._labels)

    def of(self, snapshot: Snapshot) -> str:
        values = self._choose(snapshot.values)
        # Bits, not values: -0.0 equals 0.0 and reads otherwise.
        bits = self._bits.unpack(self._as_bits.pack(*values))
        for at in compress(self._places, map(ne, bits, self._last)):
            self._pieces[at] = f"{self._labels[at]}{values[at]}"
        self._last = bits
        return f"Snapshot({', '.join(self._pieces)})"
