"""A built bench: its core, groups and devices, in real or in virtual time.

Every input goes through ``give``, which fixes its effective time once and logs it.
"""

from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager, nullcontext
from fractions import Fraction

from hil.core import Core, CoreAxis, Snapshot
from hil.sim.device import Device
from hil.sim.faults import Faults
from hil.sim.group import Group
from hil.sim.input_log import InputLogWriter
from hil.sim.inputs import Clear, Do, Inject, Input, Logged, Stopped
from hil.sim.station import Tap
from hil.vocab.axis_plan import AxisPlan
from hil.vocab.faults import Fault, FaultRefused
from hil.vocab.segment import Segment, SegmentView
from hil.vocab.time import SimTimeNs
from hil.vocab.verbs import Effect, VerbRefused

Listener = Callable[[Device, str, SimTimeNs, bytes], None]
"""Called with everything a device sends: on which serial interface, when its first bit is on the line, and
the bytes."""

LAG_BUCKETS = 40
_NOTHING = nullcontext()


class BenchRuntime:
    """Devices by name. In virtual time the caller says how far (``advance``); in real time the core's
    thread drives the groups, and ``service`` runs what it asks for."""

    def __init__(self, name: str, core: Core) -> None:
        self.name = name
        self.core = core
        self.devices: dict[str, Device] = {}
        self.taps: dict[str, Tap] = {}
        self.faults = Faults(self)
        self._fault_count = 0
        self._segments: dict[str, Segment] = {}
        self.listeners: list[Listener] = []
        self.log: InputLogWriter | None = None
        self.on_refused: Callable[[Device, Do, VerbRefused], None] = lambda device, given, why: None
        """Called when a verb that was to be done later could not be."""
        self.turn_over: Callable[[], None] = lambda: None
        """Real time: called when firmware may have run, for whatever reason, and its group was given back:
        what it sent has to go on, and what it took has made room."""
        self.turn: Callable[[], Callable[[], bool] | None] = lambda: None
        """Real time: a group's turn begins; what it answers says when it is over. A group that is late goes
        on in its next turn, and others have theirs between. One whose firmware takes more time than there is
        falls behind for ever; its inputs then take effect at the time it has reached."""
        self.real_time = False
        self.lag = [0] * LAG_BUCKETS
        """How late firmware ran, in real time: bucket b counts lags of [2^(b-1), 2^b) ns."""
        self.lag_total_ns = 0
        self._epochs: dict[str, int] = {}
        """How often a verb ended the motions of a device."""
        self._groups: dict[int, Group] = {}
        self._group_of: dict[str, Group] = {}
        self._segment_of: dict[tuple[str, str], Segment] = {}
        self._now_ns = SimTimeNs(0)

    @property
    def now_ns(self) -> SimTimeNs:
        """Virtual time: how far the bench was taken. Real time: what the wall's time asks for."""
        return SimTimeNs(self.core.native.rt_now()) if self.real_time else self._now_ns

    def open_group(self, plan: AxisPlan) -> tuple[Group, CoreAxis]:
        """A group of its own for a device with one axis."""
        group = self._empty_group()
        return group, self.core.open_axis(group.id, plan)

    def join_group(self, device: str, plan: AxisPlan) -> tuple[Group, CoreAxis]:
        """An axis in another device's group, for a device that is wired to it."""
        group = self._group_of[device]
        return group, self.core.open_axis(group.id, plan)

    def add(self, group: Group, device: Device) -> None:
        """The device's firmware starts now."""
        group.add(device)
        device.on_stopped = self._device_stopped
        self.devices[device.name] = device
        self._group_of[device.name] = group

    def _device_stopped(self, device: Device, at_ns: SimTimeNs, stopped: Stopped) -> None:
        if self.log:
            self.log.write(Logged(at_ns, device.name, stopped))

    def set_going(self, device: Device) -> None:
        """A device that was added to a bench that runs: its firmware starts at the present, and in real time
        the core's thread gets its group."""
        group = self._group_of[device.name]
        now_ns = self.now_ns
        self.core.native.advance(group.id, now_ns, now_ns)  # so far nothing has happened in it
        group.advance(now_ns)
        if self.real_time:
            group.give_back()
            self.turn_over()

    def remove(self, name: str) -> None:
        """Take a device away that has a group of its own, with its faults."""
        group, device = self._group_of.pop(name), self.devices.pop(name)
        with self._owning(group):
            self.faults.forget(name)
            device.close()
        self.discard(group)

    def discard(self, group: Group) -> None:
        """Close a group; none of its devices is in the bench."""
        self.core.native.group_close(group.id)
        del self._groups[group.id]

    def sent(self, device: Device, port: str, at_ns: SimTimeNs, data: bytes) -> None:
        """A device's UART sends; its ``sent`` callback."""
        if segment := self._segment_of.get((device.name, port)):
            segment.transmit(f"{device.name}.{port}", at_ns, data, device.uarts[port].baud or 0)
        for listener in self.listeners:
            listener(device, port, at_ns, data)

    def join_segment(self, segment: Segment, device: Device, port: str) -> None:
        """Put a device's serial interface on a segment; all devices of one are in one group."""
        name, uart = f"{device.name}.{port}", device.uarts[port]
        self._segment_of[device.name, port] = segment
        segment.join(name, uart)
        uart.address_changed = lambda: segment.set_address(name, uart.address)
        uart.busy_flag = (segment.busy, name)

    @property
    def segments(self) -> Mapping[str, SegmentView]:
        """By their names, for whoever looks."""
        return self._segments

    def segment(self, name: str) -> Segment:
        """For what happens in its group's time."""
        return self._segments[name]

    def group_for(self, devices: Iterable[str]) -> Group:
        """The group of devices that a segment joins; a new one for a segment of taps alone."""
        return next((self._group_of[name] for name in devices), None) or self._empty_group()

    def add_segment(self, name: str, segment: Segment, group: Group) -> None:
        """A segment without stations, which lives in the time of a group."""
        self._segments[name] = segment
        self._group_of[name] = group

    def add_tap(self, tap: Tap, group: Group) -> None:
        """A tap on a segment of this group."""
        self._group_of[tap.name] = group
        self.taps[tap.name] = tap
        tap.at = group.at
        tap.segment.join(tap.name, tap)

    def _empty_group(self) -> Group:
        group = Group(self.core, self.core.native.group_open(self.now_ns))
        self._groups[group.id] = group
        return group

    def group_of(self, name: str) -> Group:
        """Of a device, a tap or a segment."""
        return self._group_of[name]

    def segment_of(self, device: str, uart: str) -> Segment | None:
        """What a device's serial interface is on."""
        return self._segment_of.get((device, uart))

    def inject(self, fault: Fault) -> int:
        """A fault begins; its number.

        Raises:
            FaultRefused: it cannot be where it is wanted.
        """
        self.faults.check(fault)
        self.faults.check_sum(fault)
        number = self.new_fault_number()
        self.give_fault(fault.target, Inject(number, fault.kind, tuple(fault.parameters.items())))
        return number

    def new_fault_number(self) -> int:
        """One that no other fault of this bench has."""
        self._fault_count += 1
        return self._fault_count

    def clear_fault(self, number: int) -> None:
        """A fault ends.

        Raises:
            FaultRefused: there is none of this number.
        """
        if number not in self.faults.active:
            active = ", ".join(map(str, self.faults.active)) or "none"
            raise FaultRefused(f"there is no fault {number}; there are: {active}")
        self.give_fault(self.faults.active[number].target, Clear(number))

    def give_fault(
        self, target: str, given: Inject | Clear, arrival_ns: SimTimeNs | None = None
    ) -> SimTimeNs:
        """A fault's input takes effect, as ``give``."""
        group = self.group_of(target.partition(".")[0] if target not in self.taps else target)
        with self._owning(group):
            group.advance(self.now_ns if arrival_ns is None else arrival_ns, self.turn())
            at_ns = group.now_ns
            if self.log:
                self.log.write(Logged(at_ns, target, given))
            if isinstance(given, Inject):
                self.faults.inject(given.number, Fault(given.kind, target, dict(given.parameters)), at_ns)
            else:
                self.faults.clear(given.number, at_ns)
            group.advance(at_ns)
        return at_ns

    def give_tap(self, tap: Tap, given: Input) -> SimTimeNs:
        """A client's bytes at a tap take effect, as ``give``."""
        return self.give_tap_at(tap, given, self.now_ns)

    def give_tap_at(self, tap: Tap, given: Input, arrival_ns: SimTimeNs) -> SimTimeNs:
        """As ``give_tap``, for an input that arrives at ``arrival_ns``."""
        group = self._group_of[tap.name]
        with self._owning(group):
            group.advance(arrival_ns, self.turn())
            at_ns = group.now_ns
            if self.log:
                self.log.write(Logged(at_ns, tap.name, given))
            tap.apply(given, at_ns)
            group.advance(at_ns)
        return at_ns

    def give(self, device: Device, given: Input) -> SimTimeNs:
        """An input from outside takes effect: at its arrival, or at the time its group has reached if
        that is later. Answers the effective time."""
        return self.give_at(device, given, self.now_ns)

    def do(
        self, device: Device, verb: str, parameters: Mapping[str, float | str]
    ) -> tuple[SimTimeNs, Mapping[str, float | str | int]]:
        """A verb of the device's table is carried out, as ``give``; its time, and what it answers.

        Raises:
            VerbRefused: it was not.
        """
        at_ns = self.give(device, Do(verb, tuple(parameters.items())))
        if isinstance(device.answer, VerbRefused):
            raise device.answer
        return at_ns, device.answer

    def _epoch(self, device: Device) -> tuple[int, int]:
        """Power that comes anew, and a verb that ends motions, end those too that were to come."""
        return self._epochs.get(device.name, 0), device.power_ups

    def _do_later(self, group: Group, device: Device, given: Do, epoch: tuple[int, int]) -> None:
        if epoch != self._epoch(device):
            return
        group.apply(device, given)
        if isinstance(device.answer, VerbRefused):
            self.on_refused(device, given, device.answer)

    def give_at(self, device: Device, given: Input, arrival_ns: SimTimeNs) -> SimTimeNs:
        """As ``give``, for an input that arrives at ``arrival_ns``."""
        group = self._group_of[device.name]
        with self._owning(group):
            group.advance(arrival_ns, self.turn())
            at_ns = group.now_ns
            if self.log:
                self.log.write(Logged(at_ns, device.name, given))
            if isinstance(given, Do) and given.at_ns is not None and given.at_ns > at_ns:
                epoch = self._epoch(device)
                group.at(given.at_ns, lambda now_ns: self._do_later(group, device, given, epoch))
            else:
                if isinstance(given, Do) and device.verbs[given.verb].effect == Effect.ENDS:
                    self._epochs[device.name] = self._epochs.get(device.name, 0) + 1
                group.apply(device, given)
            group.advance(at_ns)  # leaves the horizon of what the firmware waits for now
        return at_ns

    def watch(self, device: str, slot: int, interval_ns: int | Fraction, capacity: int) -> None:
        """Sample a device's axis from now on; ``CoreAxis.watch``."""
        with self._looking_at(self._group_of[device]):
            self.devices[device].axis.watch(slot, interval_ns, capacity)

    def snapshot(self, device: str) -> Snapshot:
        """A device's axis now."""
        group = self._group_of[device]
        with self._owning(group):
            group.advance(self.now_ns, self.turn())
            return self.devices[device].axis.snapshot()

    def take_samples(self, device: str, slot: int) -> tuple[list[bytes], int]:
        """A device's samples since the last call, in the binary layout, and how many were lost since
        ``watch``."""
        with self._looking_at(self._group_of[device]):
            axis = self.devices[device].axis
            return axis.take_samples(slot), axis.lost_samples(slot)

    def advance(self, until_ns: SimTimeNs) -> None:
        """Virtual time: take every group to ``until_ns``."""
        for group in self._groups.values():
            group.advance(until_ns)
        self._now_ns = max(self._now_ns, until_ns)

    def take_to(self, device: Device, until_ns: SimTimeNs) -> None:
        """Virtual time: take one device's group to ``until_ns``."""
        self._group_of[device.name].advance(until_ns)

    def known_ns(self, name: str) -> SimTimeNs:
        """Up to when it is decided what was on the line of a tap: its group may be behind the present."""
        group = self._group_of[name]
        with self._owning(group):
            return group.wait_until(self.now_ns)

    def run_real_time(self, period_ns: int, speed: float, priority: int, cpu: int) -> None:
        """Hand the groups to the core's real-time thread; simulated time 0 is now.

        Raises:
            OSError: no thread could be started at all.
        """
        self.core.native.rt_start(period_ns, speed, priority, cpu)
        self.real_time = True
        for group in self._groups.values():
            group.advance(SimTimeNs(0))
            group.give_back()
        self.turn_over()

    def service(self) -> None:
        """Real time: run the firmware of every group that the core has parked or has events of."""
        for group_id in self.core.native.take_due():
            group = self._groups[group_id]
            with group:
                now_ns = self.now_ns
                due_ns = group.due_ns
                if due_ns <= now_ns:
                    self.lag[min((now_ns - due_ns).bit_length(), LAG_BUCKETS - 1)] += 1
                    self.lag_total_ns += now_ns - due_ns
                group.advance(now_ns, self.turn())
        self.turn_over()

    def stop(self) -> None:
        """End the real-time thread; the groups are the caller's again."""
        if self.real_time:
            self._now_ns = self.now_ns
            self.core.native.rt_stop()
            self.real_time = False

    def _owning(self, group: Group) -> AbstractContextManager[object]:
        """Its firmwares may run for as long as the block lasts."""
        return _Turn(group, self.turn_over) if self.real_time else _NOTHING

    def _looking_at(self, group: Group) -> AbstractContextManager[object]:
        """The same for a block in which none of its firmwares runs."""
        return group if self.real_time else _NOTHING


class _Turn:
    """A group is owned, in real time; ``over`` is called when it is given back."""

    __slots__ = ("_group", "_over")

    def __init__(self, group: Group, over: Callable[[], None]) -> None:
        self._group = group
        self._over = over

    def __enter__(self) -> None:
        self._group.__enter__()

    def __exit__(self, *error: object) -> None:
        self._group.__exit__(*error)
        self._over()
