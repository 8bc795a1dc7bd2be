"""One axis of a core, with names instead of numbers."""

import math
from array import array
from collections.abc import Iterable, Sequence
from fractions import Fraction

from hil.core._native import NativeCore
from hil.core.abi import AxisFault
from hil.core.axis_kind import LOAD, AxisKind
from hil.core.fields import INDEX, Snapshot
from hil.vocab.path import PathPiece


class CoreAxis:
    """One axis of a core; what a firmware sees is ``hil.vocab.firmware.Axis``.

    Every call acts at the group's present time and needs the caller to own the group.
    """

    def __init__(self, native: NativeCore, axis: int, kind: AxisKind) -> None:
        self._native = native
        self.id = axis
        self.kind = kind
        self.pins = kind.inputs
        """Numbers of the axis's inputs by name."""
        self.nominal_supply_V = native.supply_V(axis)
        """Supply of the full plant as it was opened, 0 for the simple one."""
        self.holding_Nm = 0.0
        """Maximum torque of the motor, without that of its magnets."""
        self.speed_limit_rpm = math.inf
        """Maximum speed of the shaft, whatever drags it."""
        self.is_on_bus = False
        """True if the drive of a CAN bus's node counts by the axis's angle."""
        self.is_in_run = False
        """True while a run goes by the axis's angle."""
        self.set_load_Nm = 0.0
        """Load torque as it was set last, without that of faults."""

    def get(self, field: str) -> float:
        """A field by its name in ``hil.core.FIELDS``. Raises KeyError for another name."""
        return self._native.get(self.id, INDEX[field])

    def set(self, field: str, value: float) -> None:
        """Set a writable field. Raises KeyError, or AttributeError for one that is read-only."""
        self._native.set(self.id, INDEX[field], value)
        if field == LOAD:
            self.set_load_Nm = value

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

    def watch(self, slot: int, interval_ns: int | Fraction, capacity: int) -> None:
        """Sample the axis at the multiples of ``interval_ns``, rounded down to whole nanoseconds; 0 ends it.
        There are ``WATCHES`` slots, each with a grid of its own. Up to ``capacity`` samples wait to be taken,
        later ones are lost.

        Raises:
            ValueError: there is no such slot, or the interval is below 1 ns, or 146 years.
        """
        self._native.watch(self.id, slot, *interval_ns.as_integer_ratio(), capacity)

    def take_samples(self, slot: int) -> list[bytes]:
        """The samples since the last call, each in the binary layout (``hil.core.fields.OFFSETS``). The group
        need not be owned."""
        return self._native.take_samples(self.id, slot)

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
