"""Faults of twins, segments and taps: each begins and ends in simulated time, and stands in the input log.

What is in force is what is listed, in whatever order they begin and end. So no fault remembers what was
before it: those with a state of their own (the chance of a byte fault) act under their numbers, and what
several can do to one thing (a coil, the supply, a board's power) is reckoned anew from all that are in force.
"""

import math
from collections.abc import Iterable
from functools import partial

from hil.sim.device import Device
from hil.sim.group import Group
from hil.sim.inputs import Clear, Inject, Reset
from hil.sim.roster import Place, Roster
from hil.vocab.faults import FAULT_KINDS, SEGMENT, STATION, TARGETS, Fault, FaultRefused
from hil.vocab.loads import load_problem
from hil.vocab.segment import Segment
from hil.vocab.time import NS_PER_MS, NS_PER_S, SimTimeNs
from hil.wire.byte_faults import ByteFaults, Chance, byte_fault
from hil.wire.serial_line import character_ns

COUNTS = 16384
"""Of an encoder, in a turn."""
LOAD = "shaft_load"


def axis_state(faults: Iterable[Fault], supply_V: float) -> dict[str, float]:
    """What ``CoreAxis.fault`` is to be told of an axis, from what is in force on it, the oldest first.
    ``supply_V``: what the configuration gives the full plant, 0 for the simple one.

    Loads and slips add up. Of two supplies or two noises the later one counts. Everything else is so as long
    as one of its kind is.
    """
    state = dict.fromkeys(
        ("jam", "open_a", "open_b", "noise_seed", "noise_counts", "freeze", "open_line"), 0.0
    )
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
            case "thermal_trip" | "node_brown_out":
                state |= {"open_a": 1, "open_b": 1}
            case "supply_sag":
                state["supply_V"] = fault.number("supply_V")
            case "encoder_slip":
                slips += fault.number("counts")
            case "encoder_noise":
                state |= {"noise_seed": fault.number("seed"), "noise_counts": fault.number("counts")}
            case "encoder_freeze":
                state["freeze"] = 1
            case "encoder_disconnect":
                state["open_line"] = 1
    return state | {"load_Nm": math.fsum(loads_Nm), "slip_counts": math.fmod(slips, COUNTS)}


class Faults:
    """Those that were injected into a bench, by their numbers."""

    def __init__(self, roster: Roster) -> None:
        self._roster = roster
        self._count = 0
        self._in_force: dict[int, tuple[Fault, Place]] = {}
        """In the order that they began."""
        self._axis_states: dict[Device, dict[str, float]] = {}
        """What axes were told last."""
        self.active: dict[int, Fault] = {}
        """Those that are listed: in force, or still to begin."""

    def listed(self, number: int) -> Fault:
        """In force, or still to begin.

        Raises:
            FaultRefused: there is none of this number.
        """
        if number not in self.active:
            active = ", ".join(map(str, self.active)) or "none"
            raise FaultRefused(f"there is no fault {number}; there are: {active}")
        return self.active[number]

    def check(self, fault: Fault, *, with_others: bool) -> None:
        """Whether it can be where it is wanted. ``with_others``: also beside the loads that are there; not
        for what a log has, which was taken then, when the faults here may have been others.

        Raises:
            FaultRefused: it cannot, and why.
        """
        place = self._roster.place(fault.target)
        if place is None:
            raise FaultRefused(f"there is no {fault.target!r}; there are {', '.join(self._roster.targets())}")
        wanted = FAULT_KINDS[fault.kind].target
        if not place.has(wanted):
            places = {name: self._roster.place(name) for name in self._roster.targets()}
            choice = ", ".join(name for name, p in places.items() if p and p.has(wanted)) or "none here"
            raise FaultRefused(f"{fault.kind} is on {TARGETS[wanted]}, as {choice}; not on {fault.target}")
        if fault.kind == LOAD and place.device:
            torque_Nm, axis = fault.number("torque_Nm"), place.device.axis
            problem = load_problem(torque_Nm, axis.holding_Nm)
            if with_others and not problem:
                others_Nm = [axis.set_load_Nm, *self._loads_Nm(place.device)]
                problem = load_problem(torque_Nm, axis.holding_Nm, others_Nm)
            if problem:
                raise FaultRefused(f"torque_Nm: {problem}")

    def load_problem(self, device: Device, torque_Nm: object) -> str | None:
        """What is wrong with a torque to be set on a device's shaft, or None."""
        return load_problem(torque_Nm, device.axis.holding_Nm, self._loads_Nm(device))

    def _loads_Nm(self, device: Device) -> list[float]:
        """Of the faults on a device, in force or still to begin."""
        here = [fault for fault in self.active.values() if fault.target.partition(".")[0] == device.name]
        return [fault.number("torque_Nm") for fault in here if fault.kind == LOAD]

    def new_number(self) -> int:
        """One that no other fault of this bench has."""
        self._count += 1
        return self._count

    def apply(self, target: str, given: Inject | Clear, now_ns: SimTimeNs) -> None:
        """An input takes effect."""
        if isinstance(given, Inject):
            self.inject(given.number, Fault(given.kind, target, dict(given.parameters)), now_ns)
        else:
            self.clear(given.number, now_ns)

    def inject(self, number: int, fault: Fault, now_ns: SimTimeNs) -> None:
        """An input: a fault is to begin now or later. ``check`` has found it good."""
        place = self._roster.place(fault.target)
        assert place
        self.active[number] = fault
        begin_ns = now_ns + round(fault.number("start_s") * NS_PER_S)
        for_ns = round(fault.number("for_s") * NS_PER_S)
        if begin_ns > now_ns:
            place.group.at(begin_ns, partial(self._begin, number, fault, place))
        else:
            self._begin(number, fault, place, now_ns)
        if for_ns:
            place.group.at(begin_ns + for_ns, partial(self.clear, number))

    def clear(self, number: int, now_ns: SimTimeNs) -> None:
        """An input, or its time is over: a fault ends, or does not begin."""
        self.active.pop(number, None)
        if begun := self._in_force.pop(number, None):
            self._end(number, *begun, now_ns)

    def forget(self, name: str) -> None:
        """A device goes, and what was wrong with it."""
        for number, fault in list(self.active.items()):
            if fault.target.partition(".")[0] == name and fault.target not in self._roster.taps:
                del self.active[number]
                self._in_force.pop(number, None)
        self._axis_states = {
            device: state for device, state in self._axis_states.items() if device.name != name
        }

    def _begin(self, number: int, fault: Fault, place: Place, now_ns: SimTimeNs) -> None:
        if number not in self.active:
            return
        kind = FAULT_KINDS[fault.kind]
        if kind.is_once:
            del self.active[number]
            _happen(fault, place, now_ns)
            return
        self._in_force[number] = fault, place
        if kind.layer in ("byte", "host"):
            for way in _ways(fault, place):
                way[number] = _byte_faults(fault)
        elif fault.kind == "node_babble":
            self._babble(number, fault, place, Chance(int(fault.number("seed"))), now_ns)
        elif place.segment and kind.target in (SEGMENT, STATION):
            place.segment.inject(number, fault, place.station, partial(_answer, place))
        elif place.device:
            self._renew(place.group, place.device, kind.layer, now_ns)

    def _end(self, number: int, fault: Fault, place: Place, now_ns: SimTimeNs) -> None:
        kind = FAULT_KINDS[fault.kind]
        if kind.layer in ("byte", "host"):
            for way in _ways(fault, place):
                way.pop(number)
        elif place.segment and kind.target in (SEGMENT, STATION):
            if fault.kind != "node_babble":  # which hears of it when it wants to speak again
                place.segment.clear(number, fault, place.station)
        elif place.device:
            self._renew(place.group, place.device, kind.layer, now_ns)

    def _babble(self, number: int, fault: Fault, place: Place, chance: Chance, now_ns: SimTimeNs) -> None:
        if number not in self._in_force:
            return
        assert place.segment
        period_ns = round(fault.number("every_ms") * NS_PER_MS)
        if place.segment.has(place.station):
            count = int(fault.number("bytes"))
            data = bytes(chance.bits() & 0xFF for _ in range(count))
            _send(place.segment, place.station, data, now_ns)
            # What came before this burst is out would be lost, and its bytes drawn for nothing.
            period_ns = max(period_ns, character_ns(count, place.segment.baud_of(place.station)))
        place.group.at(now_ns + period_ns, partial(self._babble, number, fault, place, chance))

    def _renew(self, group: Group, device: Device, layer: str, now_ns: SimTimeNs) -> None:
        """Make a board and its axis what all the faults that are in force on them say; one of ``layer`` has
        begun or ended."""
        here = {number: fault for number, (fault, at) in self._in_force.items() if at.device is device}
        supply_V = device.axis.nominal_supply_V
        state = axis_state(here.values(), supply_V)
        before = self._axis_states.get(device) or axis_state((), supply_V)
        for what, value in state.items():
            if value != before[what]:
                device.axis.fault(what, value)
        self._axis_states[device] = state
        off = [number for number, fault in here.items() if fault.kind == "node_brown_out"]
        device.power(f"no power (fault {off[0]})" if off else None, now_ns)
        device.is_hung = any(fault.kind == "node_hang" for fault in here.values())
        if layer == "node":
            device.step(now_ns)
            group.note_due(device)


def _ways(fault: Fault, place: Place) -> list[dict[int, ByteFaults]]:
    """The directions that a fault of a port is on."""
    assert place.uart
    rx, tx = place.uart.rx_faults, place.uart.tx_faults
    if fault.kind == "host_close":
        return [rx, tx]
    return [rx] if fault.parameters.get("towards") == "board" else [tx]


def _byte_faults(fault: Fault) -> ByteFaults:
    if fault.layer == "host":
        return ByteFaults(byte_fault("byte_drop", 1.0), 0)
    delay_ns = round(float(fault.parameters.get("delay_ms", 0)) * NS_PER_MS)
    effect = byte_fault(fault.kind, fault.number("rate"), delay_ns)
    return ByteFaults(effect, int(fault.number("seed")))


def _happen(fault: Fault, place: Place, now_ns: SimTimeNs) -> None:
    """What happens once, and is over."""
    assert place.device
    if fault.kind == "steps_lost":
        place.device.axis.fault("shift_rev", fault.number("turn_deg") / 360)
        return
    place.device.apply(Reset(), now_ns)
    place.device.step(now_ns)
    place.group.note_due(place.device)


def _answer(place: Place, at_ns: int, station: str, raw: bytes) -> None:
    assert place.segment
    place.group.at(at_ns, partial(_send, place.segment, station, raw))


def _send(segment: Segment, station: str, raw: bytes, now_ns: SimTimeNs) -> None:
    if segment.has(station):
        segment.transmit(station, now_ns, raw, segment.baud_of(station))
