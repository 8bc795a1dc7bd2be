"""Faults of a whole node: its power, its main program, and what it sends by itself."""

from collections.abc import Callable, Mapping
from functools import partial

from hil.sim.inputs import Reset
from hil.sim.roster import Place
from hil.vocab.faults import Fault
from hil.vocab.segment import Segment
from hil.vocab.time import NS_PER_MS, SimTimeNs
from hil.wire.byte_faults import Chance
from hil.wire.serial_line import character_ns


def renew(place: Place, faults: Mapping[int, Fault], now_ns: SimTimeNs) -> None:
    """Set a board's state from all the faults that are in force on it, by their numbers."""
    assert place.device
    off = [number for number, fault in faults.items() if fault.kind == "node_brown_out"]
    place.device.power.switch(f"no power (fault {off[0]})" if off else None, now_ns)
    place.device.is_hung = any(fault.kind == "node_hang" for fault in faults.values())


def happen(fault: Fault, place: Place, now_ns: SimTimeNs) -> None:
    """Carry out a fault that happens once, and is over."""
    assert place.device
    if fault.kind == "steps_lost":
        assert place.axis
        place.axis.fault("shift_rev", fault.number("turn_deg") / 360)
        return
    place.device.apply(Reset(), now_ns)
    run(place, now_ns)


def run(place: Place, now_ns: SimTimeNs) -> None:
    assert place.device
    place.device.step(now_ns)
    place.group.note_due(place.device)


def babble(
    fault: Fault, place: Place, is_in_force: Callable[[], bool], chance: Chance, now_ns: SimTimeNs
) -> None:
    """Send a burst of nonsense, and the next when it is time, for as long as ``is_in_force`` says."""
    if not is_in_force():
        return
    assert place.segment
    period_ns = round(fault.number("every_ms") * NS_PER_MS)
    if place.segment.has(place.station):
        count = int(fault.number("bytes"))
        data = bytes(chance.bits() & 0xFF for _ in range(count))
        _send(place.segment, place.station, data, now_ns)
        # A burst that came before this one is out would be lost, and its bytes drawn for nothing.
        baud, bits = place.segment.baud_of(place.station), place.segment.line_format.bits
        period_ns = max(period_ns, character_ns(count, baud, bits))
    place.group.at(now_ns + period_ns, partial(babble, fault, place, is_in_force, chance))


def answer(place: Place, at_ns: int, station: str, raw: bytes) -> None:
    """Send for a station that a fault has put on the segment."""
    assert place.segment
    place.group.at(at_ns, partial(_send, place.segment, station, raw))


def _send(segment: Segment, station: str, raw: bytes, now_ns: SimTimeNs) -> None:
    if segment.has(station):
        segment.transmit(station, now_ns, raw, segment.baud_of(station))
