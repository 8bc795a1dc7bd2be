"""One axis of a core, with names instead of numbers."""

import math
from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import cached_property

from hil.core._native import NativeCore
from hil.core.abi import AxisFault
from hil.core.axis_kind import LOAD, AxisKind
from hil.core.core_processor import CoreProcessor
from hil.core.core_switch import CoreSwitch
from hil.core.fields import INDEX, Snapshot
from hil.vocab.axis_plan import FollowedSpeed
from hil.vocab.own_fields import NO_FAULTS
from hil.vocab.path import PathPiece


class CoreAxis:
    """One axis of a core; what a firmware sees is ``hil.vocab.firmware.Axis``.

    Every call acts at the group's present time and needs the caller to own the group.
    """

    def __init__(self, native: NativeCore, axis: int, kind: AxisKind) -> None:
        self._native = native
        self.id = axis
        self.kind = kind
        self.processor: CoreProcessor | None = None
        """Processor whose pins these are, if it can run a program."""
        self.pins = kind.inputs
        """Numbers of the axis's inputs by name."""
        self.nominal_supply_V = native.supply_V(axis)
        """Supply of the full plant as it was opened, 0 for the simple one."""
        self.holding_Nm = 0.0
        """Maximum torque of the motor, without that of its magnets."""
        self.speed_limit_rpm = math.inf
        """Maximum speed of the shaft, whatever drags it."""
        self.find_followed: Callable[[], FollowedSpeed] = FollowedSpeed
        """Function that computes ``followed``, once it is asked for: a bench has many axes."""
        self.is_on_bus = False
        """True if the drive of a CAN bus's node counts by the axis's angle."""
        self.is_in_run = False
        """True while a run goes by the axis's angle."""
        self.field_faults = NO_FAULTS
        """Faults of the board's own fields."""
        self.set_load_Nm = 0.0
        """Load torque as it was set last, without that of faults."""

    @cached_property
    def followed(self) -> FollowedSpeed:
        """Speeds up to which the motor follows, by its figures."""
        return self.find_followed()

    def get(self, field: str) -> float:
        """A field by its name (``AxisKind.fields``). Raises KeyError for another name."""
        return self._native.get(self.id, self.index(field))

    def set(self, field: str, value: float) -> None:
        """Set a writable field. Raises KeyError, or AttributeError for one that is read-only."""
        self._native.set(self.id, self.index(field), value)
        if field == LOAD:
            self.set_load_Nm = value

    def index(self, field: str) -> int:
        """Index of a field in the core's table. Raises KeyError: there is none of that name."""
        of_kind = self.kind.fields.get(field)
        return INDEX[field] if of_kind is None else of_kind

    def output(self, theta_deg: float, effort: int) -> None:
        self._native.output(self.id, theta_deg, effort)

    def vref(self, vref1: int, vref2: int) -> None:
        self._native.vref(self.id, vref1, vref2)

    def loop(self, on: bool) -> None:
        self._native.loop(self.id, on)

    def spi(self, command: int) -> int:
        return self._native.spi(self.id, command)

    def table(self) -> bytes:
        return self._native.table(self.id)

    def write_table(self, packed: bytes) -> None:
        self._native.write_table(self.id, packed)

    def power_up(self) -> None:
        """Cold-start the control law and the driver; the shaft stays where it is."""
        self._native.power_up(self.id)

    def pin(self, name: str, level: int) -> None:
        """Drive an input; of a servo D0 (direction: high is towards smaller counts), D1 (step, rising
        edge), D2 (enable, active low), D3. Raises KeyError for another name."""
        self._native.pin(self.id, self.pins[name], level)

    def fault(self, what: str, value: float) -> None:
        """Begin a fault of ``hil.core.abi.AxisFault``, or end it (0).

        Raises:
            KeyError: there is no such fault.
            ValueError: this axis cannot have it.
        """
        self._native.fault(self.id, AxisFault[what], value)

    def supply_V(self) -> float:
        """Supply of the full plant now, 0 for the simple one."""
        return self._native.supply_V(self.id)

    def script_encoder(self, points: Sequence[tuple[int, int]], linear: bool) -> None:
        """Take encoder counts from ``(at_ns, raw)`` points instead of the shaft; none: the shaft again."""
        times = array("q", [at_ns for at_ns, _ in points])
        self._native.script_encoder(self.id, times, array("q", [raw for _, raw in points]), linear)

    def place_magnet(self, shaft: "CoreAxis", *, zero_deg: float, is_reversed: bool) -> None:
        """Put the magnet that an encoder reads on the shaft of another axis of its group. ``zero_deg``: angle
        of the shaft at which it reads 0; ``is_reversed``: it counts down as the shaft's angle grows.

        Raises:
            ValueError: this axis reads no magnet.
        """
        self._native.magnet(self.id, shaft.id, is_reversed, zero_deg)

    def add_switch(self, given: Mapping[str, float], to: "CoreAxis | None", pin: str) -> CoreSwitch:
        """Put a switch at the shaft, wired to an input of an axis of its group, or to none. ``given``: the
        other members of ``native/types.h``: hil_switch.

        Raises:
            MemoryError: there are too many.
        """
        to_pin = {"to_axis": -1, "to_pin": 0} if to is None else {"to_axis": to.id, "to_pin": to.pins[pin]}
        return CoreSwitch(self._native, self.id, self._native.switch_add(self.id, {**given, **to_pin}))

    def drive(self, rows: Sequence[tuple[int, str, int, int, int]]) -> None:
        """Drive the inputs by a signal source from now on; no rows: none. Rows are (at_ns from now, pin,
        level, steps, duration_ns) as in ``native/types.h``: hil_edges. Raises KeyError for another pin."""
        self._native.drive(
            self.id, [(at_ns, self.pins[pin], level, steps, ns) for at_ns, pin, level, steps, ns in rows]
        )

    def follow(self, path: Sequence[PathPiece], start_ns: int = 0) -> None:
        """Let the set-point follow a path from ``start_ns`` on, or from now, and keep its end; an empty path
        leaves it as it is.

        Raises:
            ValueError: a piece that is not finite, or too long.
        """
        self._native.follow(self.id, start_ns, list(path))

    def watch(self, slot: int, interval_ns: int | Fraction, capacity: int, points: int = 1) -> None:
        """Sample the axis at the multiples of ``interval_ns``, rounded down to whole nanoseconds; 0 ends it.
        There are ``WATCHES`` slots, each with a grid of its own. Up to ``capacity`` samples wait to be taken,
        later ones are lost. ``points`` above 1: of so many times in each interval a pair of samples has the
        smallest and the largest value of each field, in the order in which they came.

        Raises:
            ValueError: there is no such slot, or the interval is below 1 ns, or 146 years.
        """
        between_ns = Fraction(interval_ns) / points
        self._native.watch(self.id, slot, *between_ns.as_integer_ratio(), capacity, points)

    def take_samples(self, slot: int) -> list[bytes]:
        """The samples since the last call, each in the binary layout (``hil.core.fields.OFFSETS``). The group
        need not be owned."""
        return self._native.take_samples(self.id, slot)

    def take_rows(self, slot: int, fields: Sequence[str]) -> list[tuple[float, ...]]:
        """Some fields of the samples since the last call, by name. The group need not be owned."""
        return self._native.take_rows(self.id, slot, [self.index(name) for name in fields])

    def lost_samples(self, slot: int) -> int:
        """Number of samples lost for lack of room, since ``watch``. The group need not be owned."""
        return self._native.lost_samples(self.id, slot)

    def snapshot(self) -> Snapshot:
        return Snapshot(self._native.snapshot(self.id), self.kind.fields)

    def glance(self) -> Snapshot:
        """Snapshot for who reads a few fields, at once: each is unpacked when it is read."""
        return Snapshot(self._native.packed_values(self.id), self.kind.fields)

    def published(self) -> Snapshot:
        """State as of the last release, in real time of the last 20 ms; from any thread, owner or not."""
        return Snapshot(self._native.published(self.id), self.kind.fields)

    def record_edges(self, on: bool, outputs: Iterable[str] | None = None) -> None:
        """Keep the edges of these outputs, or of all, from now on for ``take_edges``, or of none. For virtual
        time."""
        numbers = self.kind.outputs
        names = numbers if outputs is None else outputs
        self._native.record_edges(self.id, sum(1 << numbers[name] for name in names) if on else 0)

    def take_edges(self) -> list[tuple[int, str, int]]:
        """Edges since the last call: (at_ns, output, level)."""
        names = {number: name for name, number in self.kind.outputs.items()}
        return [(at_ns, names[pin], level) for at_ns, pin, level in self._native.take_edges(self.id)]

    def output_levels(self) -> dict[str, int]:
        """Present levels of the outputs."""
        high = self._native.output_levels(self.id)
        return {name: high >> number & 1 for name, number in self.kind.outputs.items()}

    def record_input_edges(self, on: bool) -> None:
        """Keep the edges of all inputs from now on for ``take_input_edges``, or of none. For virtual time."""
        self._native.record_inputs(self.id, sum({1 << each for each in self.pins.values()}) if on else 0)

    def take_input_edges(self) -> list[tuple[int, int, int]]:
        """Edges of inputs since the last call: (at_ns, input's number, level). The first ones are the levels
        of when the record began, of inputs that were ever set."""
        return self._native.take_inputs(self.id)
