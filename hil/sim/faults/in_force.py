"""Faults of a bench: where they may be, when they begin and end."""

from collections.abc import Iterable
from functools import partial

from hil.core import CoreAxis
from hil.sim.bench_parts import BenchParts, FaultPlace
from hil.sim.faults import node
from hil.sim.faults.physics import AxisFaults, renew_switch
from hil.sim.inputs import Clear, Inject
from hil.sim.load_limit import load_problem
from hil.vocab.address import owner_of
from hil.vocab.faults import FAULT_KINDS, LACKS, OWN_FIELD, Fault, FaultRefused
from hil.vocab.near_words import meant
from hil.vocab.time import NS_PER_S, SimTimeNs
from hil.wire.byte_faults import ByteFault, ByteFaults, byte_faults

LOAD = "shaft_load"


class Faults:
    """Faults that were injected into a bench, by their numbers."""

    def __init__(self, parts: BenchParts) -> None:
        self._parts = parts
        self._count = 0
        self._in_force: dict[int, tuple[Fault, FaultPlace]] = {}
        """Faults in force, in the order in which they began."""
        self._axes = AxisFaults()
        self.active: dict[int, Fault] = {}
        """Faults that are listed: in force, or still to begin."""
        self.begin_ns: dict[int, SimTimeNs] = {}
        """Times at which these began or will begin."""

    def listed(self, number: int) -> Fault:
        """A fault that is in force or still to begin.

        Raises:
            FaultRefused: there is none of this number.
        """
        if number not in self.active:
            active = ", ".join(map(str, self.active)) or "none"
            raise FaultRefused(f"there is no fault {number}; there are {active}")
        return self.active[number]

    def place(self, target: str) -> FaultPlace:
        """Place that a fault can be at.

        Raises:
            FaultRefused: there is none of this name.
        """
        if (place := self._parts.place(target)) is None:
            raise FaultRefused(f"there is no {target!r}; {meant(target, list(self._parts.targets()))}")
        return place

    def check(self, fault: Fault, *, with_others: bool) -> None:
        """Check that a fault can be where it is wanted. ``with_others``: also beside the loads that are
        there; not for faults from a log, which were accepted when the others may have been different.

        Raises:
            FaultRefused: it cannot, and why.
        """
        place = self.place(fault.target)
        wanted = FAULT_KINDS[fault.kind].target
        if not (place.fits(wanted) if with_others else place.has(wanted)):
            places = {name: self._parts.place(name) for name in self._parts.targets()}
            choice = ", ".join(name for name, p in places.items() if p and p.fits(wanted))
            none = f"this bench has none; `hil fault kinds {fault.kind}` says where it can be"
            there = f"there are {choice}" if choice else none
            lacks = "is a port" if place.has(wanted) else LACKS[wanted]
            raise FaultRefused(f"{fault.kind}: {fault.target} {lacks}; {there}")
        of_wire = place.wire if place.is_wires(wanted) else None
        if of_wire and (problem := of_wire.fault_problem(fault, self.active.values())):
            raise FaultRefused(problem)
        if wanted == OWN_FIELD and place.axis:
            known, name = place.axis.kind.board_fields, str(fault.parameters["field"])
            if name not in known:
                raise FaultRefused(f"field: {fault.target} has no {name!r}; {meant(name, known)}")
        if fault.kind == LOAD and (axis := place.axis):
            torque_Nm = fault.number("torque_Nm")
            problem = load_problem(torque_Nm, axis.holding_Nm)
            if with_others and not problem:
                others_Nm = [axis.set_load_Nm, *self._loads_Nm(axis)]
                problem = load_problem(torque_Nm, axis.holding_Nm, others_Nm)
            if problem:
                raise FaultRefused(f"torque_Nm: {problem}")

    def load_problem(self, axis: CoreAxis, torque_Nm: object) -> str | None:
        """Error text for a torque to be set on an axis's shaft, or None."""
        return load_problem(torque_Nm, axis.holding_Nm, self._loads_Nm(axis))

    def _loads_Nm(self, axis: CoreAxis) -> list[float]:
        """Loads of the faults on an axis, in force or still to begin."""
        loads = (
            (fault, self._parts.place(fault.target)) for fault in self.active.values() if fault.kind == LOAD
        )
        return [fault.number("torque_Nm") for fault, place in loads if place and place.axis is axis]

    def new_number(self) -> int:
        """New number, which no other fault of this bench has."""
        self._count += 1
        return self._count

    def apply(self, target: str, given: Inject | Clear, now_ns: SimTimeNs) -> None:
        if isinstance(given, Inject):
            self.inject(given.number, Fault(given.kind, target, dict(given.parameters)), now_ns)
        else:
            self.clear(given.number, now_ns)

    def inject(self, number: int, fault: Fault, now_ns: SimTimeNs) -> None:
        """Begin a fault now or later, as an input. ``check`` has found it good."""
        place = self._parts.place(fault.target)
        assert place
        self._count = max(self._count, number)  # one of a log: new ones come behind it
        self.active[number] = fault
        begin_ns = SimTimeNs(now_ns + _ns(fault, "start_s"))
        self._schedule(number, fault, place, begin_ns, now_ns)

    def _schedule(
        self, number: int, fault: Fault, place: FaultPlace, begin_ns: SimTimeNs, now_ns: SimTimeNs
    ) -> None:
        """Let a fault begin at a time, and end when its own is over."""
        self.begin_ns[number] = begin_ns
        if begin_ns > now_ns:
            place.group.at(begin_ns, partial(self._begin, number, fault, place))
        else:
            self._begin(number, fault, place, now_ns)
        if for_ns := _ns(fault, "for_s"):
            place.group.at(begin_ns + for_ns, partial(self._over, number, fault, place, begin_ns))

    def _over(
        self, number: int, fault: Fault, place: FaultPlace, begin_ns: SimTimeNs, now_ns: SimTimeNs
    ) -> None:
        """End a fault whose time is over: for good, or until it comes again."""
        if not (every_ns := _ns(fault, "every_s")):
            self.clear(number, now_ns)
        elif number in self.active:
            if begun := self._in_force.pop(number, None):
                self._end(number, *begun, now_ns)
            self._schedule(number, fault, place, SimTimeNs(begin_ns + every_ns), now_ns)

    def clear(self, number: int, now_ns: SimTimeNs) -> None:
        """End a fault, or cancel its beginning: by an input, or because its time is over."""
        self._unlist(number)
        if begun := self._in_force.pop(number, None):
            self._end(number, *begun, now_ns)

    def forget(self, name: str, axes: Iterable[CoreAxis]) -> None:
        """Remove the faults of a device that goes, with its axes."""
        self._axes.forget(axes)
        for number, fault in list(self.active.items()):
            if owner_of(fault.target) == name and fault.target not in self._parts.taps:
                self._unlist(number)
                self._in_force.pop(number, None)

    def _unlist(self, number: int) -> None:
        self.active.pop(number, None)
        self.begin_ns.pop(number, None)

    def _begin(self, number: int, fault: Fault, place: FaultPlace, now_ns: SimTimeNs) -> None:
        if number not in self.active:
            return
        kind = FAULT_KINDS[fault.kind]
        if kind.is_once:
            if not (every_ns := _ns(fault, "every_s")):
                self._unlist(number)
            if place.wire and place.is_wires(kind.target):
                place.wire.inject(number, fault, place.station)
            else:
                node.happen(fault, place, now_ns)
            if every_ns:
                self._schedule(number, fault, place, SimTimeNs(now_ns + every_ns), now_ns)
            return
        self._in_force[number] = fault, place
        if kind.layer in ("byte", "host"):
            for way in _ways(fault, place):
                all_lost = fault.layer == "host"
                way[number] = ByteFaults(ByteFault(drop_rate=1.0), 0) if all_lost else byte_faults(fault)
        elif place.card and place.card.faults and place.is_cards(kind.target):
            place.card.faults.begin(number, fault)
        elif place.wire and place.is_wires(kind.target):
            place.wire.inject(number, fault, place.station)
        elif place.device:
            self._renew(place, kind.layer, now_ns)

    def _end(self, number: int, fault: Fault, place: FaultPlace, now_ns: SimTimeNs) -> None:
        kind = FAULT_KINDS[fault.kind]
        if kind.layer in ("byte", "host"):
            for way in _ways(fault, place):
                del way[number]
        elif place.card and place.card.faults and place.is_cards(kind.target):
            place.card.faults.end(number)
        elif place.wire and place.is_wires(kind.target):
            place.wire.clear(number, fault, place.station)
        elif place.device:
            self._renew(place, kind.layer, now_ns)

    def _renew(self, place: FaultPlace, layer: str, now_ns: SimTimeNs) -> None:
        """Renew a board's state after a fault of ``layer`` on it, an axis or a switch of it has begun or
        ended."""
        assert place.device
        if place.switch:
            renew_switch(place.switch, [f for f, at in self._in_force.values() if at.switch is place.switch])
            return
        here = {number: held for number, held in self._in_force.items() if held[1].device is place.device}
        for axis in place.device.axes.values():
            on_axis = (fault for fault, at in here.values() if at.axis is axis or fault.layer == "node")
            self._axes.renew(axis, on_axis)
        node.renew(place, {number: fault for number, (fault, _) in here.items()}, now_ns)
        if layer == "node":
            node.run(place, now_ns)


def _ns(fault: Fault, name: str) -> int:
    """Time of a parameter; one of a log may be older than the parameter."""
    return round(float(fault.parameters.get(name, 0.0)) * NS_PER_S)


def _ways(fault: Fault, place: FaultPlace) -> list[dict[int, ByteFaults]]:
    assert place.uart
    rx, tx = place.uart.rx_faults, place.uart.tx.faults
    if fault.kind == "host_close":
        return [rx, tx]
    return [rx] if fault.parameters.get("towards") == "board" else [tx]
