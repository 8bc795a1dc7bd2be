"""Times of a drive's own work: looks at the axis, steps of its mode, SYNC."""

from hil.canopen.cia402.cyclic_modes import CyclicMode
from hil.canopen.cia402.drive_automaton import STAYS, DriveAutomaton
from hil.canopen.cia402.drive_context import DriveContext
from hil.canopen.cia402.drive_states import LEADS_TO, UNDER_POWER
from hil.canopen.cia402.error_codes import DriveError
from hil.canopen.cia402.operating_mode import IDLE_NS, WATCH_NS
from hil.vocab.time import FOREVER
from hil.vocab.verbs import VerbRefused
from hil.wire.canopen.cia402_words import DriveState


class AutomatonClock:
    """Times of a drive. ``due_ns``: when it wants ``step`` next; FOREVER: not before something comes."""

    def __init__(self, automaton: DriveAutomaton, context: DriveContext) -> None:
        self.due_ns: int = 0
        self._automaton, self._context = automaton, context

    def step(self, now_ns: int) -> None:
        """Do what is due, and look at the axis."""
        automaton = self._automaton
        if automaton.state is DriveState.NOT_READY:
            look = self._context.look(now_ns)
            if look.is_ready and look.failure is None:
                automaton.state = LEADS_TO[1]
        elif automaton.state in UNDER_POWER:
            mode = automaton.mode
            try:
                if not self._check(now_ns):
                    self._leave(now_ns)
                elif isinstance(mode, CyclicMode) and now_ns >= mode.times_out_ns:
                    mode.times_out_ns = FOREVER
                    automaton.lose(DriveError.SYNC, now_ns)
                else:
                    mode.step(now_ns)
            except VerbRefused as refusal:
                automaton.fail(DriveError.REFUSED, now_ns, str(refusal))
        automaton.watch.looked_ns = now_ns
        self.plan(now_ns)

    def synced(self, now_ns: int) -> None:
        """Let a cyclic mode take its targets, if one is in force."""
        automaton = self._automaton
        mode = automaton.mode
        if automaton.is_enabled and isinstance(mode, CyclicMode):
            try:
                if self._check(now_ns):
                    mode.synced(now_ns)
            except VerbRefused as refusal:
                automaton.fail(DriveError.REFUSED, now_ns, str(refusal))
            self.plan(now_ns)

    def plan(self, now_ns: int) -> None:
        """Work out when to look next."""
        automaton = self._automaton
        state = automaton.state
        if state is DriveState.NOT_READY:
            self.due_ns = now_ns + IDLE_NS
            return
        if state not in UNDER_POWER:
            self.due_ns = FOREVER
            return
        if state is DriveState.OPERATION_ENABLED and automaton.leaves_by is None:
            mode = automaton.mode
            exact_ns, watch_ns = mode.due_ns, mode.watch_ns
            if isinstance(mode, CyclicMode):
                exact_ns = mode.times_out_ns
        else:
            exact_ns = self._context.mover.due_ns
            watch_ns = IDLE_NS if self._context.mover.is_over(now_ns) else WATCH_NS
        looked_ns = automaton.watch.looked_ns
        due_ns = looked_ns + watch_ns
        self.due_ns = exact_ns if looked_ns < exact_ns < due_ns else due_ns

    def _check(self, now_ns: int) -> bool:
        """Look at the axis for whatever is a fault, and at the limit switches; answers True if the mode still
        moves it."""
        automaton = self._automaton
        is_enabled = automaton.is_enabled
        if found := automaton.watch.look(automaton.mode, now_ns, obeys_switches=is_enabled):
            automaton.fail(found.code, now_ns, found.why)
            return False
        return is_enabled

    def _leave(self, now_ns: int) -> None:
        """End what waits until the axis stands, if it does."""
        automaton = self._automaton
        if automaton.state in UNDER_POWER and self._context.mover.is_over(now_ns):
            if automaton.state is DriveState.FAULT_REACTION:
                automaton.off(DriveState.FAULT)
            elif automaton.leaves_by is not None:
                automaton.off(LEADS_TO[automaton.leaves_by])
            elif self._context.value(0x605A) < STAYS:
                automaton.off(DriveState.SWITCH_ON_DISABLED)
