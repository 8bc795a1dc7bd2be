"""Twins as axes of runs, on a bench in real or in virtual time."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from hil.core import CoreAxis
from hil.runs.run_axis import bounds_of
from hil.sim.bench import BenchRuntime
from hil.sim.input_check import input_problem
from hil.sim.inputs import Do, Follow, Input
from hil.sim.twin import Twin
from hil.telemetry import Sampler, Subscription
from hil.vocab.address import owner_of
from hil.vocab.axis import AxisNow, AxisState, How, Sample
from hil.vocab.parameters import Parameter
from hil.vocab.path import Path
from hil.vocab.verbs import VerbRefused

SAMPLE_NS = 1_000_000
"""Interval of samples while a run has the axis."""
RAMPS_MOVE = "it moves"
PATHS_MOVE = "it follows a path or turns"
LOOP_OFF = "its control loop is off"
MOTOR_OFF = "its motor is off"
NO_VERBS = "it has no verbs to be moved by"
NO_SHAFT = "it has pins alone, and no shaft"


class TwinAxes:
    """Axes of the twins of a bench, as ``hil.vocab.axis.Axes``."""

    def __init__(self, bench: BenchRuntime, sampler: Sampler) -> None:
        self._bench = bench
        self._sampler = sampler

    @property
    def now_ns(self) -> int:
        return self._bench.now_ns

    def axes(self) -> dict[str, AxisNow]:
        return {address: self[address].now() for address in self._bench.parts.axes}

    def __getitem__(self, axis: str) -> "TwinAxis":
        return TwinAxis(self._bench, self._sampler, axis)


class TwinAxis:
    """Axis of a twin, as ``hil.vocab.axis.Axis``: its motions are inputs of the bench. It is looked up by its
    address each time, for a reload may exchange the twin."""

    lead_ns = 0

    def __init__(self, bench: BenchRuntime, sampler: Sampler, name: str) -> None:
        self._bench = bench
        self._sampler = sampler
        self._name = name
        self._subscription: Subscription | None = None
        self._held: CoreAxis | None = None
        self.refusal: str | None = None

    @property
    def _device(self) -> Twin:
        return self._bench.devices[owner_of(self._name)]

    @property
    def _axis(self) -> CoreAxis:
        return self._bench.parts.axis(self._name)

    @property
    def _follows_paths(self) -> bool:
        return self._device.follows_paths and self._axis.kind.follows_paths

    @property
    def failure(self) -> str | None:
        return self._device.failed

    def now(self) -> AxisNow:
        """The axis as a plan begins with it."""
        kind, state = self._axis.kind, self.state()
        is_free = self._follows_paths and not state.keeps_angle
        at_deg = state.position_deg if is_free else state.commanded_deg
        fields, pins = tuple(kind.fields), tuple(kind.inputs)
        if at_deg is None:
            return AxisNow(0.0, False, fields, pins, NO_SHAFT)
        now = AxisNow(at_deg, self._follows_paths, fields, pins, bounds=self._bounds)
        why_not, remedy = self._obstacle(state)
        return replace(now, why_not=why_not, remedy=remedy) if why_not else now

    @property
    def _bounds(self) -> dict[str, Parameter]:
        return bounds_of(self._device.verbs, follows_paths=self._follows_paths)

    def _obstacle(self, state: AxisState) -> tuple[str | None, str]:
        """Reason why the axis cannot take part, if there is one, and what helps."""
        device = self._device
        if why := device.failed:
            return why, f"`hil reset {device.name}`, or leave it out"
        if self._follows_paths and (lacks := device.lacks):
            what, verb = lacks
            ways = [*(["disable"] if state.is_on else []), verb, "enable"]
            return what, ", then ".join(f"`hil axis {self._name} {each}`" for each in ways)
        if not state.is_on and "enable" in device.verbs:
            new = f"; `hil axis {self._name} calibrate` before that if it is new"
            return LOOP_OFF, f"`hil axis {self._name} enable` first{new * ('calibrate' in device.verbs)}"
        if not state.is_on:
            return MOTOR_OFF, "let its board power and enable it first"
        if state.is_moving or state.is_under_way:
            why = PATHS_MOVE if self._follows_paths else RAMPS_MOVE
            return why, f"wait for its end, or `hil axis {self._name} stop` first"
        wanted = {"stop"} if self._follows_paths else {"stop", "move_abs"}
        return (None if wanted <= set(device.verbs) else NO_VERBS), "leave it out"

    def state(self) -> AxisState:
        return self._axis.kind.motion(self._bench.snapshot(self._name))

    def field(self, name: str) -> float:
        return float(getattr(self._bench.snapshot(self._name), name))

    def hold(self) -> None:
        self.refusal = None
        self._held = self._axis
        self._held.is_in_run = True
        signals = self._held.kind.course
        self._subscription = self._sampler.subscribe(self._name, signals, SAMPLE_NS, is_limited=False)

    def samples(self) -> Sequence[Sample]:
        if self._subscription is None:
            return ()
        self._sampler.poll_axis(self._name)
        return self._subscription.drain()

    def release(self) -> None:
        if self._held:  # it may be another axis's name by now
            self._held.is_in_run = False
        if self._subscription:
            self._sampler.unsubscribe(self._subscription)

    # ---- what it is given ----

    def follow(self, path: Path, start_ns: int) -> int:
        return max(start_ns, self._give(Follow(start_ns, path)))

    def join(self, path: Path, start_ns: int) -> None:
        self._give(Follow(start_ns, path, is_joined=True))

    def move(self, position_deg: float, velocity_rpm: float, start_ns: int) -> None:
        self._do("move_abs", {"position_deg": position_deg, "velocity_rpm": velocity_rpm}, start_ns)

    def stop(self, how: How, acceleration_rpm_per_s: float) -> None:
        ramp = acceleration_rpm_per_s
        if bound := self._bounds.get("acceleration_rpm_per_s"):  # the board may be another by now
            ramp = min(max(ramp, bound.minimum), bound.maximum)
        self._do("stop", {"how": how, "acceleration_rpm_per_s": ramp})

    def set_pin(self, pin: str, level: int, at_ns: int) -> None:
        self._do("pin", {"pin": pin, "level": level}, at_ns)

    def _do(self, verb: str, given: Mapping[str, float | str], at_ns: int | None = None) -> None:
        """Carry out a verb, with those parameters that it has here."""
        known = {parameter.name for parameter in self._device.verbs[verb].parameters}
        self._give(Do(verb, tuple(item for item in given.items() if item[0] in known), at_ns))

    def _give(self, given: Input) -> int:
        """Give the axis an input; answers the time at which it took effect."""
        if problem := input_problem(self._bench, self._name, given):
            raise VerbRefused("bad_parameter", problem)
        return self._bench.apply_input(self._name, given, on_refused=self._refused_later(given))[0]

    def _refused_later(self, given: Input) -> Callable[[VerbRefused], None]:
        def refused(refusal: VerbRefused) -> None:
            assert isinstance(given, Do)
            self.refusal = self.refusal or f"{given.verb}: {refusal}"

        return refused
