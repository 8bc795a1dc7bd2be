"""Texts on the logger."""

from device_profiles.walter.arm_parts import PARTS, SERVOS, STEPPERS, ServoPart, StepperPart
from device_profiles.walter.float32 import real_text, unsigned16_of
from device_profiles.walter.settings import ArmMemory, Setting
from hil.vocab.firmware import Uart

INDENT = "   "
FULL_STEP_DEG = 1.8


def _pin(number: int) -> str:
    return f"pin({number})"


def _pins(of: StepperPart) -> str:
    return f"pin(EN,DIR,CLK)=({','.join(map(_pin, of.pins))})"


def stepper_setup(of: StepperPart) -> str:
    amps = real_text(of.amps, 1)
    return f"StepperSetup({of.label}){{ {_pins(of)} degreePerStep={real_text(FULL_STEP_DEG, 1)} amps={amps}}}"


def encoder_setup(of: StepperPart) -> str:
    address = f"I2CBus={of.i2c_bus} I2CAddr=0x{of.i2c_address:X}"
    return f"EncoderSetup({of.label}){{ {address} clockwise={int(of.is_encoder_clockwise)}}}"


def servo_setup(of: ServoPart) -> str:
    return f"ServoSetup({of.label}){{ herkulexMotorId={of.servo_id:X}}}"


def encoder_conf(of: StepperPart, setting: Setting) -> str:
    return f"EncoderConf({of.label}){{null={real_text(setting.null_deg, 1)}}}"


def servo_conf(of: ServoPart, setting: Setting) -> str:
    null, high, low = (real_text(x, 1) for x in (setting.null_deg, setting.max_deg, setting.min_deg))
    return f"ServoConf({of.label}) {{) {{null={null} maxAngle={high} minAngle={low}}}"


def stepper_conf(of: StepperPart, setting: Setting) -> str:
    limits = f"maxAngle={real_text(setting.max_deg, 1)} minAngle={real_text(setting.min_deg, 1)}"
    gains = ",".join(map(real_text, (setting.kP, setting.kI, setting.kD)))
    speed, acceleration = real_text(setting.speed_rpm), real_text(setting.acceleration_rpm_per_s)
    return (
        f"StepperConf({of.label}) {{ {limits} microSteps={of.microsteps} PID({gains})"
        f" maxSpeed={speed} maxAcc={acceleration} maxAcc={acceleration})"
    )


def stepper_line(of: StepperPart) -> str:
    return f"setup stepper {_pins(of)} M=(),{of.microsteps}) 1:{real_text(of.gear_ratio, 1)}"


def steps_line(of: StepperPart, setting: Setting, acceleration: float, speed: float) -> str:
    """Line with what the settings make in micro-steps a second."""
    most = unsigned16_of(setting.acceleration_rpm_per_s), unsigned16_of(setting.speed_rpm)
    whole = f"getMaxAcc={most[0]} getMaxRPM={most[1]}"
    return f"microsteps={of.microsteps} {whole} maxAcc={real_text(acceleration)} maxSpeed={real_text(speed)}"


class Logger:
    """Logger port. ``memory`` has which classes of text are on."""

    def __init__(self, uart: Uart, memory: ArmMemory) -> None:
        self._uart, self._memory = uart, memory

    def write(self, text: str) -> None:
        """Write text without a line's end."""
        self._uart.write(text.encode("latin-1"))

    def line(self, text: str = "") -> None:
        self.write(f"{text}\r\n")

    def setup(self, text: str) -> None:
        """Write a line of the class setup, if that is on."""
        if self._memory.log.setup:
            self.line(text)

    def fatal(self, text: str) -> None:
        self.line(f"FATAL:{text}")

    def failed_reading(self, of: StepperPart, failures: int) -> None:
        """Write that an encoder has not answered; failures: how often by now."""
        self.line(f"{of.label}{failures}.retry ERROR:enc comm")

    def settings(self) -> None:
        """Write the list of settings."""
        flags = vars(self._memory.log).items()
        self.line("EEPROM")
        self.line(f"{INDENT}LOG=({''.join(f' {name}' for name, is_on in flags if is_on)})")
        for part, setting in zip(PARTS, self._memory.actuators, strict=True):
            self.line(f"{INDENT}motor[{part.number}]:ActuatorConf({part.label})")
            if isinstance(part, StepperPart):
                self.line(INDENT + stepper_conf(part, setting))
                self.line(INDENT + encoder_conf(part, setting))
            else:
                self.line(INDENT + servo_conf(part, setting))
            self.line()

    def configuration(self) -> None:
        """Write what is built in, then the list of settings."""
        self.line("ACTUATOR SETUP")
        for stepper in STEPPERS:
            self.line(INDENT + stepper_setup(stepper))
            self.line(INDENT + encoder_setup(stepper))
        for servo in SERVOS:
            self.line(INDENT + servo_setup(servo))
        self.line("ACTUATOR CONFIG")
        self.settings()
