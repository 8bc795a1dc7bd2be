"""The look-up table in the board's flash: the calibrated angle of each encoder count."""

import math
from array import array
from collections.abc import Mapping

from device_profiles.mechaduino import calibration
from device_profiles.mechaduino.serial_usb import SerialUSB, Steps
from hil.firmware.arduino import print_float
from hil.vocab.firmware import Axis, Commit
from hil.vocab.profile import MemoryFile

LOOKUP = "lookup"
"""The section of the flash that holds the table."""
_COUNTS = calibration.COUNTS_PER_REV


def identity_table() -> bytes:
    """Make the table of a perfect encoder: angle = count * 360 / 16384, as float32."""
    return array("f", [i * 360 / _COUNTS for i in range(_COUNTS)]).tobytes()


def table_from_file(content: bytes) -> bytes:
    """Read a table from a file's content: 16,384 numbers in degrees separated by white space or commas, as
    ``q`` prints them, or 65,536 bytes of little-endian float32.

    Raises:
        ValueError: it is neither.
    """
    if len(content) == _COUNTS * 4:
        return content
    try:
        words = content.decode().replace(",", " ").split()
    except UnicodeDecodeError as error:
        why = f"the byte {content[error.start]:#04x} at {error.start} is no text"
        raise ValueError(f"neither numbers nor 65,536 bytes of float32: {why}") from None
    if wrong := next((word for word in words if not _is_number(word)), None):
        raise ValueError(f"neither numbers nor 65,536 bytes of float32: {wrong[:20]!r} is no number")
    angles = array("f", map(float, words))
    if len(angles) != _COUNTS:
        raise ValueError(f"{len(angles):,} angles instead of {_COUNTS:,}")
    return angles.tobytes()


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


TABLE_FILE = MemoryFile(
    section=LOOKUP,
    most_bytes=_COUNTS * 64,  # a number has some ten characters
    read=table_from_file,
    named={"identity": identity_table},
)


class LookupTable:
    """Look-up table. ``angles``: degrees by encoder count; ``address``: where the linker put the table."""

    def __init__(self, axis: Axis, nvm: Mapping[str, bytes], address: int) -> None:
        self._axis = axis
        self._nvm = nvm
        self._address = address
        self._text = ""
        self.angles: array[float] = array("f")

    def load(self) -> None:
        """Load what is in the flash, zeros before the first calibration."""
        self._use(self._nvm.get(LOOKUP, bytes(4 * calibration.COUNTS_PER_REV)))

    def store(self, new: "array[float]", serial: SerialUSB) -> Steps:
        """Write ``new`` over the table, row by row, which ``serial`` shows."""
        serial.print(f"\r\nWriting to flash 0x{self._address:X} page size PSZ=3")
        table = calibration.written(self._axis.table(), new)
        if new and (yield Commit(LOOKUP, table)):  # else a read-back shows the old table
            self._use(table)
        serial.print(calibration.progress(new, self._address))

    def _use(self, table: bytes) -> None:
        self._axis.write_table(table)
        self.angles = array("f", self._axis.table())
        self._text = ""

    @property
    def is_written(self) -> bool:
        """True if the table was ever written, by the firmware's own test of three angles."""
        angles = self.angles  # asked for each set-point: no loop
        return bool(angles[0] or angles[128] or angles[1024])

    def angle_deg(self) -> float:
        """Calibrated angle with turns, of a reading now, as the law's next step will count it."""
        angle_deg, turns = self.angles[int(self._axis.get("raw"))], self._axis.get("wrap_count")
        since_deg = angle_deg - (self._axis.get("yw") - 360.0 * turns)
        if abs(since_deg) > 180.0:
            turns -= math.copysign(1.0, since_deg)
        return angle_deg + 360.0 * turns

    def text(self) -> str:
        """Text of all angles with two decimals, as ``q`` prints them."""
        if not self._text:
            self._text = "".join(f"{print_float(angle)}, " for angle in self.angles)
        return self._text
