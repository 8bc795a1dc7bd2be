"""One emulated board: its firmware's main program, UART, axis and memory, driven by simulated time."""

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any, TypeVar

from hil.core import CoreAxis, CoreMotion
from hil.core.fields import OF_KIND
from hil.firmware.runtime import Runtime
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
from hil.sim.outbox import Outbox
from hil.sim.setpoints import Setpoints, TimeOut
from hil.sim.stops import FirmwareHung, Guard, StopLogged
from hil.sim.uart import UART_BUFFER_BYTES, DeviceUart
from hil.vocab.firmware import MAIN, NETWORK, Board, Commit, CoreEvent, Firmware, Main
from hil.vocab.time import FOREVER, SimTimeNs
from hil.vocab.verbs import Effect, Verb, VerbRefused

Answer = Mapping[str, float | str | int]
"""What a verb answers, by names."""
Result = TypeVar("Result")
_HAS_INPUT = attrgetter("has_input")


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
    durable, or None: ``commit_done`` will be called. ``due_changed``: ``due_ns`` may be earlier than it was.
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
        self.nvm = dict(spec.nvm)
        self.failed: str | None = None
        self.power_ups = 0
        """How often its power came, at the start or later."""
        self.is_hung = False
        """Its main program stands still (a fault), whatever resets it."""
        self._no_power: str | None = None
        self.notes: dict[str, str] = {}
        """Notes for the operator, keyed by topic."""
        self.interrupting = False
        """What is sent now was sent by an interrupt, at a time before the group's."""
        self.turns = 0
        """How often its firmware had its turn: all that it does by itself."""
        self.setpoints = Setpoints(spec.time_out)
        self._follow = Verb("follow", "", run=spec.follow, effect=Effect.ENDS) if spec.follow else None
        self._make_firmware = spec.firmware
        self._spec = spec
        self._guard = guard
        self._store = commit
        self._on_failed = on_failed
        self._on_stopped = on_stopped
        self._outbox = Outbox(guard)
        self.uarts = {name: self._make_uart(name, lambda: due_changed(self)) for name in spec.bauds}
        """By their names; each has a port or a segment of its own."""
        self._lines = tuple(self.uarts.values())
        self._is_paced = any(spec.bauds.values())
        self._pending: deque[dict[str, bytes]] = deque()
        """The whole memory of each commit that the store has not answered, in their order."""
        self._start()

    def _make_uart(self, name: str, due_changed: Callable[[], None]) -> DeviceUart:
        def sent(at_ns: SimTimeNs, data: bytes) -> None:
            self._outbox.sent(uart, at_ns, data)

        room, later = UART_BUFFER_BYTES if name == MAIN else 0, self._outbox.written
        uart = DeviceUart(self._spec.bauds[name], sent, room, later=later, due_changed=due_changed)
        return uart

    @property
    def now_ns(self) -> SimTimeNs:
        """The time that it has reached."""
        return self._lines[0].now_ns

    @property
    def due_ns(self) -> SimTimeNs:
        """The earliest time at which ``step`` has to be called."""
        if self.failed or self.is_hung or self._is_writing_at_start:
            return FOREVER
        due_ns = self._runtime.due_ns
        for uart in self._lines:
            if (arrival_ns := uart.next_arrival_ns) < due_ns:
                due_ns = arrival_ns
        return due_ns if due_ns < self.setpoints.due_ns else self.setpoints.due_ns

    def step(self, now_ns: SimTimeNs) -> None:
        """Let the firmware run at ``now_ns``, as far as it gets."""
        if self.failed or self.is_hung or self._is_writing_at_start:
            return
        runtime = self._runtime
        polls_from_ns = runtime.polls_from_ns
        for uart in self._lines:
            uart.now_ns = now_ns
            uart.polls_from_ns = polls_from_ns
            uart.take_arrivals()
        self._turn(self._go_on, now_ns)
        self._after_turn()
        is_polling = runtime.polls_from_ns <= now_ns
        for uart in self._lines:
            if not is_polling:
                if not uart.ignores_mark:
                    uart.ignore_mark()
            elif uart.ignores_mark and self._print_returns(now_ns) <= now_ns:
                uart.ignores_mark = False
            uart.tell_polling(is_polling)

    def _go_on(self, now_ns: SimTimeNs) -> None:
        if now_ns >= self.setpoints.due_ns:
            self.setpoints.starve(self._firmware, self._note)
        self._runtime.resume(now_ns)

    def interrupt(self, event: CoreEvent) -> None:
        """Let the firmware handle an interrupt, at the event's own time."""
        if self.failed or not self._is_on:
            return
        self._at(event.at_ns)
        self._turn(lambda: self._firmware.interrupt(event))
        if self._outbox.written:  # the next thing that wakes the main program lets it wait until this is out
            for uart in self._lines:
                uart.ignore_mark()
        self.interrupting = True
        self._after_turn()
        self.interrupting = False

    def apply(self, given: Input, now_ns: SimTimeNs) -> Answer:
        """An input takes effect at ``now_ns``; ``step`` comes next. Returns what a verb answers.

        Raises:
            VerbRefused: a verb, or a path, was not carried out.
        """
        self._at(now_ns)
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
                self.commit_done(durable)
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
        if self.is_hung or not self._is_on:
            why = "its main program hangs" if self.is_hung else "it has just got its power"
            raise VerbRefused("not_now", why)
        answer = self._turn(self._carry_out, verb, parameters, passes=(VerbRefused,))
        if verb.types:
            self.uarts[MAIN].arrive(verb.types, None)
        self.setpoints.note(verb.effect, now_ns, self._note)
        self._after_turn()
        if self.failed:
            raise VerbRefused("failed", self.failed)
        return answer or {}

    def _carry_out(self, verb: Verb, parameters: Mapping[str, Any]) -> Answer | None:
        if verb.name == "pin":
            self.axis.pin(str(parameters["pin"]), int(parameters["level"]))
        elif verb.run:
            return verb.run(self._firmware, **parameters)
        return None

    @property
    def is_busy(self) -> bool:
        """Its main program is in a routine of its own, and takes no commands."""
        return self._is_on and bool(getattr(self._firmware, "is_busy", False))

    @property
    def has_power(self) -> bool:
        """Not under a fault; without it no reset starts it."""
        return self._no_power is None

    @property
    def is_committing(self) -> bool:
        """The store has not answered yet."""
        return bool(self._pending)

    def close(self) -> None:
        """Its firmware runs no more, whatever comes; the axis goes with its group."""
        self.failed = "it was taken out"
        try:
            with self._guard(self):
                self._runtime.close()
        except KeyboardInterrupt:
            raise
        except BaseException:  # as in step; it goes anyway
            return

    def power(self, why_not: str | None, now_ns: SimTimeNs) -> None:
        """Take its power away, with the reason, or give it back (None). Without power it does nothing,
        nothing is heard of it, and no reset starts it; ``step`` comes next."""
        was_off, self._no_power = self._no_power, why_not
        if why_not:
            self.failed = why_not
            if not was_off:
                self._runtime.close()
                self.axis.power_up()
        elif was_off:
            self._at(now_ns)
            self._restart()

    def commit_done(self, durable: bool) -> None:
        """The store has answered the oldest commit; one that failed leaves the old content."""
        if not self._pending:
            return
        content = self._pending.popleft()
        if durable:
            self.nvm.update(content)
        if self._is_on:
            self._runtime.commit_done(durable)

    @property
    def _is_writing_at_start(self) -> bool:
        """A commit from before the reset is under way: what the memory holds is known when it has ended, and
        only then does the firmware start."""
        return bool(self._pending) and not self._is_on

    def _turn(
        self, work: Callable[..., Result], *given: object, passes: tuple[type[Exception], ...] = ()
    ) -> Result | None:
        """Run the firmware's own code, under guard. The firmware is a plug-in: whatever it raises, but for
        ``passes``, stops its device only."""
        self.turns += 1
        try:
            with self._guard(self):
                return work(*given)
        except BaseException as error:
            if isinstance(error, (KeyboardInterrupt, *passes)):
                raise
            self._raised(error)
            return None

    def _raised(self, error: BaseException) -> None:
        """The firmware did not come through its turn."""
        reason = f"{type(error).__name__}: {error}"
        if isinstance(error, StopLogged):
            self._stop(error.stopped)
        elif isinstance(error, FirmwareHung | MemoryError | RecursionError):
            names = {uart: name for name, uart in self.uarts.items()}
            words = [(names[uart], baud, data.hex()) for uart, baud, data in self._outbox.last_words()]
            self._stop(Stopped(self.turns, reason, tuple(words)))
        else:
            self.fail(reason)

    def fail(self, reason: str) -> None:
        """Stop the device for good; only a reset brings it back."""
        self._outbox.written[:] = self._outbox.last_words()
        self._after_turn()
        self.failed = reason
        self._runtime.close()
        self.axis.loop(False)
        self._on_failed(self)

    def _stop(self, stopped: Stopped) -> None:
        """As ``fail``, where nobody can tell how far the firmware had come: nothing is left of its turn but
        what it has sent, and board and axis stand as after power-up."""
        self._on_stopped(self, self.now_ns, stopped)
        self._runtime.close()
        for uart in self._lines:
            uart.halt()
        self.setpoints.end()
        self._power_up_axis()
        self._outbox.written[:] = [
            (self.uarts[port], baud, bytes.fromhex(data)) for port, baud, data in stopped.words
        ]
        self._after_turn()
        self.failed = stopped.reason
        self._on_failed(self)

    def _restart(self) -> None:
        self._runtime.close()
        self.failed = None
        self._start()

    def _start(self) -> None:
        self.power_ups += 1
        self._is_on = False
        self.setpoints.end()
        self.notes.clear()
        self._power_up_axis()
        for uart in self._lines:
            uart.clear()
        self._runtime = Runtime(self._program(), self._has_input, self._commit, self._print_returns)
        self._runtime.due_ns = self.now_ns

    def _power_up_axis(self) -> None:
        self.axis.power_up()
        for name, value in self._spec.power_up.items():
            if name in OF_KIND[self.axis.kind]:  # a stepper has no encoder
                self.axis.set(name, value)

    def _at(self, now_ns: SimTimeNs) -> None:
        for uart in self._lines:
            uart.now_ns = now_ns

    def _has_input(self) -> bool:
        return any(map(_HAS_INPUT, self._lines))

    def _print_returns(self, now_ns: SimTimeNs) -> SimTimeNs:
        if self._is_paced:
            self._outbox.put()
            for uart in self._lines:
                now_ns = uart.print_returns(now_ns)
        return now_ns

    def _program(self) -> Main:
        """Made by the first step, so that a firmware that cannot be made fails as one that runs does."""
        motion = self.axis if isinstance(self.axis, CoreMotion) else None
        main, network = self.uarts[MAIN], self.uarts.get(NETWORK)
        board = Board(main, self.axis, self.nvm, network, motion, self._spec.facts, self._note)
        self._firmware = self._make_firmware(board)
        self._is_on = True
        yield from self._firmware.main()

    def _note(self, about: str, text: str | None) -> None:
        if text is None:
            self.notes.pop(about, None)
        else:
            self.notes[about] = text

    def _after_turn(self) -> None:
        """What is not the firmware's own: pass on what it has done, now that the guard cannot strike in the
        middle of it."""
        for uart in self._lines:
            uart.tell_address()
        self._outbox.hand_on()

    def _commit(self, request: Commit) -> None:
        content = self.nvm | {request.name: request.data}
        with self._guard.aside():
            self._pending.append(content)
            durable = self._store(self, content)
            if durable is not None:
                self.commit_done(durable)
