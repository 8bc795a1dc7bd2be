"""Pins without a motor: all that hil asks of them."""

from collections.abc import Sequence

from hil.core._native import NativeCore, axis_bytes
from hil.core.abi import BankPin, Kind, Law
from hil.core.axis_kind import AxisKind, Settable, numbers
from hil.core.core_axis import CoreAxis
from hil.core.core_processor import CoreProcessor
from hil.core.fields import Snapshot, fields_of
from hil.vocab.axis import AxisState
from hil.vocab.faults import PIN_STUCK, PROCESSOR
from hil.vocab.firmware import PINS, Pulses


class CoreBank(CoreAxis):
    """Pins of a microcontroller; a firmware sees them as ``hil.vocab.firmware.Pins``."""

    def __init__(self, native: NativeCore, axis: int, kind: AxisKind) -> None:
        super().__init__(native, axis, kind)
        self.processor: CoreProcessor = CoreProcessor(native, axis, self.pins)

    def power_up(self) -> None:
        super().power_up()
        self.processor.lose_power()

    def fault(self, what: str, value: float) -> None:
        if what == "eeprom_worn":
            self.processor.wear_eeprom(bool(value))
        else:
            super().fault(what, value)

    def loop(self, on: bool) -> None:
        """End all pulses, and hold the processor, where a control loop would be stopped."""
        if not on:
            self._native.bank_pulses(self.id, 0, [])
            self.processor.hold()

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


VOLTS = Settable(-0.5, 6.0, is_around=True)
"""Absolute maximum ratings. Source: DS40002061, 29.1."""

KIND = AxisKind(
    title="pins",
    law=Law.pin_bank,
    inputs=numbers(BankPin),
    outputs=numbers(BankPin),
    parameters=(),
    fields=fields_of(Kind.pin_bank, has_motor=False),
    default_signals=("pin_levels",),
    fault_targets=frozenset({PROCESSOR}),
    follows_paths=False,
    course=(),
    motion=_pin_bank_motion,
    max_current_A=lambda parameters: 0.0,
    memory_bytes=axis_bytes(Law.pin_bank),
    is_commanded=False,
    levels="pin_levels",
    analog={f"A{channel}": channel for channel in range(8)},
    means={f"d{number}_V": number for number in (3, 5, 6, 9, 10, 11)},
    settable={"vcc_V": VOLTS, **{f"a{channel}_V": VOLTS for channel in range(8)}},
    own_faults={
        "chip_clock_off": {"clock_error_pct": "percent"},
        PIN_STUCK: {"stuck_low": "", "stuck_high": ""},
        "chip_eeprom_worn": {"eeprom_worn": ""},
    },
    make=CoreBank,
    seen_as=PINS,
)
