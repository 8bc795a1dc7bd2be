"""A bench as plans and executions see it."""

from collections.abc import Mapping, Sequence
from functools import partial

from hil.core.fields import OF_KIND, SERVO
from hil.runs.execute import ANGLES, TURNS_RPM, Rows, RunBench
from hil.runs.plan import AxisNow
from hil.sim.bench import BenchRuntime
from hil.sim.device import Device
from hil.sim.inputs import Do, Input
from hil.telemetry import Sampler, Subscription
from hil.vocab.verbs import VerbRefused

STEPPER_MOVES = "it moves; stop it first"
SERVO_MOVES = "it follows a path or turns; let it end, or stop it"
LOOP_OFF = "its control loop is off; enable it first"


class BenchAxes:
    """``hil.runs.execute.RunBench`` of a running bench, in real or in virtual time."""

    def __init__(self, bench: BenchRuntime, sampler: Sampler) -> None:
        self._bench = bench
        self._sampler = sampler
        self._refused: dict[str, list[str]] = {}

    def _note(self, axis: str, verb: str, refusal: VerbRefused) -> None:
        self._refused.setdefault(axis, []).append(f"{verb}: {refusal}")

    def axes(self) -> dict[str, AxisNow]:
        """All devices, as a plan begins with them."""
        return {name: self._axis(device) for name, device in self._bench.devices.items()}

    def _axis(self, device: Device) -> AxisNow:
        state = self._bench.snapshot(device.name)
        fields, pins = tuple(OF_KIND[device.axis.kind]), tuple(device.axis.pins)
        if device.axis.kind != SERVO:
            why = STEPPER_MOVES if state.motion_state or state.pending else device.failed
            return AxisNow("stepper", state.commanded_deg, fields, pins, why)
        is_angle = state.mode in ANGLES
        moves = state.following or (not is_angle and abs(state.velocity_rpm) > TURNS_RPM)
        why = device.failed or (LOOP_OFF if not state.loop_on else SERVO_MOVES if moves else None)
        return AxisNow("servo", state.r if is_angle else state.yw, fields, pins, why)

    @property
    def now_ns(self) -> int:
        return self._bench.now_ns

    def give(self, axis: str, given: Input) -> None:
        device = self._bench.devices[axis]
        if not isinstance(given, Do) or given.at_ns is None:
            self._bench.give(device, given)
            return
        note = partial(self._note, axis, given.verb)
        try:
            self._bench.take(axis, given, on_refused=note)
        except VerbRefused as refusal:  # its time was over, and it was done at once
            note(refusal)

    def fields(self, axis: str, names: Sequence[str]) -> Sequence[float]:
        state = self._bench.snapshot(axis)
        return [float(getattr(state, name)) for name in names]

    def failure(self, axis: str) -> str | None:
        return self._bench.devices[axis].failed

    def refusals(self, axis: str) -> Sequence[str]:
        return self._refused.pop(axis, [])

    def sample(self, axis: str, signals: tuple[str, str], interval_ns: int) -> Rows:
        return _Rows(self._sampler, self._sampler.subscribe(axis, signals, interval_ns, is_limited=False))


class Named:
    """A ``RunBench`` whose axes a run knows by other names, as ``lathe/m1`` for ``m1``."""

    def __init__(self, bench: RunBench, devices: Mapping[str, str]) -> None:
        self._bench = bench
        self._devices = devices

    @property
    def now_ns(self) -> int:
        return self._bench.now_ns

    def give(self, axis: str, given: Input) -> None:
        self._bench.give(self._devices[axis], given)

    def fields(self, axis: str, names: Sequence[str]) -> Sequence[float]:
        return self._bench.fields(self._devices[axis], names)

    def failure(self, axis: str) -> str | None:
        return self._bench.failure(self._devices[axis])

    def refusals(self, axis: str) -> Sequence[str]:
        return self._bench.refusals(self._devices[axis])

    def sample(self, axis: str, signals: tuple[str, str], interval_ns: int) -> Rows:
        return self._bench.sample(self._devices[axis], signals, interval_ns)


class _Rows:
    def __init__(self, sampler: Sampler, subscription: Subscription) -> None:
        self._sampler = sampler
        self._subscription = subscription

    def take(self) -> Sequence[tuple[float, ...]]:
        self._sampler.poll_device(self._subscription.device)
        return self._subscription.take()

    def close(self) -> None:
        self._sampler.unsubscribe(self._subscription)
