"""CRC-32 of axes' snapshots, as the input log has it: of their texts, most of whose pieces stay the same."""

import zlib
from collections.abc import Hashable, Mapping, Sequence
from struct import Struct

from hil.core._native import PackedValues
from hil.core.fields import OFFSETS, Snapshot

_LATER = frozenset({"stalls", "stalled_at_ns", "thermal_trips", "too_hot_at_ns", "cooled_at_ns"})
_LATER_OF_SERVOS = _LATER | {"is_too_hot", "junction_degC"}


def left_out(names: Mapping[str, int]) -> frozenset[str]:
    """Fields, of an axis that has these, that logs of before them have not in their checksums. They follow
    from others' courses."""
    return _LATER_OF_SERVOS if "loop_on" in names else _LATER


def snapshot_text(snapshot: Snapshot) -> str:
    """Text of the fields of which the checksum is."""
    without = left_out(snapshot.names)
    shown = (f"{name}={value}" for name, value in snapshot.as_dict().items() if name not in without)
    return f"Snapshot({', '.join(shown)})"


def state_checksum(snapshots: Sequence[Snapshot]) -> int:
    """CRC-32 of the state of a device's axes."""
    return zlib.crc32("".join(map(snapshot_text, snapshots)).encode())


class StateChecksums:
    """Checksums as ``state_checksum`` has them, for many snapshots of the same axes: of a value that is the
    same as in the axis's last snapshot the text is kept."""

    def __init__(self) -> None:
        self._texts: dict[Hashable, _SnapshotText] = {}

    def of(self, device: str, snapshots: Sequence[Snapshot]) -> int:
        """Checksum of the state of a device's axes."""
        checksum = 0
        for number, snapshot in enumerate(snapshots):
            axis = device, number
            kept = self._texts.get(axis)
            # A reload may have put a device with another kind of axis in its place.
            if kept is None or kept.names is not snapshot.names:
                kept = self._texts[axis] = _SnapshotText(snapshot)
            checksum = kept.added_to(checksum, snapshot)
        return checksum


class _SnapshotText:
    """Text of an axis's snapshots, ``snapshot_text``, of one after the other. The first value, the time, is
    always another; of an axis at rest it alone is."""

    def __init__(self, snapshot: Snapshot) -> None:
        self.names: Mapping[str, int] = snapshot.names
        without = left_out(self.names)
        first, *others = (name for name in self.names if name not in without)
        self._head, self._labels = f"Snapshot({first}=", [f", {name}=" for name in others]
        self._first, *rest = (index for name, index in self.names.items() if name not in without)
        self._offset = OFFSETS[first]
        self._order = rest
        types = ["d" if isinstance(value, float) else "q" for value in snapshot.values]
        self._as_bits, self._bits = Struct("<" + "".join(types)), Struct(f"<{len(types)}Q")
        self._last = b""
        self._words: Sequence[int | None] = (None,) * len(types)
        self._pieces = [""] * len(rest)
        self._tail = b""

    def added_to(self, checksum: int, snapshot: Snapshot) -> int:
        """Checksum of what was before and this text."""
        # Bits, not values: -0.0 equals 0.0 and reads otherwise.
        values = snapshot.values
        if isinstance(values, PackedValues):  # as the core has it: mostly nothing has to be unpacked
            packed, at = bytes(values), self._offset
        else:
            packed, at = self._as_bits.pack(*values), self._first * 8
        if (rest := packed[:at] + packed[at + 8 :]) != self._last:
            self._change(values.unpacked() if isinstance(values, PackedValues) else values)
            self._last = rest
        head = f"{self._head}{values[self._first]}"
        return zlib.crc32(self._tail, zlib.crc32(head.encode(), checksum))

    def _change(self, values: Sequence[float]) -> None:
        words, before = self._bits.unpack(self._as_bits.pack(*values)), self._words
        for place, at in enumerate(self._order):
            if words[at] != before[at]:
                self._pieces[place] = f"{self._labels[place]}{values[at]}"
        self._words = words
        self._tail = ("".join(self._pieces) + ")").encode()
