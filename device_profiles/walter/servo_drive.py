"""Drive of a servo as the firmware has it, and the bus that both servos are on."""

from collections.abc import Callable, Generator, Sequence
from typing import Any

from device_profiles.walter import servo_packets as packets
from device_profiles.walter.arm_parts import DRIVE_IN_MS_PER_DEG, SERVO_MS, TORQUE_LIMIT_COUNTS, ServoPart
from device_profiles.walter.board_loop import BoardLoop, Steps
from device_profiles.walter.float32 import f32
from device_profiles.walter.settings import ArmMemory, Setting
from hil.vocab.firmware import ArmJoint, Request, Uart

_REPLY_MS = 5
"""Most that a reply is waited for, beside its own time."""
_MOVE_MS = 12
"""Added to the time of a move, so that the next one comes before its end."""
_UNIT_MS = 11.2
_SETTLE_MS = 100
_DRIVE_IN_MS = 2000
_MOST_DEG = 160.0
_CORRECTION_DEG = 30.0
MUTE = 0xFF
"""Status of a servo that does not answer."""
Reading = Generator[Request, Any, int]


class ServoBus:
    """Servo bus. ``has_power``: answers whether the servos' relay is closed. What its port receives counts
    where the arm's own servos are mute."""

    def __init__(
        self, uart: Uart, loop: BoardLoop, twins: Sequence[packets.ServoTwin], has_power: Callable[[], bool]
    ) -> None:
        self._uart, self._loop, self._twins, self._has_power = uart, loop, twins, has_power
        self._reply = b""

    def send(self, sent: bytes, wait_ms: int = 0) -> Steps:
        """Send a packet, and wait a millisecond and ``wait_ms`` more; what was received before is dropped."""
        self._uart.read_all()
        self._uart.write(sent)
        self._reply = b""
        if self._has_power():
            self._reply = b"".join(twin.answer(sent) for twin in self._twins)
        yield from self._loop.hold(1, wait_ms)

    def torque(self, servo_id: int, value: int) -> Steps:
        yield from self.send(packets.register_write(servo_id, packets.TORQUE, bytes((value,))))

    def status(self, servo_id: int) -> Reading:
        """Status of a servo; ``MUTE``: none."""
        data = yield from self._ask(packets.packet(servo_id, packets.STATUS), 2, packets.STATUS_BYTES)
        return data[0] if data else MUTE

    def position(self, servo_id: int) -> Reading:
        """Position in counts, -1: none."""
        data = yield from self._ask(packets.register_read(servo_id, packets.POSITION), 1, packets.READ_BYTES)
        return data[2] | (data[3] & 3) << 8 if data else -1

    def pwm(self, servo_id: int) -> Reading:
        """Torque as the servo tells it, -1: none."""
        data = yield from self._ask(packets.register_read(servo_id, packets.PWM), 1, packets.READ_BYTES)
        return int.from_bytes(data[2:4], "little", signed=True) if data else -1

    def _ask(self, sent: bytes, wait_ms: int, size: int) -> Generator[Request, Any, bytes | None]:
        yield from self.send(sent, wait_ms)
        for _ in range(_REPLY_MS):
            if len(self._reply) + self._uart.available() >= size:
                break
            yield from self._loop.hold(1)
        return packets.reply_data(self._reply + self._uart.read_all(), size)


class ServoDrive:
    """Drive of one servo. Its ramp is in the core, beside the joints'."""

    def __init__(
        self, part: ServoPart, joint: ArmJoint, bus: ServoBus, loop: BoardLoop, memory: ArmMemory
    ) -> None:
        self.part, self._joint, self._bus, self._loop, self._memory = part, joint, bus, loop, memory
        self.is_connected = False
        self.to_be_deg = 0.0
        self.has_ramp = False
        self._set_up_ms = 0
        self._correction_deg = 0.0

    @property
    def _setting(self) -> Setting:
        return self._memory.actuators[self.part.number]

    def _cut(self, deg: float) -> float:
        low, high = self._setting.min_deg, self._setting.max_deg
        return low if deg < low else high if deg > high else deg

    def set_up(self) -> Reading:
        """End all motion, switch the torque off; answers the status."""
        self._rest()
        self._set_up_ms = self._loop.ms
        yield from self._bus.torque(self.part.servo_id, 0)
        status = yield from self._bus.status(self.part.servo_id)
        self.is_connected |= status == 0
        return status

    def _rest(self) -> None:
        self._joint.do("rest")
        self.has_ramp = False

    def disable(self) -> Steps:
        yield from self._bus.torque(self.part.servo_id, 0)

    def enable(self) -> Steps:
        """Switch the torque on where it stands; from beyond its limits it drives in first."""
        if not self.is_connected:
            return
        yield from self._loop.hold(self._set_up_ms + _SETTLE_MS - self._loop.ms)
        start_ms = self._loop.ms
        counts = yield from self._bus.position(self.part.servo_id)
        angle = f32((counts - packets.CENTRE_COUNTS) * f32(packets.DEG_PER_COUNT))
        self.to_be_deg = f32(angle - self._setting.null_deg)
        inside = self._cut(self.to_be_deg)
        way_ms = f32(f32(abs(f32(self.to_be_deg - inside))) * f32(DRIVE_IN_MS_PER_DEG))
        duration_ms = min(int(way_ms), _DRIVE_IN_MS)
        late_ms = self._loop.ms - start_ms
        self._ramp(self.to_be_deg, inside, duration_ms)
        yield from self._bus.torque(self.part.servo_id, packets.TORQUE_ON)
        while self._loop.ms < start_ms + duration_ms:
            before_us, ahead = self._loop.us, self._ramp_at(SERVO_MS + late_ms)
            yield from self._move(ahead, SERVO_MS, abs(ahead - self._ramp_at(late_ms)) / SERVO_MS)
            if self._loop.us == before_us:  # it was too far away to be sent there
                yield from self._loop.pause_until_next_ms()
        self.move(inside, SERVO_MS, late_ms)

    def move(self, to_deg: float, duration_ms: int, late_ms: int = 0) -> None:
        """Begin a ramp from its present to-be angle, within its limits."""
        self._ramp(self._ramp_at(late_ms), self._cut(f32(to_deg)), duration_ms)

    def move_by(self, by_deg: float, duration_ms: int) -> None:
        """Begin a ramp from the last to-be angle, not cut."""
        self._ramp(self.to_be_deg, f32(self.to_be_deg + f32(by_deg)), duration_ms)

    def _ramp(self, from_deg: float, to_deg: float, duration_ms: int) -> None:
        self._joint.do("ramp", from_deg, to_deg, duration_ms)
        self.has_ramp = True

    def _ramp_at(self, ahead_ms: int) -> float:
        return self._joint.do("ramp_at", ahead_ms)

    def service(self) -> Steps:
        """Send the next move, each period."""
        if not self.has_ramp:
            return
        ahead = self._ramp_at(SERVO_MS)
        speed = f32(f32(ahead - self._ramp_at(0)) / SERVO_MS)
        yield from self._move(self._cut(ahead), SERVO_MS + _MOVE_MS, speed)

    def _move(self, to_deg: float, duration_ms: int, deg_per_ms: float) -> Steps:
        if self._memory.log.servo:
            yield from self._bus.status(self.part.servo_id)
            yield from self._bus.position(self.part.servo_id)
        angle = f32(f32(to_deg + self._setting.null_deg) - self._correction_deg)
        position = (
            int(f32(angle / f32(packets.DEG_PER_COUNT))) + packets.CENTRE_COUNTS
            if abs(angle) <= _MOST_DEG
            else -1
        )
        if 0 <= position <= packets.MOST_COUNTS:
            yield from self._bus.send(packets.move(self.part.servo_id, position, int(duration_ms / _UNIT_MS)))
        self.to_be_deg = to_deg
        if self.part.limits_torque:
            self._correct((yield from self._bus.pwm(self.part.servo_id)), deg_per_ms)

    def _correct(self, pwm: int, deg_per_ms: float) -> None:
        """Give way by a correction that grows while the torque is too large, and shrinks when it is not."""
        size, sign = abs(self._correction_deg), -1 if self._correction_deg < 0 else 1
        if abs(pwm) <= TORQUE_LIMIT_COUNTS:
            size = max(0.0, size - 1)
        elif not self._correction_deg:
            size, sign = 1.0, -1 if pwm < 0 else 1
        else:
            size = min(_CORRECTION_DEG, f32(size + 3.0 / (1.0 + abs(deg_per_ms) * 100)))
        self._correction_deg = sign * size
