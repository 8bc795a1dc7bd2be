"""Commands of TMCL, carried out at one moment of simulated time.

Units are those of modules with a TMC5xxx: microsteps, microsteps a second (pps) and pps a second. A turn has
200 full steps, each of 2 to the power of parameter 140 microsteps: 51,200 in a turn as it is delivered.

Numbers of parameters are those of a TMCM-1140, 127 that of a TMCM-1240, in the maker's pytrinamic 0.2.26.
What is left open there, as the values after power-up, is chosen.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

from hil.vocab.verbs import VerbRefused
from tmcl_bus.card.module_axis import ModuleAxis
from tmcl_bus.frames import FULL_STEPS, Command, Move, Request, Status

_RESOLUTIONS = range(9)
_MOST = 2**31 - 1
_MOTORS = 1
_CURRENTS = range(256)
_OUTPUTS = range(8)
_INPUT_BANK, _OUTPUT_BANK = 0, 2
_CODES = {"bad_parameter": Status.INVALID_VALUE}
"""Statuses by the code of a verb's refusal; all others are ``NOT_AVAILABLE``."""


class CommandRefused(Exception):
    """Refusal of a command, with the status of its reply and, in words, the reason."""

    def __init__(self, status: Status, why: str) -> None:
        super().__init__(why)
        self.status = status


@dataclass
class Settings:
    """Settings of a module as they are after power-up; chosen."""

    target: int = 0
    target_pps: int = 0
    most_pps: int = 51_200
    most_pps_per_s: int = 512_000
    resolution: int = 8
    currents: dict[int, int] = field(default_factory=lambda: {6: 128, 7: 8})
    """Maximum and standby current, by parameter; they have no effect."""
    relative_to: int = 0
    """Start of a relative move: 0 the target, 1 the actual position."""
    outputs: dict[int, int] = field(default_factory=dict)
    """Levels of the outputs, to which nothing is connected."""


class Interpreter:
    """Interpreter of one power-up. ``globals_``: the general parameters of bank 0 by number, which cannot be
    written: they are the configuration's."""

    def __init__(self, axis: ModuleAxis, globals_: dict[int, int], version: int) -> None:
        self._axis, self._globals, self._version = axis, globals_, version
        self._set = Settings()
        self._zero_deg = 0.0
        """Angle at which the actual position is 0."""
        self._commands: dict[int, Callable[[Request], int]] = {
            Command.ROR: lambda request: self._rotate(request, 1),
            Command.ROL: lambda request: self._rotate(request, -1),
            Command.MST: self._stop,
            Command.MVP: self._move,
            Command.SAP: self._set_parameter,
            Command.GAP: self._get_parameter,
            Command.SGP: self._set_global,
            Command.GGP: self._get_global,
            Command.SIO: self._set_output,
            Command.GIO: self._get_io,
            Command.GFV: self._tell_version,
        }

    def carry_out(self, request: Request) -> int:
        """Carry out a request; answers the reply's value. Raises CommandRefused."""
        command = self._commands.get(request.command)
        if command is None:
            raise CommandRefused(Status.INVALID_COMMAND, f"there is no command {request.command}")
        try:
            return command(request)
        except VerbRefused as error:
            raise CommandRefused(_CODES.get(error.code, Status.NOT_AVAILABLE), str(error)) from None

    # ---- units ----

    @property
    def _per_turn(self) -> int:
        return FULL_STEPS << self._set.resolution

    def _position(self) -> int:
        return round((self._axis.look().position_deg - self._zero_deg) / 360 * self._per_turn)

    def _rpm(self, pps: int) -> float:
        return pps * 60 / self._per_turn

    def _set_position(self, value: int) -> None:
        """Let the actual position be a value, where the axis is."""
        self._zero_deg = self._axis.look().position_deg - value / self._per_turn * 360

    # ---- motion ----

    def _rotate(self, request: Request, sign: int) -> int:
        _check_motor(request)
        _check(0 <= request.value <= _MOST, "a speed is 0 or more")
        self._turn(sign * request.value)
        return request.value

    def _turn(self, pps: int) -> None:
        self._axis.rotate(self._rpm(pps), self._rpm(self._set.most_pps_per_s))
        self._set.target_pps = pps

    def _stop(self, request: Request) -> int:
        _check_motor(request)
        self._axis.stop(self._rpm(self._set.most_pps_per_s))
        self._set.target_pps = 0
        return request.value

    def _move(self, request: Request) -> int:
        _check_motor(request)
        if request.type == Move.ABS:
            return self._go(request.value)
        if request.type != Move.REL:
            raise CommandRefused(Status.WRONG_TYPE, f"there is no MVP {request.type}")
        start = self._position() if self._set.relative_to else self._set.target
        return self._go(start + request.value)

    def _go(self, target: int) -> int:
        _check(abs(target) <= _MOST, f"{target} microsteps are too many")
        _check(self._set.most_pps > 0 and self._set.most_pps_per_s > 0, "its maximum speed is 0")
        angle_deg = self._zero_deg + target / self._per_turn * 360
        self._axis.move(angle_deg, self._rpm(self._set.most_pps), self._rpm(self._set.most_pps_per_s))
        self._set.target = target
        self._set.target_pps = 0
        return target

    # ---- axis parameters ----

    def _get_parameter(self, request: Request) -> int:
        _check_motor(request)
        known = self._set
        told: dict[int, Callable[[], int]] = {
            0: lambda: known.target,
            1: self._position,
            2: lambda: known.target_pps,
            3: lambda: round(self._axis.look().velocity_rpm / 60 * self._per_turn),
            4: lambda: known.most_pps,
            5: lambda: known.most_pps_per_s,
            8: lambda: int(self._axis.has_arrived),
            127: lambda: known.relative_to,
            140: lambda: known.resolution,
        }
        if request.type in known.currents:
            return known.currents[request.type]
        if request.type not in told:
            raise CommandRefused(Status.WRONG_TYPE, f"there is no axis parameter {request.type}")
        return told[request.type]()

    def _set_parameter(self, request: Request) -> int:
        _check_motor(request)
        number, value, known = request.type, request.value, self._set
        if number == 0:
            self._go(value)
        elif number == 1:
            self._set_position(value)
        elif number == 2:
            self._turn(value)
        elif number in (4, 5):
            _check(0 < value <= _MOST, "it is more than 0")
            name = "most_pps" if number == 4 else "most_pps_per_s"
            setattr(known, name, value)
        elif number in known.currents:
            _check(value in _CURRENTS, "a current is 0 to 255")
            known.currents[number] = value
        elif number == 127:
            _check(value in (0, 1), "it is 0 or 1")
            known.relative_to = value
        elif number == 140:
            _check(value in _RESOLUTIONS, "a resolution is 0 to 8")
            position = self._position()
            known.resolution = value
            self._set_position(position)
        else:
            raise CommandRefused(Status.WRONG_TYPE, f"axis parameter {number} cannot be set")
        return value

    # ---- general parameters, pins, version ----

    def _get_global(self, request: Request) -> int:
        if request.motor != 0 or request.type not in self._globals:
            raise CommandRefused(Status.WRONG_TYPE, f"there is no parameter {request.type}")
        return self._globals[request.type]

    def _set_global(self, request: Request) -> int:
        self._get_global(request)
        raise CommandRefused(Status.EEPROM_LOCKED, "the configuration says it")

    def _set_output(self, request: Request) -> int:
        if request.motor != _OUTPUT_BANK or request.type not in _OUTPUTS:
            raise CommandRefused(Status.WRONG_TYPE, f"there is no output {request.type}")
        _check(request.value in (0, 1), "a level is 0 or 1")
        self._set.outputs[request.type] = request.value
        return request.value

    def _get_io(self, request: Request) -> int:
        port, inputs = request.type, self._axis.inputs
        if request.motor == _OUTPUT_BANK and port in _OUTPUTS:
            return self._set.outputs.get(port, 0)
        if request.motor == _INPUT_BANK and port < len(inputs):
            return self._axis.level(inputs[port])
        raise CommandRefused(Status.WRONG_TYPE, f"there is no pin {port} in bank {request.motor}")

    def _tell_version(self, request: Request) -> int:
        if request.type != 1:
            raise CommandRefused(Status.WRONG_TYPE, f"there is no version of type {request.type}")
        return self._version


def _check_motor(request: Request) -> None:
    _check(request.motor < _MOTORS, f"there is no motor {request.motor}")


def _check(is_good: bool, why: str) -> None:
    if not is_good:
        raise CommandRefused(Status.INVALID_VALUE, why)
