"""The controller of the arm: power, set-up, what moves the actuators together."""

from collections.abc import Generator, Mapping
from typing import Any

from device_profiles.walter import servo_packets as packets
from device_profiles.walter.arm_parts import (
    LIGHTS_ADDRESS,
    LIGHTS_BUS,
    PARTS,
    SERVO_MS,
    SERVOS,
    STEPPERS,
    StepperPart,
)
from device_profiles.walter.board_loop import BoardLoop, Steps, due_ms, is_due
from device_profiles.walter.float32 import f32, real_text
from device_profiles.walter.lights import Lights
from device_profiles.walter.logger import (
    INDENT,
    Logger,
    encoder_conf,
    encoder_setup,
    stepper_conf,
    stepper_line,
    stepper_setup,
    steps_line,
)
from device_profiles.walter.servo_drive import ServoBus, ServoDrive
from device_profiles.walter.settings import ArmMemory, Setting
from hil.vocab.firmware import ArmJoint, Request, Uart

ENCODER_FAILED, SERVO_FAILED = 12, 41
_DRIVER_US = 100
_BETWEEN_MS = 5
_SETTLE_MS, _BUS_MS, _AFTER_PACKET_MS, _ENABLED_MS = 50, 100, 10, 10
_READINGS, _READING_MS = 5, 10
_MOST_VARIANCE = 0.3
_MOST_FAILURES = 5
_SETTINGS = {
    "min_deg": "set_min",
    "max_deg": "set_max",
    "null_deg": "set_null",
    "speed_rpm": "set_speed",
    "acceleration_rpm_per_s": "set_acceleration",
    "kP": "set_p",
    "kI": "set_i",
}
"""Calls that tell a joint its settings, by their names."""


class Controller:
    """All actuators, both relays, and the error memory, which keeps the first error.

    Long because it is the firmware's own object, one method for each of its calls.
    """

    def __init__(
        self,
        joints: Mapping[str, ArmJoint],
        servo_uart: Uart,
        loop: BoardLoop,
        memory: ArmMemory,
        logger: Logger,
    ) -> None:
        self._joints = [joints[part.name] for part in PARTS]
        self._loop, self._memory, self._logger = loop, memory, logger
        self.lights = Lights()
        self.has_servo_power = self.is_powered = self.is_set_up = self.is_enabled = False
        self.has_knob = False
        self.current: int | None = None
        """Actuator that is moved by hand."""
        self.error = 0
        self._is_good = [False] * len(STEPPERS)
        stock = ArmMemory().actuators
        twins = [
            packets.ServoTwin(part, self._joints[part.number], stock[part.number].null_deg) for part in SERVOS
        ]
        bus = ServoBus(servo_uart, loop, twins, lambda: self.has_servo_power)
        self._bus = bus
        self._servos = {
            part.number: ServoDrive(part, self._joints[part.number], bus, loop, memory) for part in SERVOS
        }
        self._servo_ms = self._knob_ms = 0
        self._knob_deg = 0.0

    # ---- errors, power ----

    def fail(self, number: int) -> None:
        """Note an error, unless one is noted already."""
        self.error = self.error or number

    def power(self, is_on: bool) -> None:
        """Switch the 24 V; off is off for the servos too, and on is not."""
        self.is_powered = is_on
        self._loop.power(is_on)
        if not is_on:
            self.has_servo_power = False
        self.lights.is_enabled = is_on

    def enable(self) -> Steps:
        for number in range(len(PARTS)):
            yield from self._enable(number)
        self.is_enabled = self.lights.is_enabled = True
        yield from self._loop.hold(_ENABLED_MS)

    def disable(self) -> Steps:
        if not self.is_set_up:
            return
        for number in range(len(PARTS)):
            yield from self._disable(number)
            yield from self._loop.hold(_BETWEEN_MS)
        self.is_enabled = self.lights.is_enabled = False

    def _enable(self, number: int) -> Steps:
        if servo := self._servos.get(number):
            yield from servo.enable()
        else:
            yield from self._switch_driver(number, is_on=True)

    def _disable(self, number: int) -> Steps:
        if servo := self._servos.get(number):
            yield from servo.disable()
        else:
            yield from self._switch_driver(number, is_on=False)

    def _switch_driver(self, number: int, *, is_on: bool) -> Steps:
        self._joints[number].do("enable", float(is_on))
        yield from self._loop.pause(_DRIVER_US)

    def select(self, number: int) -> Steps:
        """Make an actuator the one that is moved by hand, and switch the one before off; 7: none."""
        if self.current is not None:
            yield from self._disable(self.current)
        self.current = number if number < len(PARTS) else None
        if self.current is not None:
            yield from self._enable(self.current)

    def use_knob(self, uses: bool) -> None:
        self.has_knob = uses
        self.lights.had_knob = True

    # ---- settings, angles ----

    def apply(self, number: int) -> None:
        """Tell a joint its settings."""
        if number < len(STEPPERS):
            for name, call in _SETTINGS.items():
                self._joints[number].do(call, getattr(self.setting(number), name))

    def setting(self, number: int) -> Setting:
        return self._memory.actuators[number]

    def angle_deg(self, number: int) -> float:
        """Angle as the firmware knows it: of a servo the one it was last sent to."""
        if servo := self._servos.get(number):
            return servo.to_be_deg
        return self._joints[number].get("measured_deg")

    def move(self, number: int, to_deg: float, duration_ms: int) -> None:
        """Begin a ramp to an angle within the limits."""
        if servo := self._servos.get(number):
            servo.move(to_deg, duration_ms)
        else:
            self._joints[number].do("move", to_deg, duration_ms)

    def move_by(self, number: int, by_deg: float, duration_ms: int) -> None:
        """Begin a ramp by an angle, whatever the limits are."""
        if servo := self._servos.get(number):
            servo.move_by(by_deg, duration_ms)
        else:
            self._joints[number].do("move_by", by_deg, duration_ms)

    def cut(self, number: int, deg: float) -> float:
        """Cut an angle to an actuator's limits."""
        setting = self.setting(number)
        return setting.min_deg if deg < setting.min_deg else min(deg, setting.max_deg)

    def to_be_deg(self, number: int) -> float:
        """Angle that an actuator's ramp asks for now."""
        return self._joints[number].do("ramp_at")

    def i2c_addresses(self, bus: int) -> list[int]:
        """Addresses that answer on a bus."""
        found = [p.i2c_address for p in STEPPERS if p.i2c_bus == bus and self._joints[p.number].do("answers")]
        return sorted([*found, *([LIGHTS_ADDRESS] if bus == LIGHTS_BUS and self.has_lights else [])])

    @property
    def has_lights(self) -> bool:
        """True if the light driver answers."""
        return bool(self._joints[0].get("has_lights"))

    # ---- servos and knob, in a pass ----

    def start_timers(self, first_pass_ms: int) -> None:
        """Begin the servos' period with the first pass."""
        self._servo_ms = first_pass_ms

    def note_pass(self, ms: int) -> None:
        """Note the ms of the latest pass that was not looked at: the servos' timer ran in it, too."""
        self._servo_ms += (ms - self._servo_ms) // SERVO_MS * SERVO_MS

    def service_due_ms(self, now_ms: int) -> int | None:
        """Time in ms at which servos or knob are due; None: they have nothing to do."""
        times = []
        if any(servo.has_ramp for servo in self._servos.values()):
            times.append(self._servo_ms + SERVO_MS)
        if self._is_knob_used:
            times.append(due_ms(now_ms, self._knob_ms, SERVO_MS))
        return min(times, default=None)

    @property
    def _is_knob_used(self) -> bool:
        return self.has_knob and self.current is not None

    def is_service_due(self, now_ms: int) -> bool:
        """Answer whether servos or knob are due in the pass of this time."""
        return now_ms - self._servo_ms >= SERVO_MS or (
            self._is_knob_used and is_due(now_ms, self._knob_ms, SERVO_MS)
        )

    def service(self, now_ms: int) -> Steps:
        """Serve knob and servos, behind the first look for pulses of a pass."""
        if self.current is not None and self.has_knob and is_due(now_ms, self._knob_ms, SERVO_MS):
            self._knob_ms = now_ms
            self._follow_knob(self.current)
        if now_ms - self._servo_ms >= SERVO_MS:
            self._servo_ms = now_ms
            hand, gripper = self._servos.values()
            yield from hand.service()
            yield from self._loop.poll()
            yield from gripper.service()

    def _follow_knob(self, number: int) -> None:
        counts = int(self._joints[0].get("knob_counts"))
        deg = f32((counts - 512) / 512 * 135)
        before, self._knob_deg = self._knob_deg, deg
        if abs(counts - 512) >= 500:
            return
        change = f32(deg - before)
        is_known = number in self._servos or self._is_encoder_ok(number)
        if abs(change) > f32(0.3):
            self._logger.write(
                f"knob:set to {real_text(deg, 1)}" if is_known else f"knob:adjust by {real_text(change, 1)}"
            )
        if is_known:
            self.move(number, deg, SERVO_MS)
        else:
            self.move_by(number, change, SERVO_MS)

    def _is_encoder_ok(self, number: int) -> bool:
        return self._is_good[number] and self._joints[number].get("failed_readings") < _MOST_FAILURES

    # ---- set-up ----

    def set_up(self) -> Generator[Request, Any, bool]:
        """Set all up; answers whether all is well. If not, the power goes off."""
        self.has_servo_power = True
        self.lights.is_setting_up = True
        self.error = 0
        yield from self.disable()
        self._logger.setup("--- switch on servo ")
        yield from self._loop.hold(_SETTLE_MS)
        self._loop.knows_joints(False)
        self._logger.setup("--- I2C initialization")
        self._logger.setup("--- com to servo")
        yield from self._set_up_bus()
        self._logger.setup("--- initializing actuators")
        yield from self._set_up_actuators()
        yield from self._check_encoders()
        self._settle()
        self._logger.setup("--- initialize ADC")
        self._logger.setup("setup done")
        if self.error:
            self.power(False)
        for part in STEPPERS:
            self._joints[part.number].do("due")
        self.is_set_up = True
        self._loop.knows_joints(True)
        self.lights.is_setting_up = False
        return not self.error

    def _set_up_bus(self) -> Steps:
        yield from self._loop.hold(_BUS_MS)
        yield from self._bus.send(packets.register_write(packets.BROADCAST, 0x30, bytes(2)))
        yield from self._loop.hold(_AFTER_PACKET_MS)
        yield from self._bus.torque(packets.BROADCAST, 1)
        yield from self._loop.hold(_AFTER_PACKET_MS)
        yield from self._bus.torque(packets.BROADCAST, packets.TORQUE_ON)
        yield from self._loop.hold(_AFTER_PACKET_MS)

    def _set_up_actuators(self) -> Steps:
        self.lights.limits = [Setting(**vars(each)) for each in self._memory.actuators]
        for part in PARTS:
            self._logger.setup(f"--- setup {part.label} ---")
            if isinstance(part, StepperPart):
                self._set_up_encoder(part)
                self._set_up_stepper(part)
                if part is STEPPERS[-1] and self.is_set_up:
                    self._loop.knows_joints(True)
                continue
            status = yield from self._servos[part.number].set_up()
            if status:
                self._logger.line(f"stat={status:X}")
                self._logger.fatal("Herkulex not connected")
                self.fail(SERVO_FAILED)

    def _set_up_encoder(self, part: StepperPart) -> None:
        joint, indent = self._joints[part.number], ""
        if self._memory.log.setup:
            self._logger.line(f"{INDENT}setup encoder(0x{part.i2c_address:X})")
            self._logger.line(INDENT + encoder_conf(part, self.setting(part.number)))
            self._logger.line(INDENT + encoder_setup(part))
            self._logger.line(f"{INDENT}connecting to I2C 0x{part.i2c_address:X}")
            indent = INDENT
        deg = joint.do("connect")
        self._is_good[part.number] = deg >= 0
        said = f"ok angle={real_text(deg)} offset={real_text(part.offset_deg)}" if deg >= 0 else "failed!"
        self._logger.line(f"{indent}comcheck(0x{part.i2c_address:X}) {said}")

    def _set_up_stepper(self, part: StepperPart) -> None:
        joint, setting, indent = self._joints[part.number], self.setting(part.number), ""
        self.apply(part.number)
        if self._memory.log.setup:
            self._logger.line(INDENT + stepper_line(part))
            self._logger.line(INDENT + stepper_setup(part))
            self._logger.line(INDENT + stepper_conf(part, setting))
            indent = INDENT
        joint.do("set_up")
        full = joint.do("full_acceleration"), joint.do("full_speed")
        self._logger.line(indent + steps_line(part, setting, *full))

    def _check_encoders(self) -> Steps:
        for part in STEPPERS:
            joint, samples = self._joints[part.number], []
            for place in range(_READINGS):
                if place:
                    yield from self._loop.hold(_READING_MS)
                if joint.do("read") < 0:
                    self._logger.failed_reading(part, int(joint.get("failed_readings")))
                samples.append(joint.do("read_deg"))
            is_stable = _variance(samples) <= f32(_MOST_VARIANCE)
            joint.do("passed", float(is_stable))
            self._is_good[part.number] &= is_stable
            is_ok = self._is_encoder_ok(part.number)
            self._logger.line(f"enc(0x{part.i2c_address:X}){' ok' if is_ok else ' not ok!'}")
            if not is_ok:
                self.fail(ENCODER_FAILED)

    def _settle(self) -> None:
        """Let each joint be where its encoder says."""
        for part in STEPPERS:
            if self._is_encoder_ok(part.number):
                self._joints[part.number].do("settle")
            else:
                self._logger.write(part.label)
                self._logger.fatal("encoder not ok")


def _variance(samples: list[float]) -> float:
    mean = 0.0
    for x in samples:
        mean = f32(mean + x)
    mean = f32(mean / len(samples))
    sum_of_squares = 0.0
    for x in samples:
        sum_of_squares = f32(sum_of_squares + f32(f32(x - mean) * f32(x - mean)))
    return f32(sum_of_squares / len(samples))
