"""One emulated board: its firmware's main program, UART, axis and memory, driven by simulated time."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from hil.core import CoreAxis, CoreMotion
from hil.core.fields import OF_KIND
from hil.sim.inputs import (
    Bytes,
    CommitDone,
    Do,
    Drive,
    Follow,
    Input,
    Pin,
    Reset,
    ScriptEncoder,
    SetField,
    Stopped,
)
from hil.sim.interfaces import Interfaces
from hil.sim.memory import Memory
from hil.sim.setpoints import Setpoints, TimeOut
from hil.sim.sketch import Sketch
from hil.sim.stops import FirmwareHung, Guard, StopLogged
from hil.sim.uart import DeviceUart
from hil.vocab.firmware import MAIN, NETWORK, Board, Commit, CoreEvent, Firmware
from hil.vocab.time import FOREVER, SimTimeNs
from hil.vocab.verbs import Effect, Verb, VerbRefused

Answer = Mapping[str, float | str | int]
"""What a verb answers, by names."""


@dataclass(frozen=True, kw_only=True)
class DeviceSpec:
    """What a device is, beside its axis.

    ``bauds``: of its UARTs, by their names; None where bytes take no time. All but the main one are made in
    software. ``power_up``: the axis's fields that the power sets beside the core's own, the encoder's
    registers. ``nvm``: named contents of its memory at the start.
    """

    name: str
    profile: str
    firmware: Callable[[Board], Firmware]
    bauds: Mapping[str, int | None]
    nvm: Mapping[str, bytes]
    power_up: Mapping[str, int]
    facts: Mapping[str, int]
    verbs: Mapping[str, Verb] = field(default_factory=dict)
    time_out: TimeOut | None = None
    follow: Callable[..., None] | None = None


class Device:
    """Runs at the times its group gives it; ``due_ns`` is the next one it needs.

    A firmware that raises, loops or takes too long stops this device alone: ``failed`` says why, and
    ``on_failed`` is called once. ``on_stopped`` is called before, if it was for a reason that simulated time
    does not have. ``commit`` makes sections its whole non-volatile memory, and answers whether they are
    durable, or None: then comes a ``CommitDone``. ``due_changed``: ``due_ns`` may be earlier than it was.
    """

    def __init__(
        self,
        spec: DeviceSpec,
        axis: CoreAxis,
        *,
        guard: Guard,
        commit: Callable[["Device", Mapping[str, bytes]], bool | None],
        on_failed: Callable[["Device"], None],
        on_stopped: Callable[["Device", SimTimeNs, Stopped], None],
        due_changed: Callable[["Device"], None],
    ) -> None:
        self.name = spec.name
        self.profile = spec.profile
        self.axis = axis
        self.verbs = spec.verbs
        self.failed: str | None = None
        self.power_ups = 1
        """How often its power came, at the start or later."""
        self.is_hung = False
        """Its main program stands still (a fault), whatever resets it."""
        self._no_power: str | None = None
        self.notes: dict[str, str] = {}
        """Notes for the operator, keyed by topic."""
        self.interrupting = False
        """What is sent now was sent by an interrupt, at a time before the group's."""
        self.setpoints = Setpoints(spec.time_out)
        self._power_up = {name: value for name, value in spec.power_up.items() if name in OF_KIND[axis.kind]}
        self._follow = Verb("follow", "", run=spec.follow, effect=Effect.ENDS) if spec.follow else None
        self._guard = guard
        self._on_failed = on_failed
        self._on_stopped = on_stopped
        self._memory = Memory(spec.nvm, lambda sections: commit(self, sections))
        self.nvm = self._memory.content
        self._interfaces = Interfaces(spec.bauds, guard, lambda: due_changed(self))
        self.uarts: Mapping[str, DeviceUart] = self._interfaces.by_name
        """By their names; each has a port or a segment of its own."""
        motion = axis if isinstance(axis, CoreMotion) else None
        main, network = self.uarts[MAIN], self.uarts.get(NETWORK)
        board = Board(main, axis, self.nvm, network, motion, spec.facts, self._note)
        self._power_up_axis()
        self._sketch = Sketch(
            spec.name, spec.firmware, board, self._interfaces, guard, self._commit, self._raised
        )

    @property
    def due_ns(self) -> SimTimeNs:
        """The earliest time at which ``step`` has to be called."""
        if self.failed or self.is_hung or self._is_writing_at_start:
            return FOREVER
        due_ns = self._sketch.runtime.due_ns
        for uart in self._interfaces.all:
            if (arrival_ns := uart.next_arrival_ns) < due_ns:
                due_ns = arrival_ns
        return due_ns if due_ns < self.setpoints.due_ns else self.setpoints.due_ns

    def step(self, now_ns: SimTimeNs) -> None:
        """Let the firmware run at ``now_ns``, as far as it gets."""
        if self.failed or self.is_hung or self._is_writing_at_start:
            return
        runtime, interfaces = self._sketch.runtime, self._interfaces
        interfaces.begin(now_ns, runtime.polls_from_ns)
        self._sketch.turn(self._go_on, now_ns)
        interfaces.end()
        interfaces.note_polling(now_ns, is_polling=runtime.polls_from_ns <= now_ns)

    def _go_on(self, now_ns: SimTimeNs) -> None:
        if now_ns >= self.setpoints.due_ns:
            self.setpoints.starve(self._sketch.firmware, self._note)
        self._sketch.runtime.resume(now_ns)

    def interrupt(self, event: CoreEvent) -> None:
        """Let the firmware handle an interrupt, at the event's own time."""
        if self.failed or not self._sketch.is_on:
            return
        self._interfaces.set_time(event.at_ns)
        self._sketch.turn(lambda: self._sketch.firmware.interrupt(event))
        self._interfaces.note_interrupt()
        self.interrupting = True
        self._interfaces.end()
        self.interrupting = False

    def apply(self, given: Input, now_ns: SimTimeNs) -> Answer:
        """An input takes effect at ``now_ns``; ``step`` comes next. Returns what a verb answers.

        Raises:
            VerbRefused: a verb, or a path, was not carried out.
        """
        self._interfaces.set_time(now_ns)
        match given:
            case Bytes(data, client_baud, port):
                self.uarts[port].arrive(data, client_baud)
            case Pin(pin, level):
                self.axis.pin(pin, level)
            case SetField(name, value):
                self.axis.set(name, value)
            case ScriptEncoder(points, linear):
                self.axis.script_encoder(points, linear)
            case Drive(train):
                self.axis.drive([(e.at_ns, e.pin, e.level, e.steps, e.duration_ns) for e in train])
            case CommitDone(durable):
                self._commit_done(durable)
            case Do(verb, parameters):
                return self._do(self.verbs[verb], dict(parameters), now_ns)
            case Follow(start_ns, path):
                if not self._follow:
                    raise VerbRefused("cannot", f"a {self.profile} follows no paths")
                return self._do(self._follow, {"path": path, "start_ns": start_ns}, now_ns)
            case Reset():
                if not self._no_power:
                    self._restart()
        return {}

    def _do(self, verb: Verb, parameters: Mapping[str, Any], now_ns: SimTimeNs) -> Answer:
        if self.failed:
            raise VerbRefused("failed", self.failed)
        if self.is_hung or not self._sketch.is_on:
            why = "its main program hangs" if self.is_hung else "it has just got its power"
            raise VerbRefused("not_now", why)
        answer = self._sketch.turn(self._carry_out, verb, parameters, passes=(VerbRefused,))
        if verb.types:
            self.uarts[MAIN].arrive(verb.types, None)
        self.setpoints.note(verb.effect, now_ns, self._note)
        self._interfaces.end()
        if self.failed:
            raise VerbRefused("failed", self.failed)
        return answer or {}

    def _carry_out(self, verb: Verb, parameters: Mapping[str, Any]) -> Answer | None:
        if verb.name == "pin":
            self.axis.pin(str(parameters["pin"]), int(parameters["level"]))
        elif verb.run:
            return verb.run(self._sketch.firmware, **parameters)
        return None

    @property
    def is_busy(self) -> bool:
        """Its main program is in a routine of its own, and takes no commands."""
        return self._sketch.is_busy

    @property
    def has_power(self) -> bool:
        """Not under a fault; without it no reset starts it."""
        return self._no_power is None

    @property
    def is_committing(self) -> bool:
        """The store has not answered yet."""
        return self._memory.is_committing

    @property
    def _is_writing_at_start(self) -> bool:
        """A commit from before the reset is under way: what the memory holds is known when it has ended, and
        only then does the firmware start."""
        return self._memory.is_committing and not self._sketch.is_on

    def _commit(self, request: Commit) -> None:
        with self._guard.aside():
            durable = self._memory.commit(request)
            if durable is not None:
                self._commit_done(durable)

    def _commit_done(self, durable: bool) -> None:
        if self._memory.answered(durable) and self._sketch.is_on:
            self._sketch.runtime.commit_done(durable)

    def _note(self, about: str, text: str | None) -> None:
        if text is None:
            self.notes.pop(about, None)
        else:
            self.notes[about] = text

    # ---- power, and what takes it ----

    def power(self, why_not: str | None, now_ns: SimTimeNs) -> None:
        """Take its power away, with the reason, or give it back (None). Without power it does nothing,
        nothing is heard of it, and no reset starts it; ``step`` comes next."""
        was_off, self._no_power = self._no_power, why_not
        if why_not:
            self.failed = why_not
            if not was_off:
                self._sketch.runtime.close()
                self.axis.power_up()
        elif was_off:
            self._interfaces.set_time(now_ns)
            self._restart()

    def _restart(self) -> None:
        self._sketch.runtime.close()
        self.failed = None
        self.power_ups += 1
        self.setpoints.end()
        self.notes.clear()
        self._power_up_axis()
        self._interfaces.clear()
        self._sketch.power_up()

    def _power_up_axis(self) -> None:
        self.axis.power_up()
        for name, value in self._power_up.items():
            self.axis.set(name, value)

    def close(self) -> None:
        """Its firmware runs no more, whatever comes; the axis goes with its group."""
        self.failed = "it was taken out"
        self._sketch.close()

    def _raised(self, error: BaseException) -> None:
        """The firmware did not come through its turn."""
        reason = f"{type(error).__name__}: {error}"
        if isinstance(error, StopLogged):
            self._stop(error.stopped)
        elif isinstance(error, FirmwareHung | MemoryError | RecursionError):
            self._stop(Stopped(self._sketch.turns, reason, self._interfaces.cut()))
        else:
            self.fail(reason)

    def fail(self, reason: str) -> None:
        """Stop the device for good; only a reset brings it back."""
        self._interfaces.cut()
        self._interfaces.end()
        self.failed = reason
        self._sketch.runtime.close()
        self.axis.loop(False)
        self._on_failed(self)

    def _stop(self, stopped: Stopped) -> None:
        """As ``fail``, where nobody can tell how far the firmware had come: nothing is left of its turn but
        what it has sent, and board and axis stand as after power-up."""
        self._on_stopped(self, self._interfaces.now_ns, stopped)
        self._sketch.runtime.close()
        self.setpoints.end()
        self._power_up_axis()
        self._interfaces.halt(stopped.words)
        self._interfaces.end()
        self.failed = stopped.reason
        self._on_failed(self)
