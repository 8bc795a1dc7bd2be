"""One emulated board: its firmware's main program, UART, axis and memory, driven by simulated time."""

from collections import deque
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from itertools import groupby
from operator import itemgetter
from typing import Any, Protocol

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
from hil.sim.setpoints import Setpoints, TimeOut
from hil.sim.stops import FirmwareHung, Guard, StopLogged, Unguarded
from hil.sim.uart import DeviceUart
from hil.vocab.firmware import MAIN, NETWORK, Board, Commit, CoreEvent, Firmware, Main
from hil.vocab.motion import Motion
from hil.vocab.time import FOREVER, SimTimeNs
from hil.vocab.verbs import Effect, Verb, VerbRefused

LAST_WORDS_BYTES = 128 * 1024
"""More than the longest answer, a look-up table."""
NO_VERBS: Mapping[str, Verb] = {}


class Store(Protocol):
    """Where a device's memory is kept. It answers each commit once, by an input ``CommitDone``, or by
    calling ``device.commit_done`` before ``commit`` returns."""

    def commit(self, device: "Device", sections: Mapping[str, bytes]) -> None:
        """Make ``sections`` the device's whole non-volatile memory."""


class Device:
    """Runs at the times its group gives it; ``due_ns`` is the next one it needs.

    ``power_up`` has the axis's fields that the power sets beside the core's own: the encoder's registers.
    A firmware that raises, loops or takes too long stops this device alone: ``failed`` says why, and
    ``on_failed`` is called once.
    """

    def __init__(
        self,
        name: str,
        profile: str,
        axis: CoreAxis,
        firmware: Callable[[Board], Firmware],
        *,
        baud: int | None,
        network_baud: int | None,
        nvm: Mapping[str, bytes],
        power_up: Mapping[str, int],
        facts: Mapping[str, int],
        store: Store,
        sent: Callable[["Device", str, SimTimeNs, bytes], None],
        verbs: Mapping[str, Verb] = NO_VERBS,
        time_out: TimeOut | None = None,
        follow: Callable[..., None] | None = None,
    ) -> None:
        self.name = name
        self.profile = profile
        self.axis = axis
        self.nvm = dict(nvm)
        self.failed: str | None = None
        self.power_ups = 0
        """How often its power came, at the start or later."""
        self.is_hung = False
        """Its main program stands still (a fault), whatever resets it."""
        self._no_power: str | None = None
        self.notes: dict[str, str] = {}
        """What the firmware wants an operator to know, by what it is about."""
        self.on_failed: Callable[[Device], None] | None = None
        self.interrupting = False
        """What is sent now was sent by an interrupt, at a time before the group's."""
        self.guard: Guard = Unguarded()
        self.turns = 0
        """How often its firmware had its turn: all that it does by itself."""
        self.on_stopped: Callable[[Device, SimTimeNs, Stopped], None] = lambda device, at_ns, stopped: None
        """Called when it was stopped for a reason that simulated time does not have."""
        self.uart = DeviceUart(baud, lambda at_ns, data: self._outbox.append((MAIN, at_ns, data)))
        self.network = None
        if network_baud is not None:
            self.network = DeviceUart(
                network_baud, lambda at_ns, data: self._outbox.append((NETWORK, at_ns, data)), 0
            )
        self.uarts = {MAIN: self.uart} | ({NETWORK: self.network} if self.network else {})
        """By their names; each has a port or a segment of its own."""
        self._written: list[tuple[DeviceUart, int | None, bytes]] = []
        """What the firmware has written in this turn."""
        self._put = 0
        """How many of these are on their way."""
        for uart in self.uarts.values():
            uart.later = self._written
        self._outbox: list[tuple[str, SimTimeNs, bytes]] = []
        self._sent = sent
        self.verbs = verbs
        self._follow = Verb("follow", "", run=follow, effect=Effect.ENDS) if follow else None
        self.setpoints = Setpoints(time_out)
        self.answer: Mapping[str, float | str | int] | VerbRefused = {}
        """To the last ``Do``."""
        self._power_up = dict(power_up)
        self._facts = dict(facts)
        self._make_firmware = firmware
        self._store = store
        self._pending: deque[dict[str, bytes]] = deque()
        """The whole memory of each commit that the store has not answered, in their order."""
        self._start()

    @property
    def due_ns(self) -> SimTimeNs:
        """The earliest time at which ``step`` has to be called."""
        if self.failed or self.is_hung or self._is_writing_at_start:
            return FOREVER
        due_ns = self._runtime.due_ns
        if (arrival_ns := self.uart.next_arrival_ns) < due_ns:
            due_ns = arrival_ns
        if self.network and (arrival_ns := self.network.next_arrival_ns) < due_ns:
            due_ns = arrival_ns
        return due_ns if due_ns < self.setpoints.due_ns else self.setpoints.due_ns

    def step(self, now_ns: SimTimeNs) -> None:
        """Let the firmware run at ``now_ns``, as far as it gets."""
        if self.failed or self.is_hung or self._is_writing_at_start:
            return
        runtime = self._runtime
        polls_from_ns = runtime.polls_from_ns
        for uart in self.uarts.values():
            uart.now_ns = now_ns
            uart.polls_from_ns = polls_from_ns
            uart.take_arrivals()
        try:
            with self._turn():
                if now_ns >= self.setpoints.due_ns:
                    self.setpoints.starve(self._firmware, self._note)
                runtime.resume(now_ns)
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # the firmware is a plug-in: whatever it raises stops its device only
            self._raised(error)
        self._after_turn()
        is_polling = runtime.polls_from_ns <= now_ns
        for uart in self.uarts.values():
            if not is_polling:
                if not uart.ignores_mark:
                    uart.ignore_mark()
            elif uart.ignores_mark and self._print_returns(now_ns) <= now_ns:
                uart.ignores_mark = False
            if uart.busy_flag:
                flags, name = uart.busy_flag
                (flags.discard if is_polling else flags.add)(name)

    def interrupt(self, event: CoreEvent) -> None:
        """Let the firmware handle an interrupt, at the event's own time."""
        if self.failed or not self._is_on:
            return
        self._at(event.at_ns)
        try:
            with self._turn():
                self._firmware.interrupt(event)
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # as in step
            self._raised(error)
        if self._written:  # the next thing that wakes the main program lets it wait until this is out
            for uart in self.uarts.values():
                uart.ignore_mark()
        self.interrupting = True
        self._after_turn()
        self.interrupting = False

    def apply(self, given: Input, now_ns: SimTimeNs) -> None:
        """An input takes effect at ``now_ns``; ``step`` comes next."""
        self._at(now_ns)
        match given:
            case Bytes(data, client_baud, port):
                self.uarts[port].arrive(data, client_baud)
            case Pin(pin, level):
                self.axis.pin(pin, level)
            case SetField(field, value):
                self.axis.set(field, value)
            case ScriptEncoder(points, linear):
                self.axis.script_encoder(points, linear)
            case Drive(train):
                self.axis.drive([(e.at_ns, e.pin, e.level, e.steps, e.duration_ns) for e in train])
            case CommitDone(durable):
                self.commit_done(durable)
            case Do(verb, parameters):
                self._do(self.verbs[verb], dict(parameters), now_ns)
            case Follow(start_ns, path):
                if self._follow:
                    self._do(self._follow, {"path": path, "start_ns": start_ns}, now_ns)
                else:
                    self.answer = VerbRefused("cannot", f"a {self.profile} follows no paths")
            case Reset():
                if not self._no_power:
                    self._restart()

    def _do(self, verb: Verb, parameters: Mapping[str, Any], now_ns: SimTimeNs) -> None:
        """At ``now_ns``; ``answer`` says what came of it."""
        self.answer = {}
        if self.failed or self.is_hung or not self._is_on:
            why = self.failed or ("its main program hangs" if self.is_hung else "it has just got its power")
            self.answer = VerbRefused("failed" if self.failed else "not_now", why)
            return
        try:
            with self._turn():
                if verb.name == "pin":
                    self.axis.pin(str(parameters["pin"]), int(parameters["level"]))
                elif verb.run:
                    self.answer = verb.run(self._firmware, **parameters) or {}
        except KeyboardInterrupt:
            raise
        except VerbRefused as refusal:
            self.answer = refusal
            return
        except BaseException as error:  # as in step
            self._raised(error)
            self.answer = VerbRefused("failed", self.failed or "")
        if verb.types:
            self.uart.arrive(verb.types, None)
        self.setpoints.note(verb.effect, now_ns, self._note)
        self._after_turn()

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
            with self.guard(self):
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

    def _turn(self) -> AbstractContextManager[object]:
        """Around all that runs the firmware's own code."""
        self.turns += 1
        return self.guard(self)

    def _raised(self, error: BaseException) -> None:
        """The firmware did not come through its turn."""
        reason = f"{type(error).__name__}: {error}"
        if isinstance(error, StopLogged):
            self._stop(error.stopped)
        elif isinstance(error, FirmwareHung | MemoryError | RecursionError):
            words = [(self._name_of(uart), baud, data.hex()) for uart, baud, data in self._last_words()]
            self._stop(Stopped(self.turns, reason, tuple(words)))
        else:
            self.fail(reason)

    def fail(self, reason: str) -> None:
        """Stop the device for good; only a reset brings it back."""
        self._written[:] = self._last_words()
        self._after_turn()
        self.failed = reason
        self._runtime.close()
        self.axis.loop(False)
        if self.on_failed:
            self.on_failed(self)

    def _stop(self, stopped: Stopped) -> None:
        """As ``fail``, where nobody can tell how far the firmware had come: nothing is left of its turn but
        what it has sent, and board and axis stand as after power-up."""
        self.on_stopped(self, self.uart.now_ns, stopped)
        self._runtime.close()
        for uart in self.uarts.values():
            uart.halt()
        self.setpoints.end()
        self._power_up_axis()
        self._written[:] = [
            (self.uarts[port], baud, bytes.fromhex(data)) for port, baud, data in stopped.words
        ]
        self._after_turn()
        self.failed = stopped.reason
        if self.on_failed:
            self.on_failed(self)

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
        for uart in self.uarts.values():
            uart.clear()
        self._runtime = Runtime(self._program(), self._has_input, self._commit, self._print_returns)
        self._runtime.due_ns = self.uart.now_ns

    def _power_up_axis(self) -> None:
        self.axis.power_up()
        for field, value in self._power_up.items():
            if field in OF_KIND[self.axis.kind]:  # a stepper has no encoder
                self.axis.set(field, value)

    def _name_of(self, uart: DeviceUart) -> str:
        return next(name for name, each in self.uarts.items() if each is uart)

    def _at(self, now_ns: SimTimeNs) -> None:
        for uart in self.uarts.values():
            uart.now_ns = now_ns

    def _has_input(self) -> bool:
        return self.uart.has_input or (self.network is not None and self.network.has_input)

    def _print_returns(self, now_ns: SimTimeNs) -> SimTimeNs:
        if self._put < len(self._written) and (self.network or self.uart.baud):
            with self.guard.aside():
                self._put_written()
        returns_ns = self.uart.print_returns(now_ns)
        return self.network.print_returns(returns_ns) if self.network else returns_ns

    def _program(self) -> Main:
        """Made by the first step, so that a firmware that cannot be made fails as one that runs does."""
        board = Board(self.uart, self.axis, self.nvm, self.network, self._motion(), self._facts, self._note)
        self._firmware = self._make_firmware(board)
        self._is_on = True
        yield from self._firmware.main()

    def _note(self, about: str, text: str | None) -> None:
        if text is None:
            self.notes.pop(about, None)
        else:
            self.notes[about] = text

    def _motion(self) -> Motion | None:
        return self.axis if isinstance(self.axis, CoreMotion) else None

    def _put_written(self) -> None:
        for uart, baud, data in self._written[self._put :]:
            uart.put(data, baud)
        self._put = len(self._written)

    def _after_turn(self) -> None:
        """What is not the firmware's own: pass on what it has done, now that the guard cannot strike in the
        middle of it."""
        for uart in self.uarts.values():
            uart.tell_address()
        if self._written or self._outbox:
            with self.guard.aside():
                self._put_written()
                self._written.clear()
                self._put = 0
                self._empty_outbox()

    def _empty_outbox(self) -> None:
        """What went on the line at one time is one piece."""
        if not self._outbox:
            return
        outbox, self._outbox = self._outbox, []
        if len(outbox) == 1:
            self._sent(self, *outbox[0])
            return
        for (port, at_ns), pieces in groupby(outbox, key=itemgetter(0, 1)):
            self._sent(self, port, at_ns, b"".join(data for _, _, data in pieces))

    def _last_words(self) -> list[tuple[DeviceUart, int | None, bytes]]:
        """Of a firmware that printed for ever in one turn, what a client may still want to see."""
        left, words = LAST_WORDS_BYTES, self._written[: self._put]
        for uart, baud, data in self._written[self._put :]:
            words.append((uart, baud, data[:left]))
            left -= len(data)
            if left <= 0:
                break
        return words

    def _commit(self, request: Commit) -> None:
        content = self.nvm | {request.name: request.data}
        with self.guard.aside():
            self._pending.append(content)
            self._store.commit(self, content)
