"""Contract between a board's firmware and its runtime: requests that firmware yields, interfaces it uses.

Firmware is a generator that yields one of the requests below and is resumed at the simulated time at which
the request is met, with the request's answer as the value of the ``yield``.
"""

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import field
from typing import Any, NamedTuple, Protocol

from hil.vocab.address import DeviceParts
from hil.vocab.framing import Framing, Item
from hil.vocab.late_dataclass import dataclass
from hil.vocab.line_format import LineFormat
from hil.vocab.motion import Motion
from hil.vocab.own_fields import OwnFields
from hil.vocab.path import PathPiece
from hil.vocab.time import NS_PER_MS, NS_PER_US, SimTimeNs


class Pulses(NamedTuple):
    """Pulses one after the other. Each rises ``period_ns`` after the one before, the first one after what was
    before it, and is high for ``high_ns``, which is less."""

    number: int
    period_ns: int
    high_ns: int


class Pins(Protocol):
    """Pins of a board by name, as in ``D6``. After power-up all are inputs. An unknown name is a KeyError."""

    def write(self, pin: str, level: int) -> None:
        """Drive a pin to a level, 0 or 1, from now on: it is an output."""

    def let_go(self, pin: str) -> None:
        """Make a pin an input again."""

    def read(self, pin: str) -> int:
        """Level of a pin now, 0 or 1: the board's own if it drives it."""

    def pulse(self, pin: str, rows: Sequence[Pulses]) -> None:
        """Begin a train of pulses at a pin, instead of the one before, which ends at once; no rows: none.
        When the last pulse has ended, the interrupt ``pulses_ended`` comes."""

    @property
    def pulses_left(self) -> int:
        """Pulses of the train that are to come."""


class ProcessorPin(NamedTuple):
    """Pin of a processor: its level, what the chip does there, and the part of the time that its PWM is high
    (None: it has none)."""

    level: int
    is_output: bool
    has_pull_up: bool
    duty: float | None


class UartFrame(NamedTuple):
    """Frame that a processor's serial interface sends, of 5 to 9 data bits. Of nine, ``byte`` has the first
    eight, and the ninth stands where a parity bit would that is always that (8M1 or 8S1)."""

    byte: int
    line_format: LineFormat
    baud: int


class Processor(Protocol):
    """Microcontroller that runs a user's program, an ATmega328P. After power-up it stands still, its flash
    and EEPROM are empty, and the firmware drives the pins. What is outside of a memory is a ValueError."""

    is_running: bool
    """True from ``reset`` on, until it is held, or the power goes."""
    fuses: tuple[int, int, int, int]
    """Fuses low, high, extended, and the lock bits."""
    clock_Hz: int

    @property
    def flash(self) -> bytes:
        """Whole content of the flash, 32,768 bytes."""

    def load(self, at: int, data: bytes) -> None:
        """Write bytes into the flash."""

    @property
    def eeprom(self) -> bytes:
        """Whole content of the EEPROM, 1,024 bytes."""

    def load_eeprom(self, at: int, data: bytes) -> None:
        """Write bytes into the EEPROM, at once."""

    def data(self, at: int, count: int) -> bytes:
        """Bytes of the data space (registers, I/O, SRAM: 2,304 bytes), without what a read does there."""

    def poke(self, address: int, value: int) -> None:
        """Write a byte of the data space, without what a write does there."""

    def set_fuses(self, low: int, high: int, extended: int, lock: int, *, has_boot: bool = False) -> None:
        """Set fuses and lock bits. ``has_boot``: a boot loader that is not in the flash goes before the
        program after resets that the chip makes itself: it clears MCUSR, and turns the watchdog off."""

    def reset(self, causes: int, start_up_cycles: int = 0) -> None:
        """Reset it: MCUSR has the causes (1 power, 2 the pin, 4 brown-out, 8 watchdog). From now on its
        program runs, and drives the pins."""

    def set_stack_floor(self, address: int) -> None:
        """Let its user be told once the stack comes below this address of the data space, where the heap
        begins. After power-up it is 100h, where SRAM does."""

    def hold(self) -> None:
        """Stop it where it is; the firmware drives the pins again."""

    @property
    def cycles(self) -> int:
        """Cycles of its clock since the power came; they stand still while it is held."""

    @property
    def program_counter(self) -> int:
        """Byte address of its next instruction."""

    @property
    def start_up_cycles(self) -> int:
        """Cycles of its clock from a reset to its first instruction, by its fuses."""

    def name_of(self, number: int) -> str | None:
        """Board's name of a pin by the chip's number, 0 to 19 for PD0 to PD7, PB0 to PB5, PC0 to PC5; None:
        the board has none there."""

    def pin(self, name: str) -> ProcessorPin:
        """State of a pin now."""

    def frame(self, value: float) -> UartFrame:
        """Frame of an event ``sent``."""


@dataclass(frozen=True)
class Delay:
    """Wait; answers None. The board's ``delay()``: interrupts go on, the main loop does not."""

    duration_ns: int


@dataclass(frozen=True)
class ByteAvailable:
    """Wait until a UART of the board has an unread byte, at most ``timeout_ns`` (None: forever).

    Answers True, or False on the time-out. A byte that arrives exactly at the time-out is too late.
    """

    timeout_ns: int | None = None
    takes: Callable[[Sequence[Item]], bool] | None = None
    """Taker of packets for everybody, which spares the main loop a turn: where nothing else has come, it is
    offered them, split already, before they are in the UART's buffer. True: it has handled them, in no time
    and as the main loop would have, and has changed no UART but by writing. False: it has done nothing. Only
    without a time-out."""


@dataclass(frozen=True)
class Commit:
    """Store ``data`` under ``name`` in the board's non-volatile memory; answers True when it is
    durable, False when the store failed (the old content is then what a read-back shows)."""

    name: str
    data: bytes


@dataclass(frozen=True)
class EventAvailable:
    """Wait until an interrupt has come, from now on; answers None."""


Request = Delay | ByteAvailable | Commit | EventAvailable
Main = Generator[Request, Any, None]
"""A firmware's main program; it never returns while the board has power."""


@dataclass(frozen=True)
class CoreEvent:
    """Event that a board's interrupt caused, with its exact time. ``axis``: name of the axis; ``kind`` is one
    of the core's event names (``hil.core.events``); ``value`` is in the kind's unit."""

    at_ns: SimTimeNs
    axis: str
    kind: str
    value: float


ARDUINO_WRAP = 1 << 32
"""Value after which ``millis()`` and ``micros()`` of an Arduino begin again: ``unsigned long`` has 32 bits.
Source: Arduino Language Reference, millis(), micros()."""
MAIN, NETWORK = "main", "network"
"""Usual names of a board's first UART, and of the one that ``network:`` of a configuration is about."""


class Uart(Protocol):
    """A serial interface of the board as its sketch sees it."""

    baud: int | None
    """Speed of the line now, in baud; None where bytes take no time (USB)."""

    def available(self) -> int:
        """Unread bytes in the receive buffer, the one held by ``peek`` not counted."""

    def read(self) -> int:
        """The next byte, or -1."""

    def peek(self) -> int:
        """The next byte without taking it, or -1; the byte is held until ``read``."""

    def read_all(self) -> bytes:
        """Read all unread bytes."""

    def write(self, data: bytes) -> None:
        """Send bytes, now."""

    def wake_on(self, framing: Framing | None) -> None:
        """Let only a packet's end meet a ``ByteAvailable``: the main loop polls what comes before it into a
        memory of its own. None, as after power-up: every byte does."""

    def listen_for(self, address: int | None) -> None:
        """Receive only packets for this address and for all, on a segment. None, as after power-up: any."""

    def set_baud(self, baud: int | None) -> None:
        """Set the line's speed in baud; None: the one at power-up. No effect without a line (USB)."""

    def reaction_ns(self) -> int:
        """Time by which an answer of this board begins later than its turnaround is over, drawn for each; 0
        where no other board of the segment differs (`reaction_us` of a segment), or there is none."""


class Axis(Protocol):
    """One axis as a firmware drives it, at the present simulated time."""

    def get(self, field: str) -> float:
        """A field of the axis by its name in the core's table."""

    def set(self, field: str, value: float) -> None:
        """Set a writable field of the axis by its name in the core's table."""

    def output(self, theta_deg: float, effort: int) -> None:
        """Commutate open loop: coil currents for the angle, at the effort in driver counts."""

    def vref(self, vref1: int, vref2: int) -> None:
        """Set the coils' current commands, in counts; their directions stay."""

    def loop(self, on: bool) -> None:
        """Start or stop the control interrupt. Its first step comes one period after the start."""

    def spi(self, command: int) -> int:
        """Exchange one 16-bit frame with the encoder; the answer belongs to the frame before."""

    def table(self) -> bytes:
        """The encoder's look-up table: 16,384 float32 of the machine's byte order, in degrees."""

    def write_table(self, packed: bytes) -> None:
        """Replace the look-up table; the shape of ``table()``."""

    def follow(self, path: Sequence[PathPiece], start_ns: int = 0) -> None:
        """Let the set-point follow a path from ``start_ns`` on, or from now, and keep its end. Setting it or
        the mode, or stopping the loop, ends that."""

    def drive(self, rows: Sequence[tuple[int, str, int, int, int]]) -> None:
        """Play edges on the inputs from now on: rows as ``hil.wire.step_dir.Edges``."""


class ArmJoint(Axis, Protocol):
    """Joint of an arm. The joints of a board have one main loop, which the first one holds."""

    def do(self, call: str, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> float:
        """Carry out a call by its name in ``hil.core.abi.WalterCall``, which says what it takes and answers.
        Raises KeyError for another name."""


class ServoAxis(Axis, Protocol):
    """Axis with a loop and an encoder, whose firmware may be of another build than the stock one."""

    def do(self, call: str, value: float = 0.0) -> float:
        """Carry out a call of ``hil.core.abi.ServoCall``, by its name. Raises KeyError for another one."""


MOTION, PINS, JOINT, SERVO_LOOP = "motion", "pins", "joint", "servo_loop"
"""Faces of axes that are more than ``Axis``: ``Motion``, ``Pins``, ``ArmJoint``."""


@dataclass(frozen=True)
class Board:
    """Interfaces that a firmware is made with: the board around the microcontroller."""

    uarts: DeviceParts[Uart]
    """UARTs by name, as the profile names them."""
    axes: DeviceParts[Axis]
    """Axes by name; a board without a motor has none."""
    nvm: Mapping[str, bytes]
    """Named contents of the non-volatile memory; follows each ``Commit`` that was answered True."""
    facts: Mapping[str, int] = field(default_factory=dict)
    """Numbers that the build of a firmware fixes, such as ``lookup_address``."""
    build: Mapping[str, float | str] = field(default_factory=dict)
    """Parameters of the firmware's build, by their names in ``profile.yaml``."""
    faces: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """Axes that are more than ``Axis``, by their face and their names."""
    note: Callable[[str, str | None], None] = lambda about, text: None
    """Sets a note for the operator on what the board cannot print: (topic, a line); None removes it."""

    processors: Mapping[str, Processor] = field(default_factory=dict)
    """Processors by the names of the axes whose pins they have."""
    reset_cause: Callable[[], str] = lambda: "power"
    """Tells what has started the firmware: see ``started_by``."""

    fields: OwnFields = field(default_factory=lambda: OwnFields({}, None))
    """Fields of the board's own, as ``fields`` of its ``profile.yaml`` has them, by name: to read and to
    write. At power-up they have the values that stand there; inputs have what was set from outside."""
    clock: Callable[[], SimTimeNs] = lambda: SimTimeNs(0)
    """Tells the simulated time: see ``now_ns``."""
    started_ns: Callable[[], SimTimeNs] = lambda: SimTimeNs(0)
    """Tells the simulated time of the firmware's start: see ``millis``."""
    tell: Callable[[str, float | None], None] = lambda name, value: None
    """Tells a value of the firmware's own to those who look at the board, by a name; None: no more."""

    @property
    def now_ns(self) -> SimTimeNs:
        """Simulated time of the bench now, in nanoseconds. It passes only while the firmware waits."""
        return self.clock()

    def millis(self) -> int:
        """Milliseconds since the firmware's start, as an Arduino counts them: after 2^32, 49.7 days, from 0
        again."""
        return (self.clock() - self.started_ns()) // NS_PER_MS % ARDUINO_WRAP

    def micros(self) -> int:
        """Microseconds since the firmware's start, as ``millis``: from 0 again after 71.6 minutes."""
        return (self.clock() - self.started_ns()) // NS_PER_US % ARDUINO_WRAP

    @property
    def motions(self) -> Mapping[str, Motion]:
        """Motion engines by the names of the axes that they make step pulses for."""
        return self.faces.get(MOTION, {})

    @property
    def banks(self) -> Mapping[str, Pins]:
        """Pins of the microcontroller, by the names of the axes that have them instead of a motor."""
        return self.faces.get(PINS, {})

    @property
    def processor(self) -> Processor:
        """Processor of the first axis. Raises KeyError: it has none."""
        return self.processors[self.axes.first]

    @property
    def started_by(self) -> str:
        """Reason for which the firmware was started: ``power``, or ``line`` where a client has opened its
        port and the board's RESET goes by that."""
        return self.reset_cause()

    @property
    def joints(self) -> Mapping[str, ArmJoint]:
        """Joints by the names of their axes, on a board that drives an arm."""
        return self.faces.get(JOINT, {})

    @property
    def servo(self) -> ServoAxis:
        """The first axis, which is a servo. Raises KeyError: it is none."""
        servo: ServoAxis = self.faces[SERVO_LOOP][self.axes.first]
        return servo

    @property
    def uart(self) -> Uart:
        """The first UART."""
        return self.uarts[""]

    @property
    def axis(self) -> Axis:
        """The first axis. Raises KeyError: there is none."""
        return self.axes[""]

    @property
    def motion(self) -> Motion:
        """The first axis's motion engine. Raises KeyError: it makes no step pulses."""
        return self.motions[self.axes.first]

    @property
    def pins(self) -> Pins:
        """Pins of the first axis. Raises KeyError: it has a motor instead."""
        return self.banks[self.axes.first]


class Firmware(Protocol):
    """A board's program. Made once for each power-up; everything it knows between power-ups is
    in the non-volatile memory it is made with."""

    def main(self) -> Main:
        """Run the board's setup() and loop()."""

    def interrupt(self, event: CoreEvent) -> None:
        """Handle something that happened outside the main loop, at the event's own time.

        One whose board has a processor may have ``line_opened() -> bool`` too: called when a client opens the
        first port; False: that is no reset this time.
        """
