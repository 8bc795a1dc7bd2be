"""Faults of an axis: its shaft, coils, supply, encoder and switches."""

import math
from collections.abc import Iterable, Mapping

from hil.core import CoreAxis
from hil.core.abi import CONTACT_CLOSED, CONTACT_OPEN
from hil.core.core_switch import CoreSwitch
from hil.vocab import faults as faults_of
from hil.vocab.faults import Fault
from hil.vocab.own_fields import NO_FAULTS, FieldFaults

COUNTS = 16384
"""Counts of an encoder in a turn."""


def axis_state(
    faults: Iterable[Fault], supply_V: float, own: Mapping[str, Mapping[str, str]]
) -> dict[str, float]:
    """Arguments for ``CoreAxis.fault``, from the faults in force on an axis, the oldest first. ``supply_V``:
    supply of the full plant in the configuration, 0 for the simple one. ``own``: ``AxisKind.own_faults``.

    Loads and slips add up. Of two supplies or two noises the later one counts. Everything else is so as long
    as one of its kind is.
    """
    state = dict.fromkeys(
        (
            *("jam", "open_a", "open_b", "swapped_a", "swapped_b"),
            *("noise_seed", "noise_counts", "freeze", "open_line"),
        ),
        0.0,
    )
    state |= {told: 0.0 for each in own.values() for told in each}
    if supply_V:
        state["supply_V"] = supply_V
    loads_Nm, slips = [], 0.0
    for fault in faults:
        match fault.kind:
            case "shaft_load":
                loads_Nm.append(fault.number("torque_Nm"))
            case "shaft_jam":
                state["jam"] = 1
            case "phase_open":
                state["open_a" if fault.parameters["coil"] == "A" else "open_b"] = 1
            case "phase_swapped":
                state["swapped_a" if fault.parameters["coil"] == "A" else "swapped_b"] = 1
            case "thermal_trip" | "motor_unplugged" | "motor_power_off" | "node_brown_out":
                state |= {"open_a": 1, "open_b": 1}
            case "supply_sag":
                state["supply_V"] = fault.number("supply_V")
            case "encoder_slip":
                slips += fault.number("counts")
            case "encoder_noise":
                state |= {"noise_seed": fault.number("seed"), "noise_counts": fault.number("counts")}
            case "encoder_freeze":
                state["freeze"] = 1
            case "chip_eeprom_worn":
                state["eeprom_worn"] = 1
            case faults_of.PIN_STUCK:
                name = "stuck_high" if fault.number("level") else "stuck_low"
                state[name] = int(state[name]) | 1 << int(fault.number("pin"))
            case "encoder_disconnect":
                state["open_line"] = 1
            case kind:
                state |= {told: fault.number(name) for told, name in own.get(kind, {}).items()}
    return state | {"load_Nm": math.fsum(loads_Nm), "slip_counts": math.fmod(slips, COUNTS)}


def field_faults(axis: CoreAxis, faults: Iterable[Fault]) -> FieldFaults:
    """Faults of a board's own fields, from those in force on its axis. One that becomes stuck stays at the
    value that it has now."""
    offsets: dict[str, float] = {}
    stuck: dict[str, float] = {}
    for fault in faults:
        name = str(fault.parameters.get("field", ""))
        if fault.kind == faults_of.FIELD_OFFSET:
            offsets[name] = offsets.get(name, 0.0) + fault.number("offset")
        elif fault.kind == faults_of.FIELD_STUCK:
            before = axis.field_faults.stuck
            stuck[name] = before[name] if name in before else axis.get(name)
    return FieldFaults(stuck, offsets) if offsets or stuck else NO_FAULTS


def renew_switch(switch: CoreSwitch, faults: Iterable[Fault]) -> None:
    """Set a switch from all the faults that are in force on it, the oldest first."""
    held, shifts_deg, is_broken = 0, [], False
    for fault in faults:
        if fault.kind == "switch_stuck":
            held = CONTACT_OPEN if fault.parameters["contact"] == "open" else CONTACT_CLOSED
        elif fault.kind == "switch_moved":
            shifts_deg.append(fault.number("by_deg"))
        else:
            is_broken = True
    switch.fault(CONTACT_OPEN if is_broken else held, math.fsum(shifts_deg))


class AxisFaults:
    """State that each axis was told last."""

    def __init__(self) -> None:
        self._told: dict[CoreAxis, dict[str, float]] = {}

    def renew(self, axis: CoreAxis, faults: Iterable[Fault]) -> None:
        """Set an axis from all the faults that are in force on it."""
        faults = list(faults)
        if axis.kind.board_fields:
            axis.field_faults = field_faults(axis, faults)
        supply_V = axis.nominal_supply_V
        state = axis_state(faults, supply_V, axis.kind.own_faults)
        before = self._told.get(axis) or axis_state((), supply_V, axis.kind.own_faults)
        for what, value in state.items():
            if value != before[what]:
                axis.fault(what, value)
        self._told[axis] = state

    def forget(self, axes: Iterable[CoreAxis]) -> None:
        for axis in axes:
            self._told.pop(axis, None)
