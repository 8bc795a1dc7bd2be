"""Board as a sketch of a user's own sees it: variables and functions of the firmware, by its names."""

from collections.abc import Callable, Mapping, Sequence
from math import copysign, sqrt

from device_profiles.mechaduino import encoder
from device_profiles.mechaduino.firmware import Mechaduino
from device_profiles.mechaduino.serial_usb import Steps
from hil.firmware.arduino import float32
from hil.firmware.sketch_serial import SketchSerial
from hil.firmware.sketch_waits import HIGH, LOW, Hook, SketchMistake, SketchWaits, Waiting, caller
from hil.vocab.firmware import Board, Delay, ServoAxis
from hil.vocab.time import NS_PER_MS, NS_PER_US

CheckSerial = Callable[[Mapping[str, Hook]], Steps]

VREF_1, VREF_2, LED = 9, 4, 13
"""Numbers of pins. Source: firmware 0.1.5, Parameters.h."""
_INPUTS = {0: "pin_dir", 1: "pin_step", 2: "pin_enable", 3: "pin_d3"}
_REL_STEP_DEG, _ABS_STEP_DEG = 0.45, 0.225
"""Steps of the set-point in moveRel() and moveAbs(). Source: firmware 0.1.5, Utils.cpp."""


class FirmwareVariable:
    """Variable of the firmware that the axis has as a field, which a sketch reads and sets."""

    def __init__(self, field: str) -> None:
        self._field = field

    def __get__(self, board: "SketchBoard", owner: object = None) -> float:
        return board.axis.get(self._field)

    def __set__(self, board: "SketchBoard", value: float) -> None:
        board.axis.set(self._field, value)


class Measured:
    """Variable that the control interrupt sets, and a sketch reads."""

    def __init__(self, field: str) -> None:
        self._field = field

    def __get__(self, board: "SketchBoard", owner: object = None) -> float:
        return board.axis.get(self._field)

    def __set__(self, board: "SketchBoard", value: float) -> None:
        raise SketchMistake(f"{self._field} is set by the control interrupt: a sketch reads it", caller())


class Controlled(Measured):
    """Variable that the controller sets: the firmware's, or the sketch's own."""

    def __set__(self, board: "SketchBoard", value: float) -> None:
        board.axis.do(self._field, value)


class SketchBoard:
    """Board of a sketch.

    Long because it is the list of the firmware's variables and functions, each with what it does here.
    """

    ledPin, step_pin, dir_pin, enable_pin = LED, 1, 0, 2
    r = FirmwareVariable("r")
    """Set-point: degrees, rpm or counts, by the mode."""
    y = Measured("y")
    """Calibrated angle, degrees."""
    yw = Measured("yw")
    """The same with turns."""
    v = Measured("v")
    """Filtered speed of velocity mode, rpm."""
    ITerm, DTerm, wrap_count = Measured("ITerm"), Measured("DTerm"), Measured("wrap_count")
    e, u = Controlled("e"), Controlled("u")
    """Error and effort; a controller of the sketch's own sets them."""
    pKp, pKi, pKd, pLPF = (
        FirmwareVariable("pKp"),
        FirmwareVariable("pKi"),
        FirmwareVariable("pKd"),
        FirmwareVariable("pLPF"),
    )
    vKp, vKi, vKd, vLPF = (
        FirmwareVariable("vKp"),
        FirmwareVariable("vKi"),
        FirmwareVariable("vKd"),
        FirmwareVariable("vLPF"),
    )
    PA, uMAX, dir = FirmwareVariable("PA"), FirmwareVariable("uMAX"), FirmwareVariable("dir")

    def __init__(
        self, firmware: Mechaduino, board: Board, waits: SketchWaits, check_serial: CheckSerial
    ) -> None:
        self.axis: ServoAxis = board.servo
        self._firmware, self._board, self._waits = firmware, board, waits
        self._check_serial = check_serial
        self.SerialUSB = SketchSerial(board.uart, waits)
        self._levels: dict[int, int] = {}

    # ---- variables that are no numbers ----

    @property
    def mode(self) -> str:
        """Letter of the control mode: x, v, t or h; empty: none."""
        code = int(self.axis.get("mode"))
        return chr(code) if code else ""

    @mode.setter
    def mode(self, letter: str) -> None:
        self.axis.set("mode", ord(letter) if letter else 0)

    @property
    def lookup(self) -> Sequence[float]:
        """Look-up table: the calibrated angle of each encoder count, degrees."""
        return self._firmware.table.angles

    @property
    def spr(self) -> int:
        """Full steps in a turn of the motor that the firmware is built for."""
        return self._firmware.build.spr

    # ---- the Arduino's ----

    def millis(self) -> int:
        """Milliseconds since power-up."""
        return self._board.millis()

    def micros(self) -> int:
        """Microseconds since power-up."""
        return self._board.micros()

    def delay(self, ms: float) -> Delay:
        """Wait: ``yield board.delay(100)``."""
        return self._waits.delay(round(ms * NS_PER_MS), f"board.delay({ms:g})")

    def delayMicroseconds(self, us: float) -> Delay:
        """Wait: ``yield board.delayMicroseconds(100)``."""
        return self._waits.delay(round(us * NS_PER_US), f"board.delayMicroseconds({us:g})")

    def pinMode(self, pin: int, mode: str) -> None:
        """Accept a direction: pins 0 to 3 are inputs here, and all others outputs."""

    def digitalRead(self, pin: int) -> int:
        """Level of an input, 0 to 3; of another pin what was written."""
        if pin in _INPUTS:
            return int(self.axis.get(_INPUTS[pin]))
        return self._levels.get(pin, 0)

    def digitalWrite(self, pin: int, level: int) -> None:
        """Set an output, which the board tells as a value of its own: `d13`. All but 0 is high, as an
        Arduino has it."""
        self._levels[pin] = HIGH if level else LOW
        self._board.tell(f"d{pin}", float(self._levels[pin]))

    def analogFastWrite(self, pin: int, value: int) -> None:
        """Set the duty of an output, 0 to 255: of VREF_1 (9) and VREF_2 (4) a coil's current."""
        count = max(0, min(255, int(value)))
        if pin in (VREF_1, VREF_2):
            now = {9: int(self.axis.get("vref1")), 4: int(self.axis.get("vref2"))} | {pin: count}
            self.axis.vref(now[VREF_1], now[VREF_2])
        else:
            self._board.tell(f"pwm{pin}", float(count))

    # ---- the firmware's ----

    def start(self) -> Waiting:
        """Run setup() of the stock firmware, 4 s: ``yield from board.start()``."""
        return self._waits.steps(self._firmware.boot(), "board.start()")

    def setupPins(self) -> None:
        """Set the pins up: the coils get a third of the current."""
        count = int(0.33 * self.axis.get("uMAX"))
        self.axis.vref(count, count)

    def setupTCInterrupts(self) -> None:
        """Configure the control interrupt, which is there."""

    def setupSPI(self) -> Waiting:
        """Begin to speak with the encoder, 1 s: ``yield from board.setupSPI()``."""
        return self._waits.steps(self._firmware.set_up_encoder(), "board.setupSPI()")

    def serialMenu(self) -> None:
        """Print the menu."""
        self._firmware.print_menu()

    def serialCheck(self, own: Mapping[str, Hook] | None = None) -> Waiting:
        """Carry out one command, if one has come: ``yield from board.serialCheck()``. ``own``: commands of
        the sketch by their letters, each a function as ``loop``."""
        return self._waits.steps(self._check_serial(own or {}), "board.serialCheck()")

    def configureStepDir(self) -> None:
        """Connect the step and direction inputs, which are connected always."""

    def configureEnablePin(self) -> None:
        """Connect the enable input, which is connected always."""

    def enableTCInterrupts(self) -> None:
        """Start the control interrupt: closed loop."""
        self.axis.loop(True)

    def disableTCInterrupts(self) -> None:
        """Stop it; the coils keep their currents."""
        self.axis.loop(False)

    def output(self, theta_deg: float, effort: int) -> None:
        """Drive the coils for an angle of the rotor, with an effort in counts."""
        self.axis.output(float32(theta_deg), int(effort))

    def readEncoder(self) -> int:
        """Read the encoder's count, 0 to 16,383."""
        return encoder.read_count(self.axis)

    def oneStep(self) -> Waiting:
        """Take a full step in open loop: ``yield from board.oneStep()``."""
        return self._waits.steps(self._firmware.one_step(), "board.oneStep()")

    def calibrate(self) -> Waiting:
        """Run the calibration: ``yield from board.calibrate()``."""
        return self._waits.steps(self._firmware.calibrate(), "board.calibrate()")

    def moveRel(self, pos_final: float, vel_max: float, accel: float) -> Waiting:
        """Move the set-point by an angle (deg), with a trapezoid of speed (deg/s, deg/s2): ``yield from
        board.moveRel(360, 100, 30)``."""
        steps = self._move(self.r, pos_final, vel_max, accel, _REL_STEP_DEG)
        return self._waits.steps(steps, f"board.moveRel({pos_final:g}, {vel_max:g}, {accel:g})")

    def moveAbs(self, pos_final: float, vel_max: float, accel: float) -> Waiting:
        """Move the set-point to an angle, as ``moveRel``."""
        steps = self._move(self.r, pos_final - self.r, vel_max, accel, _ABS_STEP_DEG)
        return self._waits.steps(steps, f"board.moveAbs({pos_final:g}, {vel_max:g}, {accel:g})")

    def _move(self, from_deg: float, by_deg: float, most: float, accel: float, step_deg: float) -> Steps:
        """Step the set-point; each step waits as long as its speed says. The board's own arithmetic takes
        time too, and limits the speed further."""
        if not (accel > 0 and most > 0):
            raise ValueError(f"speed and acceleration are above 0, and not {most:g} and {accel:g}")
        gone_deg, speed = 0.0, 0.0
        while abs(left_deg := by_deg - gone_deg) > step_deg / 2:
            ends = copysign(sqrt(2 * abs(left_deg) * accel), left_deg)
            gain = accel * step_deg / abs(speed) if speed else sqrt(2 * accel * step_deg)
            if ends > speed:
                speed = min(most, speed + gain)
            elif ends < speed:
                speed = max(-most, speed - gain)
            yield Delay(round(abs(step_deg / speed) * 1e6) * NS_PER_US)
            gone_deg += copysign(step_deg, speed)
            self.r = from_deg + gone_deg
        self.r = from_deg + by_deg
