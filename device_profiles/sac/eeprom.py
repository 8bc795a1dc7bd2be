"""EEPROM of the SAC: parameters, driver pin maps and the saved queue, as 1024 bytes; loaded and saved."""

import struct
import zlib
from collections.abc import Callable, Mapping
from dataclasses import astuple, dataclass, field, replace

from device_profiles.sac.parameters import Parameters
from device_profiles.sac.terminal import Steps
from hil.vocab.firmware import Commit
from hil.vocab.motion import QUEUE_LEN, MotionEntry

SIZE = 1024
MAGIC, VERSION = b"SAC", 1
MEMORY, ASIDE = "eeprom", "eeprom_damaged"
"""Sections: the EEPROM, and the bytes that could not be read as one."""

_PARAMETERS = struct.Struct("<13B H 2I 4i 4B 2I B 8B")
_ENTRY = struct.Struct("<4I 2i 2? B 2?")
_FIELDS = (
    *("steps", "rpm", "cycle_us", "wait_us", "acc_hundredths", "dec_hundredths"),
    *("is_ccw", "is_linear", "extra_pulses", "is_sync", "is_pulses"),
)
"""Fields of an entry, in the memory's order."""
_HEAD = struct.Struct("<3sBI")


class EepromError(Exception):
    """Error of bytes that are no EEPROM of a version that is known here."""


@dataclass
class Eeprom:
    parameters: Parameters = field(default_factory=Parameters)
    queue: list[MotionEntry] | None = None
    """Entries 1 to 30 of the queue as ``qs`` saved them; None: never."""

    def packed(self) -> bytes:
        """Pack the memory's 1024 bytes; free ones are 0xFF, as an EEPROM has them."""
        values = astuple(self.parameters)
        body = _PARAMETERS.pack(*values[:-1], *values[-1]) + bytes([self.queue is not None])
        for e in self.queue or []:
            body += _ENTRY.pack(*(getattr(e, name) for name in _FIELDS))
        return (_HEAD.pack(MAGIC, VERSION, zlib.crc32(body)) + body).ljust(SIZE, b"\xff")

    @classmethod
    def unpacked(cls, data: bytes) -> "Eeprom":
        """Unpack the memory's bytes.

        Raises:
            EepromError: damaged, or of another version.
        """
        if len(data) != SIZE:
            raise EepromError(f"{len(data)} bytes instead of {SIZE}")
        magic, version, checksum = _HEAD.unpack_from(data)
        if magic != MAGIC or version != VERSION:
            raise EepromError("no EEPROM of this version")
        start = _HEAD.size + _PARAMETERS.size
        has_queue = data[start] == 1
        end = start + 1 + has_queue * QUEUE_LEN * _ENTRY.size
        if zlib.crc32(data[_HEAD.size : end]) != checksum:
            raise EepromError("the checksum is wrong")
        values = _PARAMETERS.unpack_from(data, _HEAD.size)
        parameters = Parameters(*values[:-8])
        parameters.pin_map = list(values[-8:])
        eeprom = cls(parameters)
        if has_queue:
            rows = (_ENTRY.unpack_from(data, start + 1 + i * _ENTRY.size) for i in range(QUEUE_LEN))
            eeprom.queue = [MotionEntry(**dict(zip(_FIELDS, row, strict=True))) for row in rows]
        return eeprom

    def copy(self) -> "Eeprom":
        """Copy the EEPROM deeply."""
        queue = list(self.queue) if self.queue else None
        return Eeprom(replace(self.parameters, pin_map=list(self.parameters.pin_map)), queue)


class Memory:
    """EEPROM of the board. ``eeprom``: its content as commands see it; ``note`` tells what was damaged."""

    def __init__(self, nvm: Mapping[str, bytes], note: Callable[[str, str | None], None]) -> None:
        self._nvm = nvm
        self._note = note
        self.eeprom = Eeprom()

    def load(self) -> Steps:
        """Read the EEPROM; keep one that cannot be read aside, and take the factory's settings."""
        stored = self._nvm.get(MEMORY)
        if stored is None:
            return
        try:
            self.eeprom = Eeprom.unpacked(stored)
        except EepromError as error:
            aside = next(name for n in range(1, 1000) if (name := f"{ASIDE}-{n}") not in self._nvm)
            self._note("eeprom", f"EEPROM: {error}; it was kept as {aside}, the factory's settings hold")
            if (yield Commit(aside, stored)):
                yield from self.save()

    def save(self) -> Steps:
        """Make the EEPROM durable. Where that fails the old content is what a read-back shows."""
        if not (yield Commit(MEMORY, self.eeprom.packed())):
            stored = self._nvm.get(MEMORY)
            self.eeprom = Eeprom.unpacked(stored) if stored else Eeprom()

    def stored(self) -> bytes:
        """Bytes that are durable, or would be."""
        return self._nvm.get(MEMORY, self.eeprom.packed())
