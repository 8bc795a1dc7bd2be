"""Build of the firmware: what its user edits in ``Parameters.cpp`` and in ``setup()`` before the upload.

Source: firmware 0.1.5, Parameters.cpp; its numbers with their types, float32 and int.
"""

from hil.firmware.arduino import float32
from hil.vocab.axis import CONTROL_MODES
from hil.vocab.firmware import Board

GAINS = ("pKp", "pKi", "pKd", "pLPF", "vKp", "vKi", "vKd", "vLPF")
OPEN_LOOP = "open_loop"
_SPR = 200
_SENSE_OHM = float32(0.150)
"""Resistor that the sources compute with, whatever the board has."""


class FirmwareBuild:
    """Build of a board's firmware, by the names of ``parameters`` in ``profile.yaml``."""

    def __init__(self, board: Board) -> None:
        self._axis, self._values = board.axis, board.build
        self._do = board.servo.do
        self.spr = int(self._number("spr", _SPR))
        """Full steps in a turn of the motor that it is built for."""
        self.step_deg = float32(360.0 / self.spr)
        self.identifier = str(board.build.get("identifier", "x"))

    def _number(self, name: str, usual: float) -> float:
        return float(self._values.get(name, usual))

    def set_up(self) -> None:
        """Initialise the variables, and the coils' currents as ``setupPins()`` does."""
        axis = self._axis
        if self.spr != _SPR:
            self._do("spr", self.spr)
        axis.set("PA", self._number("PA", self.step_deg))
        for name in GAINS:
            if name in self._values:
                axis.set(name, float(self._values[name]))
        u_max = max_effort(self._number("iMAX", 1.0))
        if u_max != axis.get("uMAX"):
            axis.set("uMAX", u_max)
            axis.vref(int(0.33 * u_max), int(0.33 * u_max))

    def start_loop(self) -> None:
        """Start in closed loop, if it is built so: the set-point is 0 then, wherever the shaft is."""
        starts_in = str(self._values.get("starts_in", OPEN_LOOP))
        if starts_in != OPEN_LOOP:
            self._axis.loop(True)
            self._axis.set("mode", ord(CONTROL_MODES[starts_in]))


def max_effort(i_max_A: float) -> int:
    """Make ``uMAX``, in counts of the driver's reference, of ``iMAX``."""
    return int(255 / 3.3 * float32(float32(float32(i_max_A) * 10) * _SENSE_OHM))
