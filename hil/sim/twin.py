"""An emulated board: its firmware and its hardware, driven by simulated time."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

from hil.core import CoreAxis
from hil.core.abi import Event
from hil.core.core_processor import CoreProcessor
from hil.firmware.set_point_paths import rest_of
from hil.sim._each_packet import offered as offered_packets
from hil.sim.debugger import NO_DEBUGGER
from hil.sim.firmware_guard import Guard
from hil.sim.hardware import DeviceSpec, Hardware
from hil.sim.inputs import (
    Bytes,
    CommitDone,
    Do,
    Follow,
    Input,
    LineOpened,
    LoadProgram,
    Pin,
    PulseTrain,
    Reset,
    ScriptEncoder,
    SetField,
    Stopped,
    WriteMemory,
)
from hil.sim.power import Power
from hil.sim.processor_memory import load_program, write_memory
from hil.sim.setpoints import Setpoints
from hil.sim.uart import DeviceUart
from hil.sim.verb_calls import Answer, VerbCalls, axis_arguments
from hil.sketch.chip_program import SECTION, is_program, kept_symbols, unpacked
from hil.sketch.program_notes import program_note
from hil.vocab.address import DeviceParts
from hil.vocab.firmware import Commit, CoreEvent
from hil.vocab.line_format import format_named
from hil.vocab.path import Path
from hil.vocab.time import FOREVER, SimTimeNs
from hil.vocab.verbs import VerbRefused

SENT, DRIVER, WRITTEN = Event.sent.name, Event.line_driver.name, Event.eeprom_written.name
"""Events of a processor: it begins a frame, it switches its line's driver, it has written its EEPROM."""
HALTED, NOTED = Event.halted.name, Event.program_note.name
"""Events of a processor: it stands for a debugger, its program does what its user should know."""


@dataclass(frozen=True)
class Home:
    """Callbacks of a device to its bench."""

    guard: Guard
    """Guard around each turn of its firmware's own code."""
    commit: Callable[["Twin", Mapping[str, bytes]], bool | None]
    """Makes sections its whole memory. Returns whether they are durable; None: a ``CommitDone`` follows."""
    failed: Callable[["Twin"], None]
    """Called when it has stopped, and ``failed`` says why."""
    stopped: Callable[["Twin", SimTimeNs, Stopped], None]
    """Called when it stops for a reason that simulated time does not have; ``failed`` comes next."""
    due_changed: Callable[["Twin", SimTimeNs | None], None]
    """Called when it is due at a time too that was not known, or (None) ``due_ns`` may be earlier."""


class Twin:
    """Board that runs at the times its group gives it; ``due_ns`` is the next one it needs. A firmware that
    raises, loops or takes too long stops this device alone: ``failed`` says why.

    Long because all that reaches a board, bytes, interrupts, inputs and time, comes in here.
    """

    def __init__(self, spec: DeviceSpec, axes: Mapping[str, CoreAxis], home: Home) -> None:
        self.name = spec.name
        self.profile = spec.profile
        self.verbs = spec.verbs
        self.framing = spec.framing
        self.own_map = spec.own_map
        self.resets_when_opened = spec.resets_when_opened
        """True if a client that opens its first port resets its processor."""
        self.is_hung = False
        """True if its main program stands still (a fault), whatever resets it."""
        self.interrupting = False
        """True while an interrupt is sending, at a time before the group's."""
        self.debugger = NO_DEBUGGER
        """Debugger of its processor."""
        self._home = home
        commit, due_changed = partial(home.commit, self), partial(home.due_changed, self)
        self._hardware = Hardware(spec, axes, home.guard, commit, due_changed)
        self.axes: DeviceParts[CoreAxis] = self._hardware.axes
        self._memory, self._interfaces = self._hardware.memory, self._hardware.interfaces
        self.notes: Mapping[str, str] = self._hardware.notes
        """Notes for the operator, keyed by topic."""
        self.told: Mapping[str, float] = self._hardware.told
        """Values of the firmware's own that it tells, by name."""
        self.nvm = self._memory.content
        self.uarts: DeviceParts[DeviceUart] = self._interfaces.by_name
        """UARTs by name; each has a port or a segment of its own."""
        self._lines = self._interfaces.all
        self._rx_lines = self._interfaces.rx_lines
        self.setpoints = Setpoints(spec.time_out, axis_arguments(self.axes))
        self.power = Power(
            spec,
            self._hardware,
            self.setpoints,
            home.guard,
            commit=self._commit,
            on_stopped=partial(home.stopped, self),
            on_failed=partial(home.failed, self),
        )
        self._sketch = self.power.sketch
        self._calls = VerbCalls(spec, self._hardware, self._sketch, self.setpoints)

    @property
    def failed(self) -> str | None:
        """Reason for which it has stopped, or None."""
        return self.power.failed

    @property
    def axis(self) -> CoreAxis:
        """The first axis. Raises KeyError: there is none."""
        return self.axes[""]

    @property
    def due_ns(self) -> SimTimeNs:
        """The earliest time at which ``step`` has to be called."""
        # As ``_stands``: this is asked often, and it is a call less.
        if self.power.failed is not None or self.is_hung or (not self._sketch.is_on and self._stands):
            return FOREVER
        due_ns = self._sketch.runtime.due_ns
        for uart in self._lines:
            if (arrival_ns := uart.incoming.next_ns) < due_ns:
                due_ns = arrival_ns
        return due_ns if due_ns < self.setpoints.due_ns else self.setpoints.due_ns

    def step(self, now_ns: SimTimeNs, *, is_due: bool = True) -> SimTimeNs:
        """Let the firmware run at ``now_ns``, as far as it gets; return ``due_ns``. ``is_due``: False if it
        is to run only where that is no later than now."""
        sketch = self._sketch
        runtime = sketch.runtime
        if self.power.failed is not None or self.is_hung or (not sketch.is_on and self._stands):
            return FOREVER
        # Not once the set-points' time is over: then `_go_on` stops the axis first.
        if (
            runtime.takes is not None
            and runtime.polls_from_ns <= now_ns < self.setpoints.due_ns
            and (offered := offered_packets(self._rx_lines, now_ns, runtime.polls_from_ns)) is not None
        ):
            if sketch.offer(now_ns, offered):
                return self.setpoints.due_ns  # it waits for a byte, and none is on a line
        elif not is_due and (due_ns := self.due_ns) > now_ns:
            return due_ns
        else:
            self._interfaces.begin(now_ns, runtime.polls_from_ns)
            sketch.turn(runtime.resume if now_ns < self.setpoints.due_ns else self._go_on, now_ns)
        self._interfaces.end()
        self._interfaces.note_polling(now_ns, is_polling=runtime.polls_from_ns <= now_ns)
        return self.due_ns

    def _go_on(self, now_ns: SimTimeNs) -> None:
        if now_ns >= self.setpoints.due_ns:
            self.setpoints.starve(now_ns, self._sketch.firmware, self._hardware.note)
        self._sketch.runtime.resume(now_ns)

    def interrupt(self, event: CoreEvent) -> None:
        """Let the firmware handle an interrupt, at the event's own time."""
        if self.failed or not self._sketch.is_on:
            return
        if event.kind == SENT:
            self._send_frame(event)
            return
        if event.kind == DRIVER:
            self._interfaces.switch_driver(event.at_ns, is_on=bool(event.value))
            return
        if event.kind == HALTED:
            self.debugger.halted()
            return
        if event.kind == NOTED:
            counter = self._hardware.processors[event.axis].program_counter
            self._hardware.note(*program_note(event.value, counter, kept_symbols(self.nvm)))
            return
        if event.kind == WRITTEN:
            self._hardware.processors[event.axis].note_written()
        self._interfaces.set_time(event.at_ns)
        self._sketch.turn(lambda: self._sketch.firmware.interrupt(event))
        self._sketch.runtime.interrupted(event.at_ns)
        self._interfaces.note_interrupt()
        self.interrupting = True
        self._interfaces.end()
        self.interrupting = False

    def _send_frame(self, event: CoreEvent) -> None:
        frame = self._hardware.processors[event.axis].frame(event.value)
        self.interrupting = True
        self._interfaces.send_frame(event.at_ns, frame)
        self.interrupting = False

    def apply(self, given: Input, now_ns: SimTimeNs, part: str = "") -> Answer:
        """Let an input take effect at ``now_ns``; ``step`` comes next. Returns a verb's answer. ``part``:
        name of the axis that the input is for, or empty.

        Raises:
            VerbRefused: a verb, or a path, was not carried out.
        """
        self._interfaces.set_time(now_ns)
        if isinstance(given, Bytes):  # the most frequent, without the pattern's cost
            self.uarts[given.port].arrive(given.data, given.client_baud, format_named(given.client_format))
            return {}
        match given:
            case Follow(start_ns, path, is_joined):
                if is_joined and start_ns < now_ns:
                    start_ns, path = now_ns, rest_of(path, now_ns - start_ns)
                self.follow(path, start_ns, now_ns, part)
            case Do(verb, parameters):
                self._check_takes()
                answer = self._calls.carry_out(self.verbs[verb], dict(parameters), now_ns, part)
                self._end_of_verb()
                return answer
            case Pin() | SetField() | ScriptEncoder() | PulseTrain():
                self._hardware.apply(given, self.axes[part])
            case CommitDone(durable):
                self._memory.answered(durable)
            case Reset():
                self.power.reset()
            case LoadProgram(program):
                self._load(bytes.fromhex(program))
            case WriteMemory(memory, at, data):
                write_memory(self.processor, memory, at, bytes.fromhex(data))
            case LineOpened(port):
                if self.uarts[port] is self._lines[0] and self._is_reset_by_line():
                    self.power.reset_processors()
        return {}

    def _is_reset_by_line(self) -> bool:
        """True if the opening of the first port resets it now; its firmware may keep running instead."""
        opened = getattr(self._sketch.firmware, "line_opened", None) if self._sketch.is_on else None
        return self.resets_when_opened and (opened is None or self._sketch.turn(opened) is not False)

    @property
    def processors(self) -> Mapping[str, CoreProcessor]:
        """Processors by the names of the axes whose pins they have."""
        return self._hardware.processors

    @property
    def processor(self) -> CoreProcessor:
        """The first processor. Raises StopIteration: there is none."""
        return next(iter(self.processors.values()))

    @property
    def has_program(self) -> bool:
        """True if its memory keeps a compiled program, which its processor runs."""
        return bool(self.processors) and is_program(self.nvm.get(SECTION))

    def _load(self, program: bytes) -> None:
        """Put a program into the processor and into the memory, and switch the board off and on."""
        load_program(self.processor, unpacked(program))
        self.keep(SECTION, program, lambda durable: None)
        self.power.reset()
        self.debugger.loaded()

    def follow(self, path: Path, start_ns: int, now_ns: SimTimeNs, part: str = "") -> None:
        """Let an axis follow a path from a time on: the input ``Follow``, as drives have it at each SYNC.
        ``part``: as ``apply``.

        Raises:
            VerbRefused: it was not carried out.
        """
        self._interfaces.set_time(now_ns)
        self._check_takes()
        self._calls.follow(path, start_ns, now_ns, part)
        self._end_of_verb()

    def _check_takes(self) -> None:
        """Check that the main program can be told something. Raises VerbRefused."""
        if failed := self.power.failed:
            raise VerbRefused("failed", failed)
        if self.is_hung or not self._sketch.is_on:
            why = "its main program hangs" if self.is_hung else "it has just got its power"
            raise VerbRefused("not_now", why)

    def _end_of_verb(self) -> None:
        """Send what it has said to a verb. Raises VerbRefused: it has stopped."""
        self._interfaces.end()
        if failed := self.power.failed:
            raise VerbRefused("failed", failed)

    @property
    def follows_paths(self) -> bool:
        """True if its set-point goes along paths (``Follow``)."""
        return self._calls.follows_paths

    @property
    def started_ns(self) -> SimTimeNs:
        """Simulated time at which its firmware began, at its latest power-up."""
        return self._hardware.started_ns

    @property
    def is_busy(self) -> bool:
        """True if its main program is in a routine of its own, and takes no commands."""
        return self._sketch.is_busy

    @property
    def is_ready(self) -> bool:
        """True if it would carry out verbs: its main program has started, and is in no routine of its own."""
        return self.power.failed is None and not self.is_hung and self._sketch.is_ready

    @property
    def lacks(self) -> tuple[str, str] | None:
        """Thing that it lacks to hold an angle, as a look-up table, and the verb that makes it."""
        return self._sketch.lacks

    @property
    def is_committing(self) -> bool:
        return self._memory.is_committing

    @property
    def _stands(self) -> bool:
        """True if its firmware is stopped. When a commit from before a reset is under way, the memory's
        content is known only when it has ended, and only then does the firmware start."""
        is_writing_at_start = not self._sketch.is_on and self._memory.is_committing
        return self.failed is not None or self.is_hung or is_writing_at_start

    def _commit(self, request: Commit) -> None:
        with self._home.guard.aside():
            self._memory.commit(request, self._committed)

    def _committed(self, durable: bool) -> None:
        if self._sketch.is_on:
            self._sketch.runtime.commit_done(durable)

    def keep(self, name: str, data: bytes, done: Callable[[bool], None]) -> None:
        """Keep a section of the memory that is not the firmware's. ``done``: as ``Memory.commit``."""
        self._memory.commit(Commit(name, data), done)
