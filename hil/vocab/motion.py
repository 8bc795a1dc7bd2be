"""A pulse-generating motion engine as a firmware drives it: the contract between a step/dir controller's
command interpreter and its interrupts.

The engine holds the queue and runs it; the interpreter parses, keeps defaults, and shows. Everything acts
at the present simulated time.
"""

from typing import Protocol

from hil.vocab.late_dataclass import dataclass

QUEUE_LEN = 30
CONTINUOUS_SLOT, ONE_SHOT_SLOT = 0, QUEUE_LEN + 1
"""Slots of the engine's memory that are no queue positions."""


@dataclass(frozen=True)
class MotionEntry:
    """One motion command with every attribute resolved. Numbers are as the board holds them."""

    steps: int
    """Number of steps, unsigned 32 bits; pulses if ``is_pulses``. 0 in the continuous slot."""
    is_ccw: bool
    rpm: int
    cycle_us: int
    """Period of a full step at cruise, which sets the speed."""
    acc_hundredths: int
    dec_hundredths: int
    is_linear: bool
    extra_pulses: int
    """Extra pulses (``u``), 0 to 255."""
    is_sync: bool
    """True if the command is held until the sync is released."""
    wait_us: int
    """Start wait (``t``)."""
    is_pulses: bool
    """True if ``steps`` counts pulses instead of full steps."""


@dataclass(frozen=True)
class MotionSetup:
    """Parameters that the engine takes over at a cold start and at ``$R``."""

    steps_per_rev: int
    slow_rpm: int
    microstep_exponent: int
    pulse_us: int
    interrupt_overhead_us: int
    """Parameter ``ihd``."""
    clock_correction_us: int
    """Number of the parameter ``xclk``."""
    is_clock_internal: bool
    external_clock_Hz: int
    """Assumed frequency of the external clock (``xfreq``)."""
    is_cw_high: bool
    """Level of the direction pin for clockwise."""
    ops: int
    """Parameter ``ops``: bit 5 enables OP SA, bit 2 OP SB."""
    mode_pins: int
    """Mode pins MS3 MS2 MS1 as three bits."""


class Motion(Protocol):
    """Motion engine. Slots are 0 (continuous), 1 to 30 (queue), 31 (one-shot)."""

    def setup(self, setup: MotionSetup) -> None:
        """Take over parameters; ends all motion."""

    def entry(self, slot: int) -> MotionEntry: ...

    def write_entry(self, slot: int, entry: MotionEntry) -> None:
        """Change a slot; a running command keeps what it began with."""

    def enqueue(self, slot: int) -> None:
        """Append a queue entry to those that wait to be run."""

    def run_once(self, slot: int) -> None:
        """Preempt with a queue entry or ``ONE_SHOT_SLOT``; what is interrupted resumes with its next
        entry."""

    def run_continuous(self) -> None:
        """Preempt with ``CONTINUOUS_SLOT``."""

    def retarget(self, rpm: int, cycle_us: int) -> None:
        """Change the speed of a continuous motion (``v``, ``vc``); nothing otherwise."""

    def pulse(self, ccw: bool) -> None:
        """Make a single pulse (``+``, ``-``), only in STANDBY."""

    def stop(self, dec_hundredths: int | None) -> None:
        """End all: at once (None), or with this deceleration. Drops pending commands, loops, holds, waits."""

    def next(self, is_graceful: bool) -> None:
        """End the command and go on with the next: ``n`` (its deceleration) or ``N`` (at once)."""

    def finish(self) -> None:
        """End what runs in a controlled way (``l`` alone)."""

    def loop_start(self, slot: int) -> None:
        """Set a loop's start (``ls``)."""

    def loop_finish(self, slot: int) -> None:
        """Set a loop's end (``lf``)."""

    def loop_passes(self, passes: int) -> None:
        """Set a loop's passes (``ln``); 0: forever."""

    def loop_array(self, passes: int) -> None:
        """Run the xRef array (``lnn``) so many times; 0: forever."""

    def xref(self) -> tuple[int, ...]:
        """The 31 entries of the xRef array."""

    def write_xref(self, index: int, slot: int) -> None: ...

    def release_sync(self) -> None:
        """Release the sync (``y``)."""

    def gap(self, on: bool) -> None:
        """Switch GAP testing (``g``)."""

    def encoder_mode(self, is_throttle: bool) -> None:
        """Set the encoder mode (``$n``): follow or throttle."""

    def report(self, on: bool) -> None:
        """Report commands to the firmware's ``interrupt``: ``command_begun`` (value: its slot) and
        ``command_ended``, when OP SA rises and falls. Off after a power-up."""

    def get(self, field: str) -> float:
        """A field of the axis by its name in the core's table: ``motion_state``, ``rpm``, ``period_us``,
        ``queue_position``, ``pending``, ``pulses``..."""
