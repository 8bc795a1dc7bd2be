"""Bench as plans and executions see it."""

from collections.abc import Sequence

from hil.core.fields import OF_KIND, SERVO
from hil.runs.axes import AxisNow, Refused, Rows
from hil.runs.run_axis import ANGLES, TURNS_RPM
from hil.sim.bench import BenchRuntime
from hil.sim.device import Device
from hil.sim.inputs import Do, Input
from hil.telemetry import Sampler, Subscription
from hil.vocab.verbs import VerbRefused

STEPPER_MOVES = "it moves; stop it first"
SERVO_MOVES = "it follows a path or turns; let it end, or stop it"
LOOP_OFF = "its control loop is off; enable it first"


class BenchAxes:
    """``hil.runs.RunBench`` of a running bench, in real or in virtual time."""

    def __init__(self, bench: BenchRuntime, sampler: Sampler) -> None:
        self._bench = bench
        self._sampler = sampler

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

    def give(self, axis: str, given: Input, refused: Refused) -> None:
        def later(refusal: VerbRefused) -> None:
            assert isinstance(given, Do)
            refused(f"{given.verb}: {refusal}")

        self._bench.take(axis, given, on_refused=later)

    def fields(self, axis: str, names: Sequence[str]) -> Sequence[float]:
        state = self._bench.snapshot(axis)
        return [float(getattr(state, name)) for name in names]

    def failure(self, axis: str) -> str | None:
        return self._bench.devices[axis].failed

    def sample(self, axis: str, signals: tuple[str, str], interval_ns: int) -> Rows:
        return _Rows(self._sampler, self._sampler.subscribe(axis, signals, interval_ns, is_limited=False))


class _Rows:
    def __init__(self, sampler: Sampler, subscription: Subscription) -> None:
        self._sampler = sampler
        self._subscription = subscription

    def take(self) -> Sequence[tuple[float, ...]]:
        self._sampler.poll_device(self._subscription.device)
        return self._subscription.take()

    def close(self) -> None:
        self._sampler.unsubscribe(self._subscription)
