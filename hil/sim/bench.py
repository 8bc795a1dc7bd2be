"""A built bench: core, groups and devices, in real or in virtual time.

Every input goes through ``BenchRuntime.apply_input``, which fixes its effective time once, and logs it.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any, ClassVar, Protocol

from hil.core import Core, Snapshot
from hil.core.fields import TABLE
from hil.sim.bench_parts import BenchParts
from hil.sim.card import Card
from hil.sim.client_tap import ClientTap
from hil.sim.faults.in_force import Faults
from hil.sim.firmware_guard import UNGUARDED, Guard
from hil.sim.group import Group
from hil.sim.groups_together import HeardLine, advance_together, advance_until_heard
from hil.sim.hardware import DeviceSpec
from hil.sim.input_log import InputLogSink
from hil.sim.inputs import Attach, Clear, CommitDone, Do, Inject, Input, Logged
from hil.sim.real_time_clock import RealTimeClock
from hil.sim.twin import Home, Twin
from hil.sim.verb_calls import Answer, axes_of
from hil.vocab.address import address_of
from hil.vocab.axis_plan import AxisPlan
from hil.vocab.faults import Fault
from hil.vocab.segment import SegmentView
from hil.vocab.time import SimTimeNs
from hil.vocab.verbs import Effect, VerbRefused
from hil.vocab.wire import Wire


class Store(Protocol):
    """Store of devices' non-volatile memories."""

    def commit(
        self, device: Twin, sections: Mapping[str, bytes], answered: Callable[[bool], bool]
    ) -> bool | None:
        """Make ``sections`` the device's whole non-volatile memory. Returns whether they are durable; or
        None, and then ``answered`` has to be called with it, once: an input, with a time of its own. It
        returns whether the device was still there to be told."""


@dataclass(frozen=True)
class BenchHooks:
    """Callbacks from a bench to the world around it. The defaults are for virtual time: nobody watches over
    firmwares, waits for a turn's end, or logs."""

    turn_over: Callable[[], None] = lambda: None
    """Real time: called when firmware may have run, for whatever reason, and its group was given back:
    what it sent has to go on, and what it took has made room."""
    turn: Callable[[], Callable[[], bool] | None] = lambda: None
    """Real time: called when a group's turn begins; answers a function that says whether it is over. A group
    that is late goes on in its next turn, and others have theirs between. A group whose firmware takes more
    time than there is falls behind forever; its inputs then take effect at the time it has reached."""
    guard: Guard = UNGUARDED
    """Guard around each turn of a firmware's own code."""
    on_failed: Callable[[Twin], None] = lambda device: None
    """Called once when a device has stopped; ``Twin.failed`` says why."""
    log: InputLogSink | None = None
    """Receives all inputs with their effective times, and all that devices send."""
    hold: Callable[[str, Input], bool] | None = None
    """Called with the target of each input that would take effect now, and the input; True: it is held back,
    and will come at another time."""


VIRTUAL = BenchHooks()


Refused = Callable[[VerbRefused], None]


class LaterVerbs:
    """Verbs to be carried out later. A power-up, or a verb that ends motions, cancels those of its device."""

    def __init__(self) -> None:
        self._ends = Counter[tuple[str, str]]()
        """Number of verbs that ended the motions of an axis, by device and axis."""

    def note(self, device: Twin, part: str, given: Do) -> None:
        verb = device.verbs[given.verb]
        if verb.effect == Effect.ENDS:
            for axis in axes_of(device.axes, verb, part) or [""]:
                self._ends[device.name, axis] += 1

    def add(self, group: Group, device: Twin, part: str, given: Do, at_ns: int, on_refused: Refused) -> None:
        """Carry out a verb at a time that has not come; ``on_refused`` is called if it cannot be."""
        epoch = self._epoch(device, part)

        def due(now_ns: SimTimeNs) -> None:
            if epoch == self._epoch(device, part):
                try:
                    group.apply(device, given, part)
                except VerbRefused as refusal:
                    on_refused(refusal)

        group.at(at_ns, due)

    def _epoch(self, device: Twin, part: str) -> tuple[int, int]:
        return self._ends[device.name, part or device.axes.first], device.power.ups


class BenchRuntime:
    """Devices of a bench, by name. In virtual time the caller says how far (``advance``); in real time the
    core's thread drives the groups (``drive``).

    Long because it is the face of simulated time: all inputs and all looks come in here, one short method
    each.
    """

    check_input: ClassVar["staticmethod[[BenchRuntime, Logged], None] | None"] = None
    """Called with each input before it is logged. Tests have ``input_check.assert_taken_back`` here: a replay
    has to take what is logged."""

    def __init__(self, name: str, core: Core, store: Store, around: BenchHooks) -> None:
        self.name = name
        self.core = core
        self.parts = BenchParts()
        self.devices: Mapping[str, Twin] = self.parts.devices
        self.taps: Mapping[str, ClientTap] = self.parts.taps
        self.cards: Mapping[str, Card] = self.parts.cards
        self.wires: Mapping[str, Wire] = self.parts.wires
        self.faults = Faults(self.parts)
        self._groups: dict[int, Group] = {}
        self.real_time = RealTimeClock(core, self._groups, around.turn_over, around.turn)
        self.log = around.log
        self._around = around
        self._store = store
        self._later = LaterVerbs()
        self._now_ns = SimTimeNs(0)

    @property
    def now_ns(self) -> SimTimeNs:
        """Present time: virtual, where the bench was advanced to; real, what the wall's time asks for."""
        return self.real_time.now_ns if self.real_time.is_on else self._now_ns

    # ---- what it consists of ----

    def wires_of(self, kind: str) -> dict[str, Any]:
        """Wires of a bus, by the key of a configuration under which they stand."""
        return {name: wire for name, wire in self.wires.items() if wire.kind == kind}

    @property
    def segments(self) -> Mapping[str, SegmentView]:
        """RS485 segments, as read-only views."""
        return self.wires_of("segments")

    def cards_on(self, wire: object) -> dict[str, Any]:
        """Cards on a wire, by name."""
        return {name: card for name, card in self.cards.items() if card.wire is wire}

    def open_group(self, at_ns: SimTimeNs | None = None) -> Group:
        """Open a group without devices, by default at the present."""
        group = Group(self.core, self.core.native.group_open(self.now_ns if at_ns is None else at_ns))
        self._groups[group.id] = group
        return group

    def discard(self, group: Group) -> None:
        """Close a group, of which no device is in the bench."""
        self.core.native.group_close(group.id)
        del self._groups[group.id]

    def make(self, spec: DeviceSpec, plans: Mapping[str, AxisPlan], group: Group) -> Twin:
        """Make a device with its axes, planned by name, for a group; ``add`` puts it there."""
        around = self._around
        home = Home(around.guard, self._commit, around.on_failed, self._note, group.note_due)
        axes = {name: self.core.open_axis(group.id, plan) for name, plan in plans.items()}
        device = Twin(spec, axes, home)
        if self.log:
            for name, uart in device.uarts.items():
                uart.listeners.append(partial(self.log.sent, device, name))
        return device

    def add(self, group: Group, device: Twin) -> None:
        """Add a device to its group; its firmware starts now."""
        group.add(device)
        self.parts.add_device(device, group)

    def add_card(self, card: Card) -> None:
        """Add the card of an axis, which is on a wire in its device's group."""
        self.parts.add_card(card)
        if self.log:
            card.listeners.append(partial(self.log.sent, card.device, address_of(card.name).part))

    def set_going(self, device: Twin, now_ns: SimTimeNs) -> None:
        """Start a device that was added to a bench that runs, at the present: its firmware starts, and in
        real time the core's thread gets its group."""
        group = self.parts.group_of(device.name)
        self.core.native.advance(group.id, now_ns, now_ns)  # so far nothing has happened in it
        self.real_time.hand_over([group], now_ns)

    def remove(self, name: str) -> None:
        """Remove a device that has a group of its own, with its faults."""
        self.devices[name].debugger.removed()
        device, group = self.parts.remove_device(name)
        with self.real_time.owning(group):
            self.faults.forget(name, device.axes.values())
            device.power.close()
        self.discard(group)

    def _commit(self, device: Twin, sections: Mapping[str, bytes]) -> bool | None:
        durable = self._store.commit(device, sections, partial(self._answered, device))
        if durable is not None:
            now_ns = self.parts.group_of(device.name).now_ns
            self._note(device, now_ns, CommitDone(durable, at_once=True))
        return durable

    def _answered(self, device: Twin, durable: bool) -> bool:
        # A reload may have put another device in its place, under the same name.
        is_here = self.devices.get(device.name) is device
        if is_here:
            self.apply_to(device, CommitDone(durable))
        return is_here

    # ---- inputs ----

    def _note(self, device: Twin, at_ns: SimTimeNs, what: Input) -> None:
        """Write down what came to a device beside its inputs."""
        self._write(at_ns, device.name, what)

    def _write(self, at_ns: SimTimeNs, target: str, given: Input) -> None:
        if self.check_input:
            self.check_input(self, Logged(at_ns, target, given))
        if self.log:
            self.log.write(Logged(at_ns, target, given))

    def apply_input(
        self,
        target: str,
        given: Input,
        arrival_ns: SimTimeNs | None = None,
        on_refused: Refused = lambda refusal: None,
    ) -> tuple[SimTimeNs, Answer]:
        """Let an input from outside take effect at a target's address: at its arrival, by default now, or at
        the time its group has reached if that is later. Returns the effective time, and a verb's answer.
        ``on_refused`` is called when a verb that is to be done later cannot be.

        Raises:
            VerbRefused: a verb or a path was not carried out.
        """
        if arrival_ns is None and self._around.hold and self._around.hold(target, given):
            return self.now_ns, {}
        group = self.parts.group_of(target)
        with self.real_time.owning(group):
            at_ns = group.advance(self.now_ns if arrival_ns is None else arrival_ns, self.real_time.turn())
            # Before it takes effect: one that is refused, or stops the device, is an input of a replay too.
            self._write(at_ns, target, given)
            try:
                return at_ns, self._apply(group, target, given, at_ns, on_refused)
            finally:
                group.advance(at_ns)  # leaves the horizon of what the firmware waits for now

    def _apply(
        self, group: Group, target: str, given: Input, at_ns: SimTimeNs, on_refused: Refused
    ) -> Answer:
        if isinstance(given, (Inject, Clear)):
            self.faults.apply(target, given, at_ns)
            return {}
        if isinstance(given, Attach):
            self.parts.attach(target, given.node).apply(given, at_ns)
            return {}
        if target in self.taps:
            self.taps[target].apply(given, at_ns)
            return {}
        part = ""
        if (device := self.devices.get(target)) is None:
            name, part = address_of(target)
            device = self.devices[name]
        if isinstance(given, Do):
            if given.at_ns is not None and given.at_ns > at_ns:
                self._later.add(group, device, part, given, given.at_ns, on_refused)
                return {}
            self._later.note(device, part, given)
        return group.apply(device, given, part)

    def apply_to(self, to: Twin | ClientTap, given: Input, part: str = "") -> SimTimeNs:
        """Let an input take effect now; answers its effective time. ``part``: name of the axis it is for."""
        target = to.axes.label(to.name, part) if part and isinstance(to, Twin) else to.name
        return self.apply_input(target, given)[0]

    def do_verb(
        self, device: Twin, verb: str, parameters: Mapping[str, float | str], part: str = ""
    ) -> tuple[SimTimeNs, Answer]:
        """Carry out a verb of the device's table now. ``part``: name of the axis asked.

        Raises:
            VerbRefused: it was not carried out.
        """
        return self.apply_input(device.axes.label(device.name, part), Do(verb, tuple(parameters.items())))

    def inject(self, fault: Fault) -> int:
        """Begin a fault; answers its number.

        Raises:
            FaultRefused: it cannot be where it is wanted.
        """
        self.faults.check(fault, with_others=True)
        number = self.faults.new_number()
        self.apply_input(fault.target, Inject(number, fault.kind, tuple(fault.parameters.items())))
        return number

    def clear_fault(self, number: int) -> None:
        """End a fault.

        Raises:
            FaultRefused: there is none of this number.
        """
        self.apply_input(self.faults.listed(number).target, Clear(number))

    def apply_unlogged(self, target: str, given: Input) -> Answer:
        """Let what the simulated world itself does to a device, as a node does, take effect at the time that
        its group has reached: no input from outside, and in no log. Returns a verb's answer.

        Raises:
            VerbRefused: as ``apply_input``.
        """
        group = self.parts.group_of(target)
        return self._apply(group, target, given, group.now_ns, lambda refusal: None)

    # ---- looking ----

    @contextmanager
    def present(self, device: Twin) -> Iterator[Group]:
        """Own a device's group, at the present, for a block that looks into the device."""
        group = self.parts.group_of(device.name)
        with self.real_time.owning(group):
            group.advance(self.now_ns, self.real_time.turn())
            yield group

    def watch(
        self, axis: str, slot: int, interval_ns: int | Fraction, capacity: int, points: int = 1
    ) -> None:
        """Sample the axis at an address from now on; ``CoreAxis.watch``."""
        with self.real_time.looking_at(self.parts.group_of(axis)):
            self.parts.axis(axis).watch(slot, interval_ns, capacity, points)

    def table_names(self, axis: str, fields: Iterable[str]) -> list[str]:
        """Names in the core's table of fields of the axis at an address, which may have names of its own."""
        at = self.parts.axis(axis)
        return [TABLE[at.index(field)].name for field in fields]

    def snapshot(self, axis: str) -> Snapshot:
        """State of the axis at an address. Raises KeyError: there is none."""
        group, at = self.parts.group_of(axis), self.parts.axis(axis)
        with self.real_time.owning(group):
            group.advance(self.now_ns, self.real_time.turn())
            return at.snapshot()

    def take_samples(self, axis: str, slot: int) -> tuple[list[bytes], int]:
        """Samples of the axis at an address since the last call, in the binary layout, and the losses since
        ``watch``. They wait in the core: its thread is not held up."""
        at = self.parts.axis(axis)
        return at.take_samples(slot), at.lost_samples(slot)

    def known_ns(self, name: str) -> SimTimeNs:
        """Time up to which the traffic at a tap is decided: its group may be behind the present."""
        group = self.parts.group_of(name)
        with self.real_time.owning(group):
            return group.wait_until(self.now_ns)

    # ---- time ----

    def advance(self, until_ns: SimTimeNs) -> None:
        """Take every group to ``until_ns``, in virtual time. What their firmwares do comes in the order of
        times, and at one time in that of the devices of which each group has the first."""
        groups = [*self._groups.values()]
        if len(groups) == 1:
            groups[0].advance(until_ns)
        elif groups:
            advance_together(self.core, groups, until_ns)
        self._now_ns = max(self._now_ns, until_ns)

    def advance_until_heard(self, limit_ns: SimTimeNs, lines: Sequence[HeardLine]) -> None:
        """Take every group to the time of the next byte at one of some lines, no further than a limit, in
        virtual time. No lines: to the limit."""
        now_ns = self._now_ns
        if lines:
            groups = [*dict.fromkeys(self.parts.group_of(line.address) for line in lines)]
            for group in groups:
                if group.now_ns < now_ns:
                    group.advance(now_ns)
            self._now_ns = advance_until_heard(groups, lines, limit_ns)
            if len(groups) == len(self._groups):
                return
            limit_ns = self._now_ns
        self.advance(limit_ns)

    def stop(self) -> None:
        """End the real-time thread, if it runs; the groups are the caller's again."""
        if self.real_time.is_on:
            self._now_ns = self.now_ns
            self.real_time.stop()
