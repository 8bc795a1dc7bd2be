"""Drive of CiA 402 as the application of a CANopen node."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from bridges.can.canopen import cia402_words
from bridges.can.canopen.abort_codes import AbortCode
from bridges.can.canopen.canopen_codes import NmtState
from bridges.can.canopen.cia402 import objects
from bridges.can.canopen.cia402.cyclic_modes import CyclicPosition, CyclicVelocity, InterpolatedPosition
from bridges.can.canopen.cia402.drive_automaton import AutomatonClock, DriveAutomaton
from bridges.can.canopen.cia402.drive_context import FACTORS, OWN_WAYS, DriveContext, MakersWays, to_int32
from bridges.can.canopen.cia402.drive_entries import entries_of, modes_of, names_of
from bridges.can.canopen.cia402.error_codes import LOST, DriveError
from bridges.can.canopen.cia402.homing import Homing
from bridges.can.canopen.cia402.motor_axis import MotorAxis
from bridges.can.canopen.cia402.operating_mode import OperatingMode
from bridges.can.canopen.cia402.profile_position import ProfilePosition
from bridges.can.canopen.cia402.profile_torque import ProfileTorque
from bridges.can.canopen.cia402.profile_velocity import ProfileVelocity
from bridges.can.canopen.cia402_words import (
    CONTROLWORD,
    ERROR_CODE,
    MODE,
    MODE_DISPLAY,
    STATUSWORD,
    UNDER_POWER,
)
from bridges.can.canopen.node.application import Access, Entry, SdoAbort, Value
from bridges.can.canopen.node.canopen_node import CanOpenNode
from hil.firmware.homing_methods import HOME, NEGATIVE, POSITIVE, methods_of
from hil.vocab.path import DEG_PER_S
from hil.vocab.time import NS_PER_S

_INPUTS, _NO_MODE = 0x60FD, 0
_FIRST_OWN_BIT = 16
_FIRST_OF_PROFILE = 0x2000
_LEAST_PERIOD_NS, _MOST_PERIOD_NS = 100_000, 10 * NS_PER_S
_MODES: dict[int, Callable[[DriveContext], OperatingMode]] = {
    cia402_words.PROFILE_POSITION: ProfilePosition,
    cia402_words.PROFILE_VELOCITY: ProfileVelocity,
    cia402_words.PROFILE_TORQUE: ProfileTorque,
    cia402_words.HOMING: Homing,
    cia402_words.INTERPOLATED_POSITION: InterpolatedPosition,
    cia402_words.CYCLIC_POSITION: CyclicPosition,
    cia402_words.CYCLIC_VELOCITY: CyclicVelocity,
}
_CHOICES = {
    0x605A: (0, 1, 2, 3, 5, 6, 7),
    0x6086: (0, objects.LIMITED_JERK),
    0x607E: (0, 0x40, 0x80, 0xC0),
}
"""Values that an object takes, where its limits do not say it all."""


class DriveObjects(NamedTuple):
    """Objects that a drive has, names of those with sub-indices, and its modes of operation."""

    entries: Sequence[Entry]
    names: Mapping[int, str]
    modes: tuple[int, ...]
    ways: MakersWays = OWN_WAYS


def objects_of(axis: MotorAxis) -> DriveObjects:
    """Make the objects that hil's own drive of an axis has."""
    entries = entries_of(axis)
    return DriveObjects(entries, names_of(entries), modes_of(axis))


_NOTHING_TOLD = (-1, -1, -1)
_CHECKED = frozenset((MODE, *_CHOICES, 0x6098, *FACTORS, 0x607D, 0x60C2))
"""Objects that do not take every value within their limits, or not always."""


class ProfileDrive:
    """Drive, ``bridges.can.canopen.node.application.Application``: made at each power-up of the card."""

    def __init__(self, axis: MotorAxis, services: CanOpenNode, own: DriveObjects | None = None) -> None:
        own = own or objects_of(axis)
        self.entries: Sequence[Entry] = own.entries
        self.names: Mapping[int, str] = own.names
        self.device_type = objects.SERVO_DRIVE if axis.follows_paths else objects.STEPPER_DRIVE
        self._axis, self._services = axis, services
        self._modes, self._ways = own.modes, own.ways
        self._methods = methods_of(axis.look().inputs, has_index=axis.index_deg is not None)
        self._encoder_counts: float = axis.encoder_counts
        self._told = _NOTHING_TOLD
        self.due_ns = 0
        self._written: dict[tuple[int, int], Value] = {
            (entry.index, entry.subindex): entry.default
            for entry in self.entries
            if entry.access in (Access.RW, Access.WO) and entry.index >= _FIRST_OF_PROFILE
        }
        """Values as they were written last, or at the beginning."""
        self._begin()
        self._reads = self._readers()

    def _begin(self) -> None:
        self._context = DriveContext(self._axis, self._services, self.entries, self._ways)
        modes = {number: _MODES[number](self._context) for number in self._modes}
        modes[_NO_MODE] = OperatingMode(self._context)
        self._automaton = DriveAutomaton(self._context, modes)
        self._clock = AutomatonClock(self._automaton, self._context)
        self._inputs = (*self._axis.look().inputs,)

    # ---- bridges.can.canopen.node.application.Application ----

    def entered(self, state: NmtState, now_ns: int) -> None:
        """Take note of a state. Power-up: all begins again. Stopped: the connection is lost."""
        if state is NmtState.INITIALISING:
            self._automaton.power_off()
            self._begin()
            self._context.load()
            self._written = {key: self._services.value(*key) for key in self._written}
            first = self._context.value(MODE)  # a maker's file may begin with one that there is not
            self._automaton.choose(first if first in self._modes else _NO_MODE, now_ns)
            self._clock.step(now_ns)
        elif state is NmtState.OPERATIONAL:
            self._told = _NOTHING_TOLD  # who listens from now on knows no statusword
        elif state is NmtState.STOPPED:
            self._automaton.lose(DriveError.COMMUNICATION, now_ns)
        self._end(now_ns)

    def lost(self, what: str, now_ns: int) -> None:
        self._automaton.lose(LOST.get(what, DriveError.COMMUNICATION), now_ns)
        self._end(now_ns)

    def step(self, now_ns: int) -> None:
        self._clock.step(now_ns)
        self._tell()

    def synced(self, now_ns: int) -> None:
        self._clock.synced(now_ns)
        self._tell()

    def read(self, index: int, subindex: int, now_ns: int) -> Value:
        return self._reads[index](now_ns)

    def write(self, index: int, subindex: int, value: Value, now_ns: int) -> None:
        before = self._written[index, subindex]
        if index == CONTROLWORD:
            if value == before and self._automaton.is_enabled:
                return  # once more what is done already, as with each SYNC
            self._written[index, subindex] = value
            assert isinstance(value, int)
            self._automaton.control(value, now_ns)
            self._end(now_ns)
        elif value != before:
            if index in _CHECKED:
                assert isinstance(value, int)
                self._check(index, subindex, value)
            self._written[index, subindex] = value
            self._context.note(index)
            if index == MODE:
                assert isinstance(value, int)
                self._automaton.choose(value, now_ns)
            elif not self._automaton.written(index, now_ns):
                return
            self._end(now_ns)

    # ---- what it tells ----

    @property
    def why(self) -> str:
        """Reason of the fault in words; empty: none."""
        return self._automaton.why

    def _end(self, now_ns: int) -> None:
        """End what was not due: it may have changed what is."""
        self._clock.plan(now_ns)
        self._tell()

    def _tell(self) -> None:
        """Let the node know when the drive is due, and send what has changed."""
        self.due_ns = self._clock.due_ns
        automaton = self._automaton
        told = automaton.statusword, automaton.number, automaton.error_code
        if told != self._told:
            before, self._told = self._told, told
            for index, old, new in zip((STATUSWORD, MODE_DISPLAY, ERROR_CODE), before, told, strict=True):
                if old != new:
                    self._services.changed(index, 0)

    def _readers(self) -> dict[int, Callable[[int], int]]:
        """Readers of the live objects, by index; each is given the sub-index."""
        return {
            ERROR_CODE: lambda now_ns: self._automaton.error_code,
            STATUSWORD: lambda now_ns: self._automaton.statusword,
            MODE_DISPLAY: lambda now_ns: self._automaton.number,
            0x6062: lambda now_ns: self._context.units.position(self._context.mover.where(now_ns).deg),
            0x6063: lambda now_ns: self._counts(self._context.look(now_ns).position_deg),
            0x6064: lambda now_ns: self._context.units.position(self._context.look(now_ns).position_deg),
            0x606B: lambda now_ns: self._context.units.velocity(self._context.mover.where(now_ns).rate),
            0x606C: self._velocity,
            0x6074: lambda now_ns: round(self._context.torque_demand),
            0x6077: self._current,
            0x6078: self._current,
            0x60F4: lambda now_ns: self._context.units.distance(self._context.following_error_deg(now_ns)),
            0x60FC: lambda now_ns: self._counts(self._context.mover.where(now_ns).deg),
            _INPUTS: self._digital_inputs,
        }

    def _counts(self, angle_deg: float) -> int:
        return to_int32(angle_deg * self._encoder_counts / 360)

    def _velocity(self, now_ns: int) -> int:
        return self._context.units.velocity(self._context.look(now_ns).velocity_rpm * DEG_PER_S)

    def _current(self, now_ns: int) -> int:
        thousandths = round(self._context.look(now_ns).current_A / self._axis.rated_current_A * 1000)
        return max(-objects.INT16 - 1, min(objects.INT16, thousandths))

    def _digital_inputs(self, now_ns: int) -> int:
        levels = self._context.look(now_ns).inputs
        bits = 0
        for bit, name in enumerate((NEGATIVE, POSITIVE, HOME)):
            bits |= (levels.get(name, 0) != 0) << bit
        others = sorted(name for name in levels if name not in (NEGATIVE, POSITIVE, HOME))
        for bit, name in enumerate(others[:_FIRST_OWN_BIT], _FIRST_OWN_BIT):
            bits |= (levels[name] != 0) << bit
        return bits

    # ---- what it does not take ----

    def _check(self, index: int, subindex: int, value: int) -> None:
        """Check a value that is within its limits. Raises SdoAbort."""
        if index == MODE and value not in self._modes:
            raise SdoAbort(AbortCode.VALUE, f"mode {value}: there are {_listed(self._modes)}")
        if value not in _CHOICES.get(index, (value,)):
            raise SdoAbort(AbortCode.VALUE, f"{index:04X}h takes {_listed(_CHOICES[index])}, not {value}")
        if index == 0x6098 and value not in (0, *self._methods):
            raise SdoAbort(AbortCode.VALUE, f"homing method {value}: there are {_listed(self._methods)}")
        if index in FACTORS and self._automaton.state in UNDER_POWER:
            raise SdoAbort(AbortCode.NOT_NOW, f"{index:04X}h: not while operation is enabled")
        if index == 0x607D:
            low = value if subindex == 1 else self._context.value(index, 1)
            high = self._context.value(index, 2) if subindex == 1 else value
            if high < low:
                raise SdoAbort(AbortCode.MAXIMUM_BELOW_MINIMUM, f"607Dh: {high} is less than {low}")
        if index == 0x60C2:
            count = value if subindex == 1 else self._context.value(index, 1)
            digits = self._context.value(index, 2) if subindex == 1 else value
            period_ns = count * NS_PER_S // 10**-digits
            if not _LEAST_PERIOD_NS <= period_ns <= _MOST_PERIOD_NS:
                raise SdoAbort(
                    AbortCode.VALUE, f"60C2h: {count} x 10^{digits} s; 100 us to 10 s are possible"
                )


def _listed(numbers: tuple[int, ...]) -> str:
    return ", ".join(map(str, numbers))
