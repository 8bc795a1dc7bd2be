"""Drive of CiA 402 over a Mechaduino in virtual time, without a bus."""

from typing import Any

from bridges.can.canopen.canopen_codes import NmtState
from bridges.can.canopen.cia402.motor_axis import MotorLook
from bridges.can.canopen.cia402.profile_drive import ProfileDrive
from bridges.can.canopen.node.application import Value
from hil.sim.inputs import Do, Follow, Input
from hil.testing import Bench
from hil.vocab.axis import How
from hil.vocab.path import Path
from hil.vocab.time import NS_PER_MS

MECHADUINO: dict[str, Any] = {"profile": "mechaduino", "port": "memory", "flash": {"table": "identity"}}
COUNT_A = 0.33 / 0.15 / 255
"""Current of a count of effort."""


class TwinMotor:
    """Axis of a twin of a bench, ``bridges.can.canopen.cia402.motor_axis.MotorAxis``."""

    verbs = frozenset({"enable", "disable", "stop", "velocity", "torque", "move_abs"})
    follows_paths = True
    index_deg: float | None = 0.0
    encoder_counts = 16384
    rated_current_A = 2.2
    rated_torque_Nm = 0.3
    max_velocity_rpm = 3000.0

    def __init__(self, bench: Bench, name: str = "m1") -> None:
        self._runtime, self._name = bench._runtime, name
        self.paths: list[tuple[int, Path]] = []

    def _give(self, given: Input) -> None:
        self._runtime.apply_input(self._name, given)

    def look(self) -> MotorLook:
        said = self._runtime.snapshot(self._name)
        device = self._runtime.devices[self._name]
        return MotorLook(
            said.at_ns,
            said.yw,
            said.velocity_rpm,
            said.u * COUNT_A,
            said.r if said.mode in map(ord, "xh") else None,
            bool(said.loop_on),
            bool(said.following),
            device.failed,
            is_ready=not device.is_busy,
        )

    def enable(self) -> None:
        self._give(Do("enable", ()))

    def disable(self) -> None:
        self._give(Do("disable", ()))

    def clear_fault(self) -> None:
        return

    def follow(self, path: Path, start_ns: int = 0) -> None:
        self.paths.append((self._runtime.now_ns, path))
        self._give(Follow(start_ns, path))

    def velocity(self, rpm: float) -> None:
        self._give(Do("velocity", (("velocity_rpm", rpm),)))

    def torque(self, current_A: float) -> None:
        self._give(Do("torque", (("effort_count", current_A / COUNT_A),)))

    def move_abs(self, position_deg: float, velocity_rpm: float, acceleration_rpm_per_s: float) -> None:
        raise AssertionError("it follows paths")

    def stop(self, how: How, acceleration_rpm_per_s: float) -> None:
        self._give(Do("stop", (("how", how), ("acceleration_rpm_per_s", acceleration_rpm_per_s))))


class TwinDrive:
    """Drive over a twin that has started."""

    def __init__(self, bench: Bench | None = None) -> None:
        self.bench = bench or Bench({"bench": "t", "devices": {"m1": MECHADUINO}})
        self.motor = TwinMotor(self.bench)
        self.emergencies: list[int] = []
        self.drive = ProfileDrive(self.motor, self)
        self._kept = {(e.index, e.subindex): e.default for e in self.drive.entries if not e.is_live}
        self.drive.entered(NmtState.INITIALISING, 0)
        self.run_until(4500)

    def value(self, index: int, subindex: int) -> Value:
        return self._kept[index, subindex]

    def set_value(self, index: int, subindex: int, value: Value) -> None:
        self._kept[index, subindex] = value

    def emergency(self, code: int, register_bits: int, manufacturer: bytes = bytes(5)) -> None:
        self.emergencies.append(code)

    def changed(self, index: int, subindex: int) -> None:
        return

    def write(self, index: int, value: int, subindex: int = 0) -> None:
        self._kept[index, subindex] = value
        self.drive.write(index, subindex, value, self.bench.now_ns)

    def read(self, index: int) -> int:
        value = self.drive.read(index, 0, self.bench.now_ns)
        assert isinstance(value, int)
        return value

    def control(self, *words: int) -> int:
        for word in words:
            self.write(0x6040, word)
        return self.read(0x6041)

    def enable(self, mode: int) -> None:
        self.write(0x6060, mode)
        assert self.control(0x06, 0x07, 0x0F) & 0x6F == 0x27

    def sync(self) -> None:
        self.drive.synced(self.bench.now_ns)

    def run_until(self, ms: float) -> None:
        until_ns = round(ms * NS_PER_MS)
        while self.drive.due_ns <= until_ns:
            if self.drive.due_ns > self.bench.now_ns:
                self.bench.run_until(self.drive.due_ns / NS_PER_MS)
            self.drive.step(self.bench.now_ns)
        self.bench.run_until(until_ns / NS_PER_MS)

    def run(self, ms: float) -> None:
        self.run_until(self.bench.now_ns / NS_PER_MS + ms)
