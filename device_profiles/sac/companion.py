"""Dialogues with a SAC's terminal, twin or real: the work of its companion program, by any terminal.

Source: SAC user manual, companion app, Appendix C.
"""

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import Any

from device_profiles.sac.companion_files import ROWS, QueueFile, Row
from device_profiles.sac.network import DC1, DC2
from device_profiles.sac.screen_reading import (
    CLOCK_CORRECTION_US,
    DEVICE_ID,
    INTERRUPT_OVERHEAD_US,
    MICROSTEP_EXPONENT,
    SOFT_OPS,
    STEPS_PER_REV,
    number_on,
    read_listing,
    read_speed,
)
from device_profiles.sac.terminal import PROMPT
from device_profiles.sac.typed_text import WORD, f_of
from hil.vocab.dialogue import (
    BoardRefusal,
    Dialogue,
    DialogueError,
    Heard,
    Listen,
    Progress,
    Refusal,
    Send,
    Step,
)
from hil.vocab.time import NS_PER_MS, NS_PER_S

_PROMPT = PROMPT.encode()
_SIGNALS = DC1 + DC2
START_UP_NS = 1300 * NS_PER_MS
"""Time for a start: opening the port may start a board; a byte in its first second restores the factory's
settings."""
ANSWER_NS = 5 * NS_PER_S
"""Maximum wait for an answer. The longest, 30 rows or 1.3 kB, takes 0.4 s at 38400 baud, 30 s at 488."""
CALIBRATION_S = 60
_ECHO_US = 200_000
"""Start wait of a calibration, so that the start signal does not queue behind echo and prompt."""


class BoardTerminal:
    """Command line of a board; each method is a dialogue."""

    def __init__(self) -> None:
        self._unread = b""

    def sync(self) -> Dialogue[None]:
        """Reach a prompt outside the program modes, past a cold start."""
        heard = yield from self.quiet(START_UP_NS)
        yield Send(b"\r")
        try:
            heard += yield from self._until_prompt(START_UP_NS)
            yield from self.ask("x")  # leaves a program mode, and means nothing outside one
        except DialogueError:
            if not heard and not self._unread:
                raise DialogueError(
                    "nothing answers; look whether it is on, this is its terminal, and --baud is right"
                ) from None
            shown = (heard + self._unread)[-60:]
            raise DialogueError(f"the answer is not from a SAC at its prompt: {shown!r}") from None

    def ask(self, line: str, timeout_ns: int = ANSWER_NS) -> Dialogue[list[str]]:
        """Type a line; answers the text up to the prompt, without the echo."""
        yield Send(f"{line}\r".encode("latin-1"))
        answer = yield from self._until_prompt(timeout_ns)
        echo, *lines = answer.decode("latin-1").split("\r\n")
        if echo != line:
            raise DialogueError(f'"{line}" came back as "{echo[:80]}": characters were lost on the line')
        return lines

    def screen(self, line: str) -> Dialogue[str]:
        return "\n".join((yield from self.ask(line)))

    def _until_prompt(self, timeout_ns: int) -> Generator[Step, Any, bytes]:
        while not (_PROMPT in self._unread and self._unread.translate(None, _SIGNALS).endswith(_PROMPT)):
            heard: Heard = yield Listen(timeout_ns)
            if not heard.data:
                raise DialogueError(f"no prompt after {self._unread[-60:]!r}")
            self._unread += heard.data
        answer, self._unread = self._unread.translate(None, _SIGNALS), b""
        return answer.removesuffix(_PROMPT)

    def quiet(self, for_ns: int) -> Generator[Step, Any, bytes]:
        """Collect the bytes that come until nothing has come for so long."""
        heard = b""
        while piece := (yield Listen(for_ns)).data:
            heard += piece
        return heard


def load(file: QueueFile, *, store: bool) -> Dialogue[int]:
    """Write a queue into a board, read it back, and with ``store`` save it in the EEPROM. Answers the rows.

    Raises:
        Refusal: RPM and cycle of a row cannot belong together, or the motor runs; nothing was written.
        DialogueError: it stopped; says at which row.
    """
    terminal = BoardTerminal()
    yield from terminal.sync()
    steps_per_rev = number_on((yield from terminal.screen("cc")), STEPS_PER_REV)
    problems = [
        f"{where}:1: RPM {row.rpm} and cycle {row.cycle_us} contradict each other"
        f" at {steps_per_rev} steps a turn; write cycle {f_of(steps_per_rev) // row.rpm}"
        for row, where in zip(file.rows, file.where, strict=True)
        if not row.is_possible(steps_per_rev)
    ]
    if problems:
        raise Refusal("\n".join(problems))
    yield from stands_still(terminal)
    for row in file.rows:
        try:
            yield from terminal.ask(row.command(steps_per_rev))
            yield Progress(row.position, ROWS, f"row {row.position}")
        except DialogueError as error:
            raise DialogueError(
                f"stopped at row {row.position} of {ROWS}: {error};"
                " the board's queue is a mixture of old and new rows, load it again"
            ) from error
    try:
        shown = yield from _listing(terminal)
    except DialogueError as error:
        raise DialogueError(
            f"all rows were sent, but could not be read back: {error}; load them again"
        ) from error
    if wrong := _differences(file.rows, shown):
        raise DialogueError("the board does not have what was sent:\n" + "\n".join(wrong))
    if store:
        try:
            yield from terminal.ask("qs")
        except DialogueError as error:
            raise DialogueError(
                f"all rows are in the board, but perhaps not in its EEPROM: {error}; store them again"
            ) from error
    return len(shown)


def _differences(sent: Sequence[Row], shown: Sequence[Row]) -> list[str]:
    return [
        f"row {row.position}: sent {row}, the board shows {now}"
        for row, now in zip(sent, shown, strict=True)
        if row != now
    ]


def differences(sent: Sequence[Row]) -> Dialogue[list[str]]:
    """Compare rows that were sent over the network with the board's listing."""
    return _differences(sent, (yield from save()))


def device_id() -> Dialogue[int]:
    """Read the board's address on the network."""
    terminal = BoardTerminal()
    yield from terminal.sync()
    return number_on((yield from terminal.screen("cc")), DEVICE_ID)


def save() -> Dialogue[list[Row]]:
    """Read the queue of a board, all of it."""
    terminal = BoardTerminal()
    yield from terminal.sync()
    return (yield from _listing(terminal))


def commands(lines: Sequence[str]) -> Dialogue[list[str]]:
    """Send lines, each after the prompt of the one before; answers what the board says to them."""
    terminal = BoardTerminal()
    yield from terminal.sync()
    said = []
    for line in lines:
        said += [answer for answer in (yield from terminal.ask(line, 40 * NS_PER_S)) if answer]
    return said


def stands_still(terminal: BoardTerminal, timeout_ns: int = ANSWER_NS) -> Dialogue[None]:
    """Check that the motor stands.

    Raises:
        BoardRefusal: the motor runs.
    """
    lines = yield from terminal.ask("vd", timeout_ns)
    if read_speed(lines) != (0, 0):
        raise BoardRefusal("the motor runs; stop it first (S): the queue must not change while it runs")


def _listing(terminal: BoardTerminal) -> Dialogue[list[Row]]:
    return read_listing((yield from terminal.ask("q", 40 * NS_PER_S))).rows


@dataclass(frozen=True)
class Calibration:
    """Motion of a minute as the board timed it, against the clock of who listened."""

    rpm: int
    nominal_ns: int
    measured_ns: int
    pulses: int
    interrupt_overhead_us: int
    clock_correction_us: int

    @property
    def factor(self) -> float:
        """Ratio of measured to nominal time: above 1 the board is slow."""
        return self.measured_ns / self.nominal_ns

    @property
    def correction_us(self) -> int:
        return round((self.nominal_ns - self.measured_ns) / 1000 / self.pulses)


def calibrate(rpm: int) -> Dialogue[Calibration]:
    """Run for a minute at a speed, from the first pulse on, and time soft_ops' start and stop.

    Raises:
        Refusal: the motor runs, or the speed is none.
        DialogueError: it stopped, or no signal came.
    """
    terminal = BoardTerminal()
    yield from terminal.sync()
    screen = yield from terminal.screen("cc")
    steps_per_rev = number_on(screen, STEPS_PER_REV)
    cycle_us = f_of(steps_per_rev) // rpm if rpm > 0 else 0
    steps = rpm * steps_per_rev
    if not 2 <= cycle_us <= WORD // 2 or steps >= WORD:
        raise Refusal(f"{rpm} RPM is no speed at {steps_per_rev} steps a turn")
    yield from stands_still(terminal)
    was_on = bool(number_on((yield from terminal.screen("cf")), SOFT_OPS))
    yield from terminal.ask("$O1")
    yield Send(f"xm{steps}v{rpm}a999d999u0ft{_ECHO_US}\r".encode())
    begun_ns = yield from _signal(DC1[0], 3, 0)
    ended_ns = yield from _signal(DC2[0], CALIBRATION_S * 3 // 2, CALIBRATION_S)
    yield from terminal.sync()
    if not was_on:
        yield from terminal.ask("$O0")
    return Calibration(
        rpm=rpm,
        nominal_ns=steps * cycle_us * 1000,
        measured_ns=ended_ns - begun_ns,
        pulses=steps << number_on(screen, MICROSTEP_EXPONENT),
        interrupt_overhead_us=number_on(screen, INTERRUPT_OVERHEAD_US),
        clock_correction_us=number_on(screen, CLOCK_CORRECTION_US),
    )


def _signal(byte: int, timeout_s: int, progress_s: int) -> Dialogue[int]:
    """Wait for a signal and answer its time; reports progress each second."""
    start: Heard = yield Listen(0)
    heard = start
    while byte not in heard.data:
        waited_s = (heard.at_ns - start.at_ns) // NS_PER_S
        if waited_s >= timeout_s:
            what = "start" if byte == DC1[0] else "stop"
            raise DialogueError(f"no {what} signal came within {timeout_s} s; S stops the motor")
        if progress_s:
            yield Progress(min(waited_s, progress_s), progress_s, f"{waited_s} s")
        heard = yield Listen(NS_PER_S)
    return heard.at_ns


def stop_and_restore() -> Dialogue[None]:
    """Stop the motor and end soft_ops after a calibration that was broken off."""
    yield Send(b"S\r$O0\r")
    yield Listen(NS_PER_S)
