"""Turns of a program's threads: one runs, the others wait, and simulated time passes when all wait.

So a program does the same in each run. Two things withdraw that promise, and are told once: a thread that
does not wait for half a second of the wall's time, beside which the others go on then; and what is outside,
such as child processes, for which time passes at the wall's pace.
"""

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress

from hil.sim.bench import BenchRuntime
from hil.testing.owned_time.thread_turn import Interrupts, Outside, Turn, Wait
from hil.testing.seeds.late_arrivals import LateArrivals
from hil.testing.serial_ports.line_ends import LineEnd
from hil.testing.serial_ports.passing import SILENCE_NS, EndlessWait, Looks
from hil.testing.serial_ports.port_terminal import PortTerminal
from hil.vocab.time import FOREVER, NS_PER_S, SimTimeNs

PATIENCE_S = 0.5
"""Wall time after which a thread that does not wait is left beside."""
_PIECE_S = 0.001
"""Wall time between two looks at what is outside."""
_FREE_LOCKS_ARE_A_LOOK = 100

_allocate_lock = threading.Lock  # the real one: this module is imported before it is replaced
_sleep, _clock = time.sleep, time.monotonic


class Turns:
    """Turns of one program on one bench. ``terminals``: its ports; ``say``: told to the user, once each.

    Long because the rules of who runs, and when time passes, stand here together.
    """

    def __init__(
        self,
        runtime: BenchRuntime,
        terminals: Sequence[PortTerminal],
        arrivals: LateArrivals,
        say: Callable[[str], None],
    ) -> None:
        self._runtime, self._terminals, self._arrivals, self._say = runtime, terminals, arrivals, say
        self._looks = Looks()
        self.acted = self._looks.acted
        self.timers, self.outside = Interrupts(), Outside()
        self.main = Turn("MainThread", 0)
        self.stop_ns = FOREVER
        """Time at which ``synchronize`` is called, which answers the next."""
        self.synchronize: Callable[[], SimTimeNs] = lambda: FOREVER
        self.is_given_up = False
        """True once all have waited without end: nobody is waited for any more."""
        self._turns = [self.main]
        self._running: Turn | None = self.main
        self._number = 0
        self._free_locks = 0
        self._heard_ns = 0
        self._mutex = _allocate_lock()
        self._mine = threading.local()
        self._mine.turn = self.main
        self.main.identity = threading.get_ident()
        self._inside = 0
        """Thread on which the bench works now."""
        self._passes_wall = False
        self._wall_s = 0.0
        self._told = set[str]()

    # ---- who is here ----

    @property
    def mine(self) -> Turn:
        """Turn of the thread that calls. Raises RuntimeError: Python did not start it."""
        turn: Turn | None = getattr(self._mine, "turn", None)
        if turn is None:
            raise RuntimeError("a thread that Python has not started has no part in simulated time")
        return turn

    @property
    def works_here(self) -> bool:
        """True while the bench works on the thread that calls."""
        return self._inside == threading.get_ident()

    @property
    def is_known(self) -> bool:
        """True if the thread that calls has a turn."""
        return hasattr(self._mine, "turn")

    def enlist(self, name: str) -> Turn:
        """Add a thread that is about to start."""
        self._number += 1
        turn = Turn(name, self._number)
        self._turns.append(turn)
        return turn

    def begin(self, turn: Turn) -> None:
        """Begin a thread's part; it has its turn when this returns."""
        self._mine.turn = turn
        turn.identity = threading.get_ident()
        self._stand(turn)

    def retire(self, turn: Turn) -> None:
        """End a thread's part, and let others have their turns."""
        self._enter()
        turn.is_over = True
        self._turns.remove(turn)
        self._pass_on(turn)

    # ---- waiting ----

    @property
    def now_ns(self) -> SimTimeNs:
        return self._runtime.now_ns

    def wait(
        self,
        ready: Callable[[], bool],
        until_ns: int,
        what: str,
        end: LineEnd | None = None,
        *,
        is_outside: bool = False,
    ) -> None:
        """Let others run, and time pass, until ``ready`` or ``until_ns``; as ``Passing.wait``."""
        if self.works_here:
            return
        turn = self._enter()
        if not ready():
            self._looks.acted()
            self._wait(turn, Wait(ready, until_ns, what, end, is_outside))

    def look(self) -> None:
        """Let the time of a look pass, no further than a byte, and others have their turns."""
        if self.works_here:
            return
        turn = self._enter()
        start_ns = self.now_ns
        until_ns = SimTimeNs(start_ns + self._looks.next_cost_ns())
        if len(self._turns) == 1 and until_ns < self.timers.due_ns and not self.outside.is_there():
            self._advance(until_ns, self._ends(is_look=True))
        else:
            self._wait(turn, Wait(lambda: self.now_ns > start_ns, until_ns, "a look", is_look=True))

    def free_lock(self) -> None:
        """Note that a thread took a lock that was free: many in a row are a look."""
        self._free_locks += 1
        if self._free_locks >= _FREE_LOCKS_ARE_A_LOOK:
            self._free_locks = 0
            self.look()

    def _enter(self) -> Turn:
        """Note that a thread waits or looks; one that was left beside the others waits for its turn first."""
        turn = self.mine
        with self._mutex:
            turn.steps += 1
            is_beside = self._running is not turn
        if is_beside:
            turn.is_beside = turn.wants_back = True
            self._stand(turn)
        return turn

    def _wait(self, turn: Turn, wait: Wait) -> None:
        self._free_locks = 0
        while True:
            turn.wait = wait
            self._pass_on(turn)
            if turn is not self.main:
                return
            if self.is_given_up:
                said = "every thread waits, and nothing will end it:"
                raise EndlessWait(f"{said}\n{self.who_waits()}")
            if self.timers.due_ns > self.now_ns:
                return
            self.timers.run(self.now_ns)
            if self.now_ns >= wait.until_ns or wait.ready():
                return

    # ---- who is next ----

    def _pass_on(self, turn: Turn) -> None:
        """Let the next thread run that can, and wait for one's own turn, unless it is over."""
        chosen = self._choose(turn)
        if chosen is turn:
            return
        self._run(chosen)
        if not turn.is_over:
            self._stand(turn)

    def _stand(self, turn: Turn) -> None:
        """Stand until it is one's turn."""
        turn.gate.acquire()
        while self._running is not turn:
            turn.gate.acquire()

    def _run(self, turn: Turn) -> None:
        self._running = turn
        self._open_gate(turn)

    def _open_gate(self, turn: Turn) -> None:
        with suppress(RuntimeError):  # it is open, and was not noticed yet
            turn.gate.release()

    def wake_main(self) -> None:
        """Let the main thread notice a signal that came just before it stood."""
        self._open_gate(self.main)

    def _choose(self, after: Turn) -> Turn:
        """Let time pass until a thread can run; the first that can, in their order."""
        self._running = None
        while True:
            now_ns = self.now_ns
            if self.timers.due_ns <= now_ns:
                if not self.main.is_beside:
                    return self._chosen(self.main)
                self.timers.ring_beside(now_ns)
            for turn in self._in_order(after):
                if turn.is_due(now_ns):
                    return self._chosen(turn)
            self._let_time_pass()

    def _chosen(self, turn: Turn) -> Turn:
        turn.is_beside = turn.wants_back = False
        self._running = turn
        return turn

    def _in_order(self, after: Turn) -> list[Turn]:
        later = [turn for turn in self._turns if turn.number > after.number]
        return later + [turn for turn in self._turns if turn.number <= after.number]

    # ---- time ----

    def _let_time_pass(self) -> None:
        waiting = [turn for turn in self._turns if not turn.is_beside]
        waits = [turn.wait for turn in waiting]
        due_ns = [each.due_ns for each in self._terminals]
        limit_ns = SimTimeNs(min([self.timers.due_ns, *due_ns, *(wait.until_ns for wait in waits)]))
        if len(waiting) < len(self._turns) or any(w.is_outside for w in waits) or self.outside.is_there():
            self._pass_with_the_wall(limit_ns)
            return
        self._passes_wall = False
        if limit_ns == FOREVER:
            limit_ns = SimTimeNs(self._heard_ns + SILENCE_NS)
            if self.now_ns >= limit_ns:
                self.is_given_up = True
                self.main.wait = self.main.wait._replace(ready=lambda: True)
                return
        self._advance(limit_ns, self._ends(is_look=any(wait.is_look for wait in waits)))

    def _pass_with_the_wall(self, limit_ns: SimTimeNs) -> None:
        """Let as much time pass as passes outside meanwhile."""
        if not self._passes_wall:
            self._passes_wall, self._wall_s = True, _clock()
        _sleep(_PIECE_S)
        now_s = _clock()
        passed_ns = round((now_s - self._wall_s) * NS_PER_S)
        self._wall_s = now_s
        with self.inside():
            self.outside.pass_on(self.now_ns)
        self._advance(SimTimeNs(min(limit_ns, self.now_ns + passed_ns)), self._ends(is_look=True))

    def _go_on(self, limit_ns: SimTimeNs, ends: list[LineEnd]) -> SimTimeNs:
        """Let time pass; where a test says how far, no further than that before it says more."""
        while True:
            end_ns = min(limit_ns, self.stop_ns, self._arrivals.due_ns)
            self._runtime.advance_until_heard(end_ns, ends)
            self._arrivals.passed(self.now_ns)
            if (now_ns := self.now_ns) < self.stop_ns:
                return now_ns
            self.stop_ns = self.synchronize()
            if now_ns >= limit_ns or any(end.next_ns <= now_ns for end in ends):
                return now_ns

    @contextmanager
    def inside(self) -> Iterator[None]:
        """Let the bench work for the block: what it calls on this thread takes no time of the program."""
        self._inside = threading.get_ident()
        try:
            yield
        finally:
            self._inside = 0

    def _ends(self, *, is_look: bool) -> list[LineEnd]:
        """Lines at which a byte has to be noticed at its time."""
        ends = [each.end for each in self._terminals if each.opens and (is_look or each.is_watched)]
        return ends + [end for turn in self._turns if (end := turn.wait.end) and end not in ends]

    def _advance(self, limit_ns: SimTimeNs, ends: list[LineEnd]) -> None:
        with self.inside():
            now_ns = self._go_on(limit_ns, ends)
        if now_ns < limit_ns:
            self._heard_ns = now_ns
        for each in self._terminals:
            if each.opens or each.due_ns <= now_ns:
                each.passed(now_ns)

    # ---- what is told ----

    def tell_once(self, about: str, text: str) -> None:
        """Tell the user something, once."""
        if about not in self._told:
            self._told.add(about)
            self._say(text)

    def who_waits(self) -> str:
        """Lines for people: what each thread waits for, and where."""
        lines = [f"  {turn.name} waits for {turn.wait.what}{turn.place()}" for turn in self._turns]
        return "\n".join(lines)

    def watch(self) -> None:
        """Leave threads beside that do not wait; runs in a thread of its own for as long as the program."""
        seen: tuple[Turn | None, int] = None, 0
        since_s = _clock()
        while True:
            _sleep(PATIENCE_S / 5)
            running = self._running
            now = running, running.steps if running else 0
            if now != seen or running is None or self._is_alone():
                seen, since_s = now, _clock()
            elif _clock() - since_s >= PATIENCE_S:
                self._leave_beside(running, running.steps)
                seen = None, 0

    def _is_alone(self) -> bool:
        """True if nothing waits for the thread that runs."""
        return len(self._turns) == 1 and self.timers.due_ns == FOREVER

    def _leave_beside(self, turn: Turn, steps: int) -> None:
        with self._mutex:
            if self._running is not turn or turn.steps != steps:
                return
            self._running = None
            turn.is_beside = True
        self.tell_once(
            "beside",
            f"{turn.name} has not waited for {PATIENCE_S:g} s{turn.place()}: the others go on beside it, at"
            " the wall's pace; another run may differ",
        )
        self._run(self._choose(turn))
