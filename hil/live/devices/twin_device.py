"""Twin as a device of a bench."""

import asyncio
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any

from hil.core import CoreAxis
from hil.core.axis_kind import ANGLE
from hil.core.fields import packed
from hil.live.devices.real_device import NO_PORT, port_counters, port_row
from hil.live.devices.twin_processor import TwinProcessor
from hil.live.memory_commits import Commits
from hil.live.motion_wait import motion_ended
from hil.live.places import Places
from hil.live.port_link import PortLink
from hil.live.program_watch import NO_PROGRAMS, ProgramWatch
from hil.live.sim_backends import UartBackend
from hil.runs.twin_axes import TwinAxis
from hil.sim.bench import BenchRuntime
from hil.sim.inputs import Bytes, Input, Pin, PulseTrain, Reset, SetField
from hil.sim.load_limit import motor_notes
from hil.sim.motion_end import BEGINS_NS, BegunMotion
from hil.sim.settable import setting_problem
from hil.sim.twin import Twin
from hil.sim.twin_info import axis_look, board_look, info_of
from hil.telemetry import Sampler, check_signals
from hil.vocab.address import Address, address_of, no_input, no_part
from hil.vocab.axis import Axis, AxisNow, AxisState
from hil.vocab.desk_protocol import AxisLook, DeviceInfo, Done, Watch
from hil.vocab.firmware import NETWORK
from hil.vocab.monitoring import HealthProblem
from hil.vocab.near_words import meant
from hil.vocab.ports import EchoStats
from hil.vocab.profile import Profile
from hil.vocab.verbs import VerbRefused
from hil.wire.step_dir import Edges, train_length_ns


@dataclass(frozen=True)
class TwinHome:
    """Parts of a bench that its twins need. ``notes``: for the operator, by device; ``speed``: simulated
    seconds in one second."""

    sim: BenchRuntime
    places: Places
    commits: Commits
    sampler: Sampler
    notes: Mapping[str, str]
    speed: float


class TwinDevice:
    """Twin, as ``hil.vocab.device.Device``.

    Long because it is the face of all that a twin can do, one short method each.
    """

    is_there: bool | None = None
    faults = None
    is_talking = False
    where = ""

    def __init__(
        self, home: TwinHome, device: Twin, profile: Profile, programs: ProgramWatch = NO_PROGRAMS
    ) -> None:
        self.name = device.name
        self._home, self._sim, self._device, self._programs = home, home.sim, device, programs
        axes = ["", *(axis for axis in device.axes if axis != device.axes.first)]
        self._infos = {axis: info_of(device, axis, profile) for axis in axes}

    # ---- what it is ----

    def addresses(self) -> Iterator[str]:
        return (info.name for info in self._infos.values())

    def info(self, part: str) -> DeviceInfo:
        return self._infos[self._device.axes.short(part)]

    def no_axis(self) -> VerbRefused | None:
        if self._device.axes:
            return None
        return VerbRefused("cannot", f"{self.name}, a {self._device.profile}, has no axis")

    def _at(self, part: str) -> str:
        return self._device.axes.label(self.name, part)

    # ---- what it can be told ----

    def _give(self, part: str, given: Input, answer: Mapping[str, Any] | None = None) -> Done:
        return Done(self._sim.apply_input(self._at(part), given)[0], answer or {})

    def do(self, part: str, verb: str, parameters: Mapping[str, float | str]) -> Done:
        return Done(*self._sim.do_verb(self._device, verb, parameters, part))

    def reset(self) -> Done:
        return Done(self._sim.apply_to(self._device, Reset()), {})

    def set(self, part: str, field: str, value: Any) -> Done:
        fields = self._axis(part).kind.settable
        if field not in fields:
            raise VerbRefused(
                "no_parameter",
                f"{self._at(part)} has no field {field!r} that can be set; {meant(field, fields)}",
            )
        if problem := self._setting_problem(part, field, value):
            raise VerbRefused("bad_parameter", problem)
        return self._give(part, SetField(field, float(value)), {field: value})

    def zero(self, part: str) -> Done:
        if problem := self._setting_problem(part, ANGLE, 0.0):
            raise VerbRefused("not_now", problem)
        shot, kind = self._sim.snapshot(self._at(part)), self._axis(part).kind
        state = kind.motion(shot)
        board_deg = state.position_deg if kind.follows_paths and state.is_on else None
        return self._give(part, SetField(ANGLE, 0.0), {"was_deg": shot.position_deg, "board_deg": board_deg})

    def _setting_problem(self, part: str, field: str, value: Any) -> str | None:
        look = partial(self._sim.snapshot, self._at(part))
        return setting_problem(self._sim.faults, self._device, field, value, part, look)

    def pin(self, part: str, pin: str, level: int) -> Done:
        pins = self._axis(part).pins
        if pin not in pins:
            raise VerbRefused("bad_parameter", "; ".join(no_input(self._at(part), pin, pins)))
        return self._give(part, Pin(pin, level))

    def processor(self) -> TwinProcessor:
        if not self._device.processors:
            raise VerbRefused(
                "cannot", f"{self.name} has no processor that runs a program of yours; {self._with_one()}"
            )
        return TwinProcessor(self._sim, self._device)

    def _with_one(self) -> str:
        """Say which boards of this bench have such a processor."""
        others = ", ".join(name for name, each in self._sim.devices.items() if each.processors)
        return (
            f"a uno has one: {others}"
            if others
            else "a uno has one: add `profile: uno`, `hil docs own-sketch`"
        )

    def drive(self, part: str, train: Sequence[Edges]) -> Done:
        inputs = self._axis(part).pins
        if "step" not in inputs:
            devices = self._sim.devices.items()
            having = [
                name for name, each in devices if any("step" in axis.pins for axis in each.axes.values())
            ]
            there = f"there are {', '.join(having)}" if having else "a Mechaduino has one"
            raise VerbRefused("cannot", f"{self._at(part)} has no step input; {there}")
        if wrong := next((row.pin for row in train if row.pin not in inputs), None):
            raise VerbRefused("cannot", f"{self._at(part)} has no input {wrong}; it has {', '.join(inputs)}")
        return self._give(part, PulseTrain(tuple(train)), {"length_ns": train_length_ns(train)})

    def type(self, part: str, data: bytes) -> Done:
        device, uarts = self._device, self._device.uarts
        if part not in uarts:
            raise VerbRefused("no_device", no_part(self.name, "serial interface", part, uarts))
        if device.failed:
            remedy = "reset it" if device.power.is_there else "end it"
            raise VerbRefused("failed", f"{device.failed}; {remedy}")
        if place := self._home.places.get(uarts.label(self.name, part)):
            return Done(place.backend.type(data), {})
        return Done(self._sim.apply_to(device, Bytes(data, port=uarts.short(part))), {})

    # ---- what it tells ----

    def _axis(self, part: str) -> CoreAxis:
        return self._device.axes[part]

    def state(self, part: str) -> dict[str, float | None]:
        state = self._sim.snapshot(self._at(part)).as_dict()
        return {name: value if abs(value) < float("inf") else None for name, value in state.items()}

    def packed(self, part: str) -> bytes:
        return packed(self._sim.snapshot(self._at(part)).values)

    def look(self, part: str) -> AxisLook:
        if refusal := self.no_axis():
            if self._device.own_map is None:
                raise refusal
            with self._sim.present(self._device):
                return board_look(self._device, self._sim.now_ns)
        return axis_look(self._device, self._axis(part).kind, self._sim.snapshot(self._at(part)))

    async def wait(
        self,
        part: str,
        effective_at_ns: int,
        at_most_s: float,
        ends_after_ns: float | None,
        set_point: float | None,
    ) -> dict[str, bool]:
        sim, speed = self._sim, self._home.speed
        motion = BegunMotion(effective_at_ns, ends_after_ns, set_point)
        end_ns, interval_s = effective_at_ns + (ends_after_ns or 0), BEGINS_NS / 1e9 / speed

        def was_cut_short() -> bool | None:
            if not self._is_here:
                return True  # a reload has taken it away
            return motion.was_cut_short(self._device, self._axis(part), self._motion(part), sim.now_ns)

        def pause_s() -> float:
            return max(min(interval_s, (end_ns - sim.now_ns) / 1e9 / speed), interval_s / 10)

        await asyncio.sleep(interval_s)  # what a main program does begins with its next step
        return await motion_ended(was_cut_short, lambda: sim.now_ns, effective_at_ns, at_most_s, pause_s)

    @property
    def _is_here(self) -> bool:
        return self._sim.devices.get(self.name) is self._device

    def _motion(self, part: str) -> AxisState:
        return self._axis(part).kind.motion(self._sim.snapshot(self._at(part)))

    def watch(
        self, part: str, interval_ns: int | Fraction, points: int, call: Callable[[bytes], object]
    ) -> Watch:
        return Samples(self._home.sampler, self._at(part), interval_ns, points, call)

    def signals(self, part: str, names: Sequence[str]) -> tuple[str, ...]:
        kind = self._axis(part).kind
        return check_signals(names or kind.default_signals, kind)

    # ---- as an axis of runs ----

    def axes(self) -> Mapping[str, AxisNow]:
        labels = [self._at(axis) for axis in self._device.axes]
        return {label: TwinAxis(self._sim, self._home.sampler, label).now() for label in labels}

    def axis(self, part: str) -> Axis:
        return TwinAxis(self._sim, self._home.sampler, self._at(part))

    # ---- how it does ----

    def _links(self) -> Iterator[PortLink[UartBackend]]:
        uarts, links = self._device.uarts, self._home.places
        return (links[label] for uart in uarts if (label := uarts.label(self.name, uart)) in links)

    def counters(self) -> Mapping[str, int]:
        return {}

    def echoes(self) -> Iterator[tuple[str, EchoStats | None]]:
        for link in self._links():
            yield link.label, link.port.stats().echo

    def listed(self, kinds: Mapping[str, str]) -> dict[str, Any]:
        device, links = self._device, list(self._links())
        ports = {
            link.label: {"kind": kinds[link.label], **port_row(link.port)}
            for link in links
            if address_of(link.label).part
        }
        own = next((port_row(link.port) for link in links if link.label == self.name), {})
        network = ports.get(str(Address(self.name, NETWORK)), {"address": None, "clients": 0})
        return own | {
            "network": network["address"],
            "network_clients": network["clients"],
            "ports": ports,
            "axes": [self._at(axis) for axis in device.axes],
            "failed": device.failed,
        }

    def status(self) -> dict[str, Any]:
        home, device = self._home, self._device
        place = home.places.get(self.name)
        motors = {axis: each for axis, each in device.axes.items() if each.kind.has_motor}
        shots = {axis: each.published().as_dict() for axis, each in motors.items()}
        own = home.notes.get(self.name)
        notes = [*([own] if own else []), *device.notes.values(), *self._motor_notes(shots)]
        notes += self._programs.notes()
        first = device.axes.first
        return {
            **port_counters(place.port.stats() if place else NO_PORT),
            "backlog_bytes": place.port.backlog() if place else 0,
            "overrun_bytes": sum(uart.overrun_bytes for uart in device.uarts.values()),
            "note": "; ".join(notes) or None,
            "flash": home.commits.failures.get(self.name, "ok"),
            "port_failure": place.failure if place else None,
            "snapshot": shots.get(first),
            "snapshots": {self._at(axis): shot for axis, shot in shots.items() if axis != first},
            **self._own_fields(),
        }

    def _own_fields(self) -> dict[str, Any]:
        """Row of the board's own fields, by name; nothing where it has none."""
        if not self._device.axes or not (own := self._device.axis.kind.board_fields):
            return {}
        shot = self._device.axis.published().as_dict()
        return {"fields": {name: shot[name] for name in own}}

    def _motor_notes(self, shots: Mapping[str, Mapping[str, float]]) -> Iterator[str]:
        for part, shot in shots.items():
            axis = self._device.axes[part]
            for said in motor_notes(shot, axis):
                yield said if part == self._device.axes.first else f"{part}: {said}"

    def problems(self, is_service: bool) -> Iterator[HealthProblem]:
        device = self._device
        if device.failed:
            again = f"`hil reset {self.name}` restarts it"
            remedy = again if device.power.is_there else "`hil fault clear` ends the fault"
            yield HealthProblem("device", self.name, f"stopped: {device.failed}", remedy)
        for link in self._links():
            if link.failure:
                yield HealthProblem("port", link.label, link.failure, "restart the bench")

    # ---- its life ----

    async def begin(self) -> None:
        """Nothing real is to be reached, as in ``stop`` and ``close``."""

    def leave(self) -> None:
        self._sim.remove(self.name)

    async def stop(self) -> None: ...

    async def close(self) -> None: ...


class Samples:
    """Watch on samples of an axis, which wait in the core until they are taken."""

    def __init__(
        self,
        sampler: Sampler,
        axis: str,
        interval_ns: int | Fraction,
        points: int,
        call: Callable[[bytes], object],
    ) -> None:
        self._sampler = sampler
        self._subscription = sampler.subscribe(axis, (), interval_ns, points)
        self._call = call

    @property
    def lost(self) -> int:
        return self._subscription.lost

    def flush(self) -> None:
        self._sampler.poll_axis(self._subscription.axis)
        for sample in self._subscription.take_packed():
            self._call(sample)

    def close(self) -> None:
        self._sampler.unsubscribe(self._subscription)
