"""Drive over an axis that does exactly what it is told, stepped through simulated time."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from bridges.can.canopen.canopen_codes import NmtState
from bridges.can.canopen.cia402.motor_axis import MotorLook
from bridges.can.canopen.cia402.profile_drive import ProfileDrive
from bridges.can.canopen.node.application import Access, SdoAbort, Value
from hil.firmware.set_point_paths import length_ns
from hil.vocab.path import DEG_PER_S, Path, PathPiece
from hil.vocab.time import NS_PER_MS, NS_PER_S
from hil.vocab.verbs import VerbRefused

SERVO = ("enable", "disable", "stop", "velocity", "torque", "move_abs", "clear_fault")
STEPPER = ("stop", "velocity", "move_abs")
Switch = Callable[[float], bool]


def at(path: Path, into_ns: int) -> tuple[float, float]:
    for piece in path:
        if into_ns < piece.duration_ns:
            return piece.after(into_ns)
        into_ns -= piece.duration_ns
    return path[-1].after(path[-1].duration_ns)[0], 0.0


@dataclass
class SimpleAxis:
    """Axis without dynamics. ``switches``: angles at which each is active."""

    verbs: tuple[str, ...] = SERVO
    follows_paths: bool = True
    index_deg: float | None = 100.0
    encoder_counts: int = 16384
    rated_current_A: float = 2.0
    rated_torque_Nm: float = 0.4
    max_velocity_rpm: float = 3000.0
    switches: Mapping[str, Switch] = field(default_factory=dict)
    now_ns: int = 0
    off_by_deg: float = 0.0
    failure: str | None = None
    is_ready: bool = True
    fault_code: int = 0
    refuses: str = ""
    """Name of the verb that is refused."""

    def __post_init__(self) -> None:
        self.is_on = "enable" not in self.verbs
        self.path: Path = (PathPiece(0, 0.0),)
        self.from_ns = 0
        self.current_A = 0.0
        self.calls: list[tuple[object, ...]] = []
        self.paths: list[tuple[int, Path]] = []

    def where(self) -> tuple[float, float]:
        return at(self.path, self.now_ns - self.from_ns)

    def look(self) -> MotorLook:
        deg, rate = self.where()
        is_moving = self.now_ns - self.from_ns < length_ns(self.path)
        shaft = deg + self.off_by_deg
        return MotorLook(
            self.now_ns,
            shaft,
            rate / DEG_PER_S,
            self.current_A,
            deg,
            self.is_on,
            is_moving,
            self.failure,
            {name: int(is_active(shaft)) for name, is_active in self.switches.items()},
            self.is_ready,
            self.fault_code,
        )

    def measured(self, name: str) -> float:
        return float(getattr(self.look(), name))

    def _called(self, name: str, *given: object) -> None:
        if self.refuses == name:
            raise VerbRefused("not_now", f"{name} is refused")
        self.calls.append((name, *given))

    def _go(self, path: Path) -> None:
        self.path, self.from_ns = path, self.now_ns
        self.paths.append((self.now_ns, path))

    def enable(self) -> None:
        self._called("enable")
        self.is_on = True
        self._go((PathPiece(0, self.look().position_deg),))

    def disable(self) -> None:
        self._called("disable")
        self.is_on, self.current_A = False, 0.0
        self._go((PathPiece(0, self.where()[0]),))

    def clear_fault(self) -> None:
        self._called("clear_fault")
        self.fault_code = 0

    def follow(self, path: Path, start_ns: int = 0) -> None:
        self._called("follow")
        assert self.is_on
        self._go(path)

    def velocity(self, rpm: float) -> None:
        self._called("velocity", rpm)
        deg = self.where()[0]
        self._go((PathPiece(10**18 if rpm else 0, deg, rpm * DEG_PER_S),))

    def torque(self, current_A: float) -> None:
        self._called("torque", current_A)
        self.current_A = current_A

    def move_abs(self, position_deg: float, velocity_rpm: float, acceleration_rpm_per_s: float) -> None:
        self._called("move_abs", position_deg, velocity_rpm)
        if self.look().is_moving:
            raise VerbRefused("not_now", "it moves")
        deg = self.where()[0]
        rate = velocity_rpm * DEG_PER_S * (1 if position_deg > deg else -1)
        duration_ns = round((position_deg - deg) / rate * NS_PER_S)
        self._go((PathPiece(duration_ns, deg, rate), PathPiece(0, position_deg)))

    def stop(self, how: str, acceleration_rpm_per_s: float) -> None:
        self._called("stop", how)
        self._go((PathPiece(0, self.where()[0]),))


class DriveRig:
    """Drive with the part of a node that it needs: checks of limits, values, EMCY."""

    def __init__(self, axis: SimpleAxis | None = None, **values: int) -> None:
        self.axis = axis or SimpleAxis()
        self.emergencies: list[int] = []
        self.said: list[tuple[int, int]] = []
        self.kept: dict[tuple[int, int], Value] = {}
        self.drive = ProfileDrive(self.axis, self)
        self.entries = {(entry.index, entry.subindex): entry for entry in self.drive.entries}
        self.kept = {key: entry.default for key, entry in self.entries.items() if not entry.is_live}
        self.drive.entered(NmtState.INITIALISING, 0)
        self.drive.entered(NmtState.PRE_OPERATIONAL, 0)

    # ---- bridges.can.canopen.node.canopen_node.CanOpenNode ----

    def value(self, index: int, subindex: int) -> Value:
        return self.kept[index, subindex]

    def set_value(self, index: int, subindex: int, value: Value) -> None:
        self.kept[index, subindex] = value

    def emergency(self, code: int, register_bits: int, manufacturer: bytes = bytes(5)) -> None:
        self.emergencies.append(code)

    def changed(self, index: int, subindex: int) -> None:
        self.said.append((index, self.drive.read(index, subindex, self.now_ns)))  # type: ignore[arg-type]

    # ---- a master ----

    @property
    def now_ns(self) -> int:
        return self.axis.now_ns

    def write(self, index: int, value: int, subindex: int = 0) -> None:
        entry = self.entries[index, subindex]
        if entry.access is not Access.RW:
            raise SdoAbort(0x0601_0002)
        if entry.low is not None and value < entry.low:
            raise SdoAbort(0x0609_0032)
        if entry.high is not None and value > entry.high:
            raise SdoAbort(0x0609_0031)
        before, self.kept[index, subindex] = self.kept[index, subindex], value
        try:
            self.drive.write(index, subindex, value, self.now_ns)
        except SdoAbort:
            self.kept[index, subindex] = before
            raise

    def receive(self, values: dict[int, int]) -> None:
        """Take a PDO: all values are there before the drive is told of each."""
        self.kept |= {(index, 0): value for index, value in values.items()}
        for index, value in values.items():
            self.drive.write(index, 0, value, self.now_ns)

    def read(self, index: int, subindex: int = 0) -> int:
        if self.entries[index, subindex].is_live:
            value = self.drive.read(index, subindex, self.now_ns)
        else:
            value = self.kept[index, subindex]
        assert isinstance(value, int)
        return value

    def control(self, *words: int) -> int:
        for word in words:
            self.write(0x6040, word)
        return self.status

    @property
    def status(self) -> int:
        return self.read(0x6041)

    @property
    def state(self) -> int:
        return self.status & 0x6F

    def enable(self, mode: int | None = None) -> None:
        if mode is not None:
            self.write(0x6060, mode)
        self.control(0x06, 0x07, 0x0F)
        assert self.state == 0x27

    def run_until(self, ms: float) -> None:
        """Let time pass, with all that the drive does on its way."""
        until_ns = round(ms * NS_PER_MS)
        count = 0
        while self.drive.due_ns <= until_ns:
            assert self.drive.due_ns > self.axis.now_ns or count < 3, "it wants to run forever"
            count = 0 if self.drive.due_ns > self.axis.now_ns else count + 1
            self.axis.now_ns = max(self.axis.now_ns, self.drive.due_ns)
            self.drive.step(self.axis.now_ns)
        self.axis.now_ns = until_ns

    def run(self, ms: float) -> None:
        self.run_until(self.now_ns / NS_PER_MS + ms)

    def sync(self) -> None:
        self.drive.synced(self.now_ns)
