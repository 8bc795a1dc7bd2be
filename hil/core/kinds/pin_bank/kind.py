"""Pins without a motor: all that hil asks of them."""

from collections.abc import Sequence

from hil.core._native import axis_bytes
from hil.core.abi import BankPin, Kind, Law
from hil.core.axis_kind import AxisKind, numbers
from hil.core.core_axis import CoreAxis
from hil.core.fields import Snapshot, fields_of
from hil.vocab.axis import AxisState
from hil.vocab.firmware import PINS, Pulses


class CoreBank(CoreAxis):
    """Pins of a microcontroller; a firmware sees them as ``hil.vocab.firmware.Pins``."""

    def loop(self, on: bool) -> None:
        """End all pulses where a control loop would be stopped."""
        if not on:
            self._native.bank_pulses(self.id, 0, [])

    def write(self, pin: str, level: int) -> None:
        self._native.bank_write(self.id, self.pins[pin], level)

    def let_go(self, pin: str) -> None:
        self._native.bank_write(self.id, self.pins[pin], -1)

    def read(self, pin: str) -> int:
        return self._native.bank_read(self.id, self.pins[pin])

    def pulse(self, pin: str, rows: Sequence[Pulses]) -> None:
        self._native.bank_pulses(self.id, self.pins[pin], [(r.number, r.period_ns, r.high_ns) for r in rows])

    @property
    def pulses_left(self) -> int:
        return int(self.get("pulses_left"))


def _pin_bank_motion(said: Snapshot) -> AxisState:
    is_pulsing = bool(said.pulses_left)
    return AxisState(said.at_ns, None, None, is_moving=is_pulsing, is_under_way=is_pulsing, is_on=True)


KIND = AxisKind(
    title="pins",
    law=Law.pin_bank,
    inputs=numbers(BankPin),
    outputs=numbers(BankPin),
    parameters=(),
    fields=fields_of(Kind.pin_bank, has_motor=False),
    default_signals=("pin_levels",),
    fault_targets=frozenset(),
    follows_paths=False,
    course=(),
    motion=_pin_bank_motion,
    max_current_A=lambda parameters: 0.0,
    memory_bytes=axis_bytes(Law.pin_bank),
    is_commanded=False,
    settable={},
    make=CoreBank,
    seen_as=PINS,
)
