"""Numbers of the native core's face, and what it tells as dictionaries.

Written by `make abi` from native/abi.def and the C headers: change those.
"""

from enum import IntEnum
from typing import TypedDict

TABLE_LEN = 16384
"""Angles in a Mechaduino's calibration table, one for each count of its encoder."""
HISTOGRAM_LEN = 320
"""Buckets of a histogram of times: bucket b < 8 counts values of b ns; the others those of [(8 + b % 8) << (b
/ 8 - 1), (9 + b % 8) << (b / 8 - 1)) ns, up to 2^42."""
WATCHES = 17
"""Watches of an axis."""
WIRES = 16
"""Wires from the outputs of an axis."""
SWITCHES = 8
"""Switches of an axis."""
CONTACT_OPEN = 1
"""A contact that stays open."""
CONTACT_CLOSED = 2
"""A contact that stays closed."""
LIMIT_TEETH_RPM = 500000
"""The most a shaft turns, times its rotor's teeth: 10,000 rpm with 50 teeth, a third of an electrical turn in
a step of the full plant."""
LIMIT_RPM = 30000
"""The most that a shaft turns, whatever its teeth."""
MOTION_QUEUE = 30
"""Positions of a motion engine's queue."""
MOTION_SLOTS = 32
"""Entries of a motion engine: continuous, queue, one-shot."""
MOTION_CONTINUOUS_SLOT = 0
"""The entry of continuous motion; 1 to 30 are the queue."""
MOTION_ONE_SHOT_SLOT = 31
"""The entry of a single command."""


class Law(IntEnum):
    """Control laws, by the names that profiles give them."""

    mechaduino = 0
    """the Mechaduino's closed loop"""
    sac = 1
    """the SAC's motion engine"""
    walter = 2
    """a joint of Walter's Cortex, and its main loop"""
    a3967 = 3
    """a driver that steps by its pins, with the translator of an A3967"""
    pin_bank = 4
    """a microcontroller's pins, and no motor"""
    as5047d = 5
    """an encoder that reads a magnet on another axis's shaft, and no motor"""
    own_fields = 6
    """a board without a motor, which has fields of its own alone"""


class Lanes(IntEnum):
    """Widths in which axes move together, by the names that users know."""

    none = 0
    """each axis alone"""
    any = 1
    """four axes, for any processor"""
    avx2 = 2
    """four axes, with the instructions AVX2"""
    avx512 = 3
    """eight axes, with the instructions AVX-512 F, DQ, VL and BW"""


class Kind(IntEnum):
    """Kinds of axis that have a field."""

    any = 0
    """a field of every axis; the others are bits, which may be set together"""
    servo = 1
    """of axes with a loop and an encoder"""
    stepper = 2
    """of axes with a motion engine"""
    joint = 16
    """of joints that pulses turn through a gear, with an encoder behind it"""
    driver = 4
    """of axes whose driver steps by its pins"""
    pin_bank = 8
    """of pins without a motor, which have no field of ANY but the time"""
    encoder_chip = 32
    """of an encoder without a motor, which has no field of ANY but the time"""
    servo_chip = 33
    """of servos and of such encoders"""
    stepper_chip = 34
    """of steppers and of such encoders"""
    own_fields = 64
    """of boards without a motor or pins, which have no field of ANY but the time"""
    servo_driver = 5
    """of both"""
    stepper_driver = 6
    """of both"""


class Event(IntEnum):
    """Events from a board's interrupts, by the names that firmwares know."""

    step_response = 1
    """value: yw * 1024, the number that 'j' prints before truncation"""
    enable = 2
    """value: level of the enable input after a change"""
    command_begun = 3
    """of a stepper that reports (HIL_MOTION_REPORT): OP SA rose; value: its slot"""
    command_ended = 4
    """and fell"""
    estop = 5
    """value: level of a stepper's Estop input after a change"""
    reading_failed = 6
    """a joint's encoder did not answer; value: readings that have failed in a row"""
    pulses_ended = 7
    """the last pulse of a train at a pin has ended; value: the pin"""
    sent = 8
    """a program's serial interface begins a frame; value: its bits after the start bit, without stop bits, +
    1024 (their number + 16 times a bit's length in 1/256 cycles)"""
    chip_reset = 9
    """a program's processor has reset itself; value: the cause, a bit of MCUSR"""
    program_note = 10
    """something that its user should know; value: avr_note + 256 times what it is about"""
    eeprom_written = 11
    """a program has written a byte of its EEPROM; value: its address"""
    flash_written = 12
    """a program has written a page of its flash; value: its byte address"""
    line_driver = 13
    """the output that enables the driver of a processor's line has changed; value: its level"""
    halted = 14
    """a program stands for who debugs it; value: the byte address of its next instruction"""
    control = 15
    """a control interrupt of a firmware that has a controller of its own; value: yw"""
    step = 16
    """a rising edge at the step input of a firmware that has an interrupt of its own for it; value: 1"""


class ProcessorMemory(IntEnum):
    """Memories of a processor, with their bytes."""

    flash = 0
    """32,768 bytes"""
    eeprom = 1
    """1,024 bytes"""
    data = 2
    """2,304 bytes: registers, I/O, SRAM"""


class AxisFault(IntEnum):
    """Faults of an axis that are set to a value; 0: right again."""

    jam = 0
    """1: the rotor stands"""
    open_a = 1
    """1: no current in coil A"""
    open_b = 2
    """1: no current in coil B"""
    slip_counts = 3
    """counts that the encoder's magnet has slipped"""
    noise_counts = 4
    """standard deviation of a reading, counts"""
    noise_seed = 5
    """a whole number"""
    supply_V = 6
    """volts of the full plant's supply"""
    shift_rev = 7
    """turns that the shaft is moved by, once; not one that is jammed"""
    load_Nm = 8
    """Nm on the shaft beside load_torque_Nm as it was set"""
    freeze = 9
    """1: the encoder stays at the count that it has now"""
    open_line = 10
    """1: the encoder's data line is open and reads as all ones; a part on a bus does not answer"""
    clock_error_pct = 12
    """per cent by which a processor's clock is fast"""
    stuck_low = 13
    """pins of a processor that are stuck at 0, a bit each"""
    stuck_high = 14
    """pins of a processor that are stuck at 1, a bit each"""
    swapped_a = 15
    """1: coil A's two wires are swapped"""
    swapped_b = 16
    """1: coil B's two wires are swapped"""
    silent_rate = 11
    """part of the readings that a joint's encoder or servo does not answer, 0 to 1"""


class ServoInput(IntEnum):
    """Inputs of a servo; two names of one number are the same pin."""

    D0 = 0
    """direction: high is towards smaller counts"""
    D1 = 1
    """step, rising edge"""
    D2 = 2
    """enable, active low"""
    D3 = 3
    """free"""
    dir = 0
    """D0 as the step/dir interface names it"""
    step = 1
    """D1"""
    enable = 2
    """D2"""


class StepperInput(IntEnum):
    """Inputs of a stepper's controller."""

    sync = 0
    """falling edge: what is held begins"""
    Estop = 1
    """active low"""
    RST = 2
    """active low, read at a cold start"""
    EnA = 3
    """an encoder's channel A"""
    EnB = 4
    """and B"""


class DriverInput(IntEnum):
    """Inputs of a driver that steps by its pins."""

    dir = 0
    """high: towards larger angles"""
    step = 1
    """rising edge; the number is that of a servo's, which sources of runs drive"""
    enable = 2
    """active low"""
    MS1 = 3
    """microsteps, lower bit"""
    MS2 = 4
    """and higher"""
    sleep = 5
    """active low"""
    reset = 6
    """active low"""


class BankPin(IntEnum):
    """Pins of a microcontroller; each can be an input and an output."""

    D0 = 0
    """digital pin; RX of the board's serial interface"""
    D1 = 1
    """digital pin; TX of it"""
    D2 = 2
    """digital pin"""
    D3 = 3
    """digital pin"""
    D4 = 4
    """digital pin"""
    D5 = 5
    """digital pin"""
    D6 = 6
    """digital pin"""
    D7 = 7
    """digital pin"""
    D8 = 8
    """digital pin"""
    D9 = 9
    """digital pin"""
    D10 = 10
    """digital pin"""
    D11 = 11
    """digital pin"""
    D12 = 12
    """digital pin"""
    D13 = 13
    """digital pin"""
    A0 = 14
    """analogue pin as a digital one"""
    A1 = 15
    """analogue pin as a digital one"""
    A2 = 16
    """analogue pin as a digital one"""
    A3 = 17
    """analogue pin as a digital one"""
    A4 = 18
    """analogue pin as a digital one"""
    A5 = 19
    """analogue pin as a digital one"""


class SpiInput(IntEnum):
    """Inputs of a chip that is read over SPI."""

    CSn = 0
    """chip select, active low"""
    CLK = 1
    """clock"""
    MOSI = 2
    """data to the chip"""


class SpiOutput(IntEnum):
    """Outputs of such a chip."""

    MISO = 0
    """data from it; open while CSn is high"""


class Output(IntEnum):
    """Outputs of a stepper's controller."""

    clk = 0
    """step pulses"""
    dir = 1
    """direction"""
    OP_SA = 2
    """1 while a command runs, if it is enabled"""
    OP_SB = 3
    """its inverse, if it is enabled"""
    MS1 = 4
    """the driver's microsteps, lowest bit"""
    MS2 = 5
    """middle bit"""
    MS3 = 6
    """highest bit"""


class MotionState(IntEnum):
    """States of a motion engine."""

    standby = 0
    """of a motion engine: nothing runs"""
    accel = 1
    """the speed grows"""
    cruise = 2
    """the speed stays"""
    decel = 3
    """the speed falls"""
    stop = 4
    """it falls because somebody said so"""


class Call(IntEnum):
    """Calls of a motion engine, with what they take."""

    enqueue = 0
    """slot"""
    once = 1
    """slot; 0: continuous"""
    retarget = 2
    """rpm, cycle_us"""
    pulse = 3
    """1: counter-clockwise"""
    stop = 4
    """deceleration in hundredths, -1: at once"""
    next = 5
    """1: with this command's deceleration, 0: at once"""
    finish = 6
    """nothing"""
    loop_bounds = 7
    """start, finish; 0: leave it"""
    loop_passes = 8
    """passes, 0: forever"""
    loop_array = 9
    """passes, 0: forever"""
    release_sync = 10
    """nothing"""
    gap = 11
    """1: on"""
    throttle = 12
    """1: the encoder changes the speed"""
    report = 13
    """1: commands' beginnings and ends are events; off after a power-up"""


class ServoCall(IntEnum):
    """Calls of a servo's firmware, with what they take."""

    spr = 0
    """steps a turn of the motor that the firmware was compiled for, 1 to 1000; 200 after a power-up"""
    own_law = 1
    """1: control interrupts measure, and are events; off after a power-up"""
    own_step = 2
    """1: rising edges at the step input are events, and nothing else; off after a power-up"""
    u = 3
    """what a controller of its own has made: the effort"""
    e = 4
    """and the error"""


class WalterCall(IntEnum):
    """Calls of Walter's Cortex, with what they take and answer."""

    start = 0
    """the first joint: the board has its power, and its clocks begin"""
    next_pass = 1
    """nothing; answers when the loop's next pass begins"""
    pass_before = 2
    """nothing; answers the ms that the pass before the next one went by"""
    stop = 3
    """nothing; nothing runs until the next call"""
    hold = 4
    """ms after which a second wait begins, or 0; pulses alone go on, until the next call"""
    poll = 5
    """nothing; one look for pulses, and the time that timers go by"""
    poll_again = 6
    """nothing; one more look for pulses"""
    finish = 7
    """nothing; what a pass does after that, and passes from then on"""
    go_on = 8
    """nothing; poll and finish"""
    know = 9
    """1: the loop knows its joints, 0: it does not"""
    power = 10
    """1: the motors have their 24 V"""
    clock = 11
    """nothing; answers the microseconds since start"""
    set_min = 12
    """deg"""
    set_max = 13
    """deg"""
    set_null = 14
    """deg, as the encoder counts"""
    set_speed = 15
    """rpm; for the next set_up"""
    set_acceleration = 16
    """rpm/s"""
    set_p = 17
    """gain"""
    set_i = 18
    """gain"""
    passed = 19
    """1: its encoder is to be read"""
    enable = 20
    """1: its driver is on"""
    set_up = 21
    """nothing; ends its motion, and sets its step generator up"""
    due = 22
    """nothing; its next sample is due at once"""
    place = 23
    """deg; a servo has gone there"""
    move = 24
    """to_deg, duration_ms; within its limits"""
    move_by = 25
    """by_deg, duration_ms"""
    ramp = 26
    """from_deg, to_deg, duration_ms"""
    ramp_at = 27
    """ahead_ms; answers the ramp's angle then"""
    rest = 28
    """nothing; it has no ramp any more"""
    measure = 29
    """deg; what it takes its angle for"""
    settle = 30
    """nothing; its encoder's angle is where it is, and where it is to be"""
    answers = 31
    """nothing; answers 1 if encoder or servo would answer now"""
    connect = 32
    """nothing; looks for its encoder, and answers its angle, or -1"""
    read = 33
    """nothing; reads its encoder without filter; answers 0, or -1"""
    where = 34
    """nothing; answers where the joint is, deg"""
    read_deg = 35
    """nothing; answers the encoder's angle as it was read last, without the offset"""
    full_speed = 36
    """nothing; answers what its settings make of it, micro-steps/s"""
    full_acceleration = 37
    """nothing; the same, micro-steps/s2"""
    clock_ns = 38
    """nothing; answers the nanoseconds since start"""


class RtStats(TypedDict):
    """Statistics of the real-time thread."""

    ticks: int
    missed: int
    elapsed_ns: int
    overruns: int
    wake_latency: list[int]
    longest_latency_ns: int
    latency_total_ns: int
    fifo_errno: int
    pin_errno: int
    lock_errno: int
    running: int


class ReplayRow(TypedDict):
    """One control step of the Mechaduino's law."""

    y_meas: float
    y_excite: float
    yw: float
    e: float
    ITerm: float
    DTerm: float
    v: float
    u: float
    U: int
    wrap_count: int
    vref1: int
    vref2: int
    in1: int
    in2: int
    in3: int
    in4: int
    led: int


class JointRow(TypedDict):
    """State of a joint of Walter's Cortex."""

    measured_deg: float
    to_be_deg: float
    integral: float
    speed: float
    acceleration: float
    c0: float
    cn: float
    cmin: float
    position: int
    target: int
    n: int
    interval_us: int
    dir: int
