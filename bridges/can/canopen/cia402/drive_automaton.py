"""State machine of a drive over its axis and its modes, and the times at which it looks at them."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import NamedTuple

from bridges.can.canopen.cia402.cyclic_modes import CyclicMode
from bridges.can.canopen.cia402.drive_context import DriveContext
from bridges.can.canopen.cia402.error_codes import TOLD_BY_NODE, DriveError, register_bits
from bridges.can.canopen.cia402.operating_mode import IDLE_NS, WATCH_NS, OperatingMode, TimeWindow
from bridges.can.canopen.cia402_words import (
    FOLLOWING_ERROR,
    LEADS_TO,
    LIMIT_ACTIVE,
    REMOTE,
    TARGET_REACHED,
    TRANSITIONS,
    UNDER_POWER,
    VOLTAGE_ENABLED,
    DriveCommand,
    DriveState,
    command_of,
)
from hil.vocab.time import FOREVER
from hil.vocab.verbs import VerbRefused


class FoundFault(NamedTuple):
    """Fault that was found: its error code, and what it is in words."""

    code: int
    why: str


class DriveWatch:
    """Watch of one drive. ``looked_ns``: when it looked last."""

    def __init__(self, context: DriveContext) -> None:
        self.looked_ns = 0
        self._context = context
        self._following = TimeWindow()
        self._is_blocked = False

    def begin(self, now_ns: int) -> None:
        """Begin with an axis that has just been told something new."""
        self.looked_ns = now_ns
        self._is_blocked = False
        self._following.clear()

    def look(self, mode: OperatingMode, now_ns: int, *, obeys_switches: bool) -> FoundFault | None:
        """Look for a fault; if there is none, stop a motion towards an active limit switch, once."""
        context = self._context
        look = context.look(now_ns)
        self.looked_ns = now_ns
        if look.fault_code:
            return FoundFault(look.fault_code, "the board reports a fault")
        if not look.is_on:
            return FoundFault(DriveError.LOOP_OFF, "the board's loop is off")
        if mode.checks_position:
            context.mover.check(look)
            off_deg = abs(context.off_deg(look, now_ns))
            is_off = off_deg > context.following_deg
            if self._following.holds(is_off, context.following_ns, now_ns):
                return FoundFault(DriveError.FOLLOWING, f"{off_deg:.3g} deg from the set-point")
        if obeys_switches and look.inputs and mode.obeys_limits:
            self._look_ahead(mode, now_ns)
        return None

    def _look_ahead(self, mode: OperatingMode, now_ns: int) -> None:
        context = self._context
        is_blocked = context.is_blocked(context.mover.where(now_ns).rate, now_ns)
        if is_blocked:
            if not self._is_blocked:
                mode.block(now_ns)
            context.is_limited = True
        self._is_blocked = is_blocked


NO_ACTION, FAULT, DISABLE_VOLTAGE, QUICK_STOP = range(4)
"""Abort connection option codes (6007h)."""
POWER_OFF, STAYS = 0, 5
"""Option code that takes the power off at once; quick stop option codes from which on the drive stays."""


class DriveAutomaton:
    """State machine, from a power-up of the card on. What the axis refuses becomes a fault."""

    def __init__(self, context: DriveContext, modes: Mapping[int, OperatingMode]) -> None:
        self.state = DriveState.NOT_READY
        self.error_code = 0
        self.why = ""
        """Reason of the fault in words."""
        self.number = 0
        """Number of the mode in force (6061h); 0: none."""
        self._context, self._modes = context, modes
        self.mode: OperatingMode = OperatingMode(context)
        self._word = 0
        self.leaves_by: int | None = None
        """Transition that waits until the axis stands."""
        self.watch = DriveWatch(context)
        self._has_lost_set_point = False
        self._bits = 0
        """Bits of 1001h that the fault has set."""

    @property
    def statusword(self) -> int:
        word = self.state | VOLTAGE_ENABLED | REMOTE
        if self._context.is_limited:
            word |= LIMIT_ACTIVE
        if self.state is DriveState.OPERATION_ENABLED:
            word |= self.mode.status(self.watch.looked_ns)
        elif self.state is DriveState.QUICK_STOP and self._context.mover.is_over(self.watch.looked_ns):
            word |= TARGET_REACHED
        return word | FOLLOWING_ERROR if self._has_lost_set_point else word

    @property
    def is_enabled(self) -> bool:
        """True if the mode in force moves the axis."""
        return self.state is DriveState.OPERATION_ENABLED and self.leaves_by is None

    # ---- what comes from outside ----

    def control(self, word: int, now_ns: int) -> None:
        """Take a controlword."""
        before, self._word = self._word, word
        with refusals(self, now_ns):
            self._control(word, before, now_ns)

    def choose(self, number: int, now_ns: int) -> None:
        """Take a mode of operation, which there is."""
        if number == self.number:
            return
        is_enabled = self.state is DriveState.OPERATION_ENABLED
        with refusals(self, now_ns):
            if is_enabled:
                self.mode.end(now_ns)
            self.number, self.mode = number, self._modes[number]
            if is_enabled and self.leaves_by is None:
                self._begin(now_ns)

    def written(self, index: int, now_ns: int) -> bool:
        """Take note of a new value; answers True if the mode in force wants to know it."""
        if index not in self.mode.targets or not self.is_enabled:
            return False
        with refusals(self, now_ns):
            self.mode.written(index, now_ns)
        return True

    def lose(self, error: DriveError, now_ns: int) -> None:
        """Do what the abort connection option code says."""
        option = self._context.value(0x6007)
        if option == NO_ACTION or self.state not in UNDER_POWER:
            return
        with refusals(self, now_ns):
            if option == FAULT:
                self.fail(error, now_ns)
            elif option == DISABLE_VOLTAGE:
                self.off(DriveState.SWITCH_ON_DISABLED)
            elif self.state is DriveState.OPERATION_ENABLED:
                self._quick_stop(now_ns)

    def power_off(self) -> None:
        """Begin again: the card is reset."""
        if self.state in UNDER_POWER:
            self.off(DriveState.NOT_READY)

    # ---- transitions ----

    def _control(self, word: int, before: int, now_ns: int) -> None:
        if self.state is DriveState.FAULT:
            if word & ~before & DriveCommand.RESET:
                self._reset(now_ns)
            return
        command = command_of(word)
        number = TRANSITIONS.get(self.state, {}).get(command)
        if number is not None:
            self._do(number, now_ns)
            if number == 3 and command is DriveCommand.ENABLE:
                self._do(4, now_ns)
        elif self.state is DriveState.OPERATION_ENABLED:
            if self.leaves_by is not None:  # it is told to go on
                self.leaves_by = None
                self._begin(now_ns)
            else:
                self.mode.control(word, before, now_ns)

    def _do(self, number: int, now_ns: int) -> None:
        """Make a transition that a master asks for."""
        context = self._context
        if number == 4:
            self._on(now_ns)
        elif number in (5, 8):
            if context.value(0x605C if number == 5 else 0x605B) == POWER_OFF:
                self.off(LEADS_TO[number])
            elif self.leaves_by is None:
                self.mode.stop(1, now_ns)
            self.leaves_by = number if self.state is DriveState.OPERATION_ENABLED else None
            if self.leaves_by and context.mover.is_over(now_ns):
                self.off(LEADS_TO[number])
        elif number in (9, 12):
            self.off(LEADS_TO[number])
        elif number == 11:
            self._quick_stop(now_ns)
        elif number == 16:
            if context.value(0x605A) >= STAYS:
                self.state = LEADS_TO[number]
                self._begin(now_ns)
        else:
            self.state = LEADS_TO[number]

    def _on(self, now_ns: int) -> None:
        context = self._context
        context.axis.enable()
        context.forget()
        look = context.look(now_ns)
        context.mover.begin(look)
        context.torque_demand = 0.0
        self.state = DriveState.OPERATION_ENABLED
        self._begin(now_ns)

    def _begin(self, now_ns: int) -> None:
        """Begin the mode in force, where the axis is."""
        self._context.is_limited = False
        self.watch.begin(now_ns)
        self.mode.begin(self._word, now_ns)

    def off(self, to: DriveState) -> None:
        """Take the power off."""
        context = self._context
        self.leaves_by = None
        self.state = to
        context.torque_demand, context.is_limited = 0.0, False
        with suppress(VerbRefused):  # a board that refuses it has switched off by itself
            if "disable" in context.axis.verbs:
                context.axis.disable()
            else:
                context.axis.stop("prejudice", context.ramp(is_quick=True))
        context.forget()

    def _quick_stop(self, now_ns: int) -> None:
        option = self._context.value(0x605A)
        self.leaves_by = None
        if option == POWER_OFF:
            self.off(DriveState.SWITCH_ON_DISABLED)
            return
        self.state = DriveState.QUICK_STOP
        self.mode.stop(option - STAYS + 1 if option >= STAYS else option, now_ns)

    def fail(self, code: int, now_ns: int, why: str = "") -> None:
        """Go into fault, by the fault reaction option code."""
        if self.state in (DriveState.FAULT, DriveState.FAULT_REACTION):
            return
        self.error_code, self.why = code, why
        self._has_lost_set_point = code == DriveError.FOLLOWING
        self._bits = 0 if code in TOLD_BY_NODE else register_bits(code)
        if self._bits:
            self._context.services.emergency(code, self._bits)
        option = self._context.value(0x605E)
        if self.state not in UNDER_POWER:
            self.state = DriveState.FAULT
        elif option == POWER_OFF or not self._context.look(now_ns).is_on:
            self.off(DriveState.FAULT)
        else:
            self.state, self.leaves_by = DriveState.FAULT_REACTION, None
            try:
                self.mode.stop(option, now_ns)
                is_over = self._context.mover.is_over(now_ns)
            except VerbRefused:
                is_over = True
            if is_over:
                self.off(DriveState.FAULT)

    def _reset(self, now_ns: int) -> None:
        context = self._context
        with refusals(self, now_ns):
            context.axis.clear_fault()
            context.forget()
            if code := context.look(now_ns).fault_code:
                self.error_code = code
                return
            if self._bits:
                context.services.emergency(0, self._bits)
            self.error_code, self.why, self._has_lost_set_point = 0, "", False
            self.state = LEADS_TO[15]


@contextmanager
def refusals(automaton: DriveAutomaton, now_ns: int) -> Iterator[None]:
    """Make a fault of what the axis refuses."""
    try:
        yield
    except VerbRefused as refusal:
        automaton.fail(DriveError.REFUSED, now_ns, str(refusal))


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
                elif isinstance(mode, CyclicMode) and now_ns >= mode.due_ns:
                    mode.due_ns = FOREVER
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
                if found := automaton.watch.look(mode, now_ns, obeys_switches=True):
                    automaton.fail(found.code, now_ns, found.why)
                else:
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
            exact_ns, watch_ns = automaton.mode.due_ns, automaton.mode.watch_ns
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
