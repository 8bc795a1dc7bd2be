"""The look-up table in the board's flash: the calibrated angle of each encoder count."""

import math
from array import array
from collections.abc import Mapping

from device_profiles.mechaduino import calibration
from device_profiles.mechaduino.serial_usb import SerialUSB, Steps
from hil.firmware.arduino import print_float
from hil.vocab.firmware import Axis, Commit

LOOKUP = "lookup"
"""The section of the flash that holds the table."""


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
        if new and (yield Commit(LOOKUP, table)):  # else the old table is what a read-back shows
            self._use(table)
        serial.print(calibration.progress(new, self._address))

    def _use(self, table: bytes) -> None:
        self._axis.write_table(table)
        self.angles = array("f", self._axis.table())
        self._text = ""

    @property
    def is_written(self) -> bool:
        """Whether the table was ever written, as the firmware tells it."""
        return any(self.angles[i] for i in (0, 128, 1024))

    def angle_deg(self) -> float:
        """Calibrated angle with turns, of a reading now, as the law's next step will count it."""
        angle_deg, turns = self.angles[int(self._axis.get("raw"))], self._axis.get("wrap_count")
        since_deg = angle_deg - (self._axis.get("yw") - 360.0 * turns)
        if abs(since_deg) > 180.0:
            turns -= math.copysign(1.0, since_deg)
        return angle_deg + 360.0 * turns

    def text(self) -> str:
        """All angles with two decimals, as ``q`` prints them."""
        if not self._text:
            self._text = "".join(f"{print_float(angle)}, " for angle in self.angles)
        return self._text
