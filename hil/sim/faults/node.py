"""Faults of a whole node: its power, and its main program."""

from collections.abc import Mapping

from hil.sim.bench_parts import FaultPlace
from hil.sim.faults import processor_faults
from hil.sim.inputs import Reset
from hil.vocab.faults import Fault
from hil.vocab.time import SimTimeNs


def renew(place: FaultPlace, faults: Mapping[int, Fault], now_ns: SimTimeNs) -> None:
    """Set a board's state from all the faults that are in force on it, by their numbers."""
    assert place.device
    off = [number for number, fault in faults.items() if fault.kind == "node_brown_out"]
    place.device.power.switch(f"no power (fault {off[0]})" if off else None, now_ns)
    place.device.is_hung = any(fault.kind == "node_hang" for fault in faults.values())


def happen(fault: Fault, place: FaultPlace, now_ns: SimTimeNs) -> None:
    """Carry out a fault that happens once, and is over."""
    assert place.device
    if fault.kind == "steps_lost":
        assert place.axis
        place.axis.fault("shift_rev", fault.number("turn_deg") / 360)
        return
    if fault.layer == "chip":
        assert place.axis
        assert place.axis.processor
        processor_faults.happen(fault, place.axis.processor)
        return
    place.device.apply(Reset(), now_ns)
    run(place, now_ns)


def run(place: FaultPlace, now_ns: SimTimeNs) -> None:
    assert place.device
    place.device.step(now_ns)
    place.group.note_due(place.device)
