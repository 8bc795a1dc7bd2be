"""Pins without a motor: all that hil asks of them."""

from hil.core._native import axis_bytes
from hil.core.abi import BankPin, Kind, Law
from hil.core.axis_kind import AxisKind, numbers
from hil.core.fields import Snapshot, fields_of
from hil.core.kinds.pin_bank.core_bank import CoreBank
from hil.vocab.axis import AxisState
from hil.vocab.firmware import PINS


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
