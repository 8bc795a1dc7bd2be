"""State machine of a drive over its axis and its modes."""

from collections.abc import Mapping
from contextlib import suppress

from hil.canopen.cia402.cyclic_modes import CyclicMode
from hil.canopen.cia402.drive_context import DriveContext
from hil.canopen.cia402.drive_states import (
    LEADS_TO,
    RESET_BIT,
    TRANSITIONS,
    UNDER_POWER,
    DriveCommand,
    DriveState,
    command_of,
)
from hil.canopen.cia402.error_codes import DriveError, register_bits
from hil.canopen.cia402.motor_axis import MotorLook
from hil.canopen.cia402.operating_mode import BIT_13, IDLE_NS, REACHED, WATCH_NS, OperatingMode
from hil.canopen.cia402.time_window import TimeWindow
from hil.vocab.time import FOREVER
from hil.vocab.verbs import VerbRefused

POWERED, REMOTE, LIMITED = 0x0010, 0x0200, 0x0800
"""Bits of the statusword: voltage enabled, remote, internal limit active."""
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
        self.due_ns: int = 0
        self._context, self._modes = context, modes
        self._mode: OperatingMode = OperatingMode(context)
        self._word = 0
        self._leaves_by: int | None = None
        """Transition that waits until the axis stands."""
        self._following = TimeWindow()
        self._is_blocked = False
        self._looked_ns = 0
        self._has_lost_set_point = False

    @property
    def statusword(self) -> int:
        word = self.state | POWERED | REMOTE
        if self._context.is_limited:
            word |= LIMITED
        if self.state is DriveState.OPERATION_ENABLED:
            word |= self._mode.status(self._looked_ns)
        elif self.state is DriveState.QUICK_STOP and self._context.mover.is_over(self._looked_ns):
            word |= REACHED
        return word | BIT_13 if self._has_lost_set_point else word

    # ---- what comes from outside ----

    def control(self, word: int, now_ns: int) -> None:
        """Take a controlword."""
        before, self._word = self._word, word
        with self._refusals(now_ns):
            self._control(word, before, now_ns)
        self._plan(now_ns)

    def choose(self, number: int, now_ns: int) -> None:
        """Take a mode of operation, which there is."""
        if number == self.number:
            return
        is_enabled = self.state is DriveState.OPERATION_ENABLED
        with self._refusals(now_ns):
            if is_enabled:
                self._mode.end(now_ns)
            self.number, self._mode = number, self._modes[number]
            if is_enabled and self._leaves_by is None:
                self._begin(now_ns)
        self._plan(now_ns)

    def written(self, index: int, now_ns: int) -> None:
        """Take note of a new value."""
        if self._is_enabled and index in self._mode.targets:
            with self._refusals(now_ns):
                self._mode.written(index, now_ns)
            self._plan(now_ns)

    def synced(self, now_ns: int) -> None:
        """Take note of SYNC."""
        mode = self._mode
        if self._is_enabled and isinstance(mode, CyclicMode):
            try:
                self._check(now_ns)
                if self._is_enabled:
                    mode.synced(now_ns)
            except VerbRefused as refusal:
                self._refused(refusal, now_ns)
            self._plan(now_ns)

    def lose(self, error: DriveError, now_ns: int) -> None:
        """Do what the abort connection option code says."""
        option = self._context.value(0x6007)
        if option == NO_ACTION or self.state not in UNDER_POWER:
            return
        with self._refusals(now_ns):
            if option == FAULT:
                self.fail(error, now_ns)
            elif option == DISABLE_VOLTAGE:
                self._off(DriveState.SWITCH_ON_DISABLED)
            elif self.state is DriveState.OPERATION_ENABLED:
                self._quick_stop(now_ns)
        self._plan(now_ns)

    def power_off(self) -> None:
        """Begin anew: the card is reset."""
        if self.state in UNDER_POWER:
            self._off(DriveState.NOT_READY)

    def step(self, now_ns: int) -> None:
        """Do what is due, and look at the axis."""
        if self.state is DriveState.NOT_READY:
            look = self._context.look(now_ns)
            if look.is_ready and look.failure is None:
                self.state = LEADS_TO[1]
        elif self.state in UNDER_POWER:
            with self._refusals(now_ns):
                self._check(now_ns)
                self._go_on(now_ns)
        self._looked_ns = now_ns
        self._plan(now_ns)

    # ---- transitions ----

    def _control(self, word: int, before: int, now_ns: int) -> None:
        if self.state is DriveState.FAULT:
            if word & ~before & RESET_BIT:
                self._reset(now_ns)
            return
        command = command_of(word)
        number = TRANSITIONS.get(self.state, {}).get(command)
        if number is not None:
            self._do(number, now_ns)
            if number == 3 and command is DriveCommand.ENABLE:
                self._do(4, now_ns)
        elif self.state is DriveState.OPERATION_ENABLED:
            if self._leaves_by is not None:  # it is told to go on
                self._leaves_by = None
                self._begin(now_ns)
            else:
                self._mode.control(word, before, now_ns)

    def _do(self, number: int, now_ns: int) -> None:
        """Make a transition that a master asks for."""
        context = self._context
        if number == 4:
            self._on(now_ns)
        elif number in (5, 8):
            if context.value(0x605C if number == 5 else 0x605B) == POWER_OFF:
                self._off(LEADS_TO[number])
            elif self._leaves_by is None:
                self._mode.stop(1, now_ns)
            self._leaves_by = number if self.state is DriveState.OPERATION_ENABLED else None
        elif number in (9, 12):
            self._off(LEADS_TO[number])
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
        self._following.clear()
        self._begin(now_ns)

    def _begin(self, now_ns: int) -> None:
        """Begin the mode in force, where the axis is."""
        self._context.is_limited = self._is_blocked = False
        self._mode.begin(self._word, now_ns)
        self._looked_ns = now_ns

    def _off(self, to: DriveState) -> None:
        """Take the power off."""
        context = self._context
        self._leaves_by = None
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
        self._leaves_by = None
        if option == POWER_OFF:
            self._off(DriveState.SWITCH_ON_DISABLED)
            return
        self.state = DriveState.QUICK_STOP
        self._mode.stop(option - STAYS + 1 if option >= STAYS else option, now_ns)

    def fail(self, code: int, now_ns: int, why: str = "") -> None:
        """Go into fault, by the fault reaction option code."""
        if self.state in (DriveState.FAULT, DriveState.FAULT_REACTION):
            return
        self.error_code, self.why = code, why
        self._has_lost_set_point = code == DriveError.FOLLOWING
        self._context.services.emergency(code, register_bits(code))
        option = self._context.value(0x605E)
        if self.state not in UNDER_POWER:
            self.state = DriveState.FAULT
        elif option == POWER_OFF or not self._context.look(now_ns).is_on:
            self._off(DriveState.FAULT)
        else:
            self.state, self._leaves_by = DriveState.FAULT_REACTION, None
            try:
                self._mode.stop(option, now_ns)
            except VerbRefused:
                self._off(DriveState.FAULT)

    def _reset(self, now_ns: int) -> None:
        context = self._context
        with self._refusals(now_ns):
            context.axis.clear_fault()
            context.forget()
            if code := context.look(now_ns).fault_code:
                self.error_code = code
                return
            context.services.emergency(0, register_bits(self.error_code))
            self.error_code, self.why, self._has_lost_set_point = 0, "", False
            self.state = LEADS_TO[15]

    # ---- under power ----

    @property
    def _is_enabled(self) -> bool:
        return self.state is DriveState.OPERATION_ENABLED and self._leaves_by is None

    def _check(self, now_ns: int) -> None:
        """Look at the axis for whatever is a fault, and at the limit switches."""
        context, mode = self._context, self._mode
        look = context.look(now_ns)
        self._looked_ns = now_ns
        if look.fault_code:
            self.fail(look.fault_code, now_ns, "the board reports a fault")
        elif not look.is_on:
            self.fail(DriveError.LOOP_OFF, now_ns, "the board's loop is off")
        elif mode.checks_position:
            off_deg = abs(context.mover.where(now_ns).deg - look.position_deg)
            is_off = off_deg > context.window_deg(0x6065)
            if self._following.holds(is_off, context.ms(0x6066), now_ns) and is_off:
                self.fail(DriveError.FOLLOWING, now_ns, f"{off_deg:.3g} deg from the set-point")
        if look.inputs and self._is_enabled and mode.obeys_limits:
            self._check_switches(look, now_ns)

    def _check_switches(self, look: MotorLook, now_ns: int) -> None:
        context = self._context
        is_blocked = context.is_blocked(context.mover.where(now_ns).rate, now_ns)
        if is_blocked and not self._is_blocked:
            self._mode.block(now_ns)
        if is_blocked:
            context.is_limited = True
        self._is_blocked = is_blocked

    def _go_on(self, now_ns: int) -> None:
        """Let the mode do what is due, or end what waits until the axis stands."""
        if self._is_enabled:
            mode = self._mode
            if isinstance(mode, CyclicMode) and now_ns >= mode.times_out_ns:
                mode.times_out_ns = FOREVER
                self.lose(DriveError.SYNC, now_ns)
            else:
                mode.step(now_ns)
        elif self.state in UNDER_POWER and self._context.mover.is_over(now_ns):
            if self.state is DriveState.FAULT_REACTION:
                self._off(DriveState.FAULT)
            elif self._leaves_by is not None:
                self._off(LEADS_TO[self._leaves_by])
            elif self._context.value(0x605A) < STAYS:
                self._off(DriveState.SWITCH_ON_DISABLED)

    def _plan(self, now_ns: int) -> None:
        """Work out when it wants to look next."""
        if self.state is DriveState.NOT_READY:
            self.due_ns = now_ns + IDLE_NS
            return
        if self.state not in UNDER_POWER:
            self.due_ns = FOREVER
            return
        if self._is_enabled:
            mode = self._mode
            exact_ns, watch_ns = mode.due_ns, mode.watch_ns
            if isinstance(mode, CyclicMode):
                exact_ns = mode.times_out_ns
        else:
            exact_ns = self._context.mover.due_ns
            watch_ns = IDLE_NS if self._context.mover.is_over(now_ns) else WATCH_NS
        due_ns = self._looked_ns + watch_ns
        self.due_ns = exact_ns if self._looked_ns < exact_ns < due_ns else due_ns

    # ---- refusals ----

    def _refusals(self, now_ns: int) -> "_Refusals":
        return _Refusals(self, now_ns)

    def _refused(self, refusal: VerbRefused, now_ns: int) -> None:
        self.fail(DriveError.REFUSED, now_ns, str(refusal))


class _Refusals:
    """Makes a fault of what the axis refuses."""

    def __init__(self, automaton: DriveAutomaton, now_ns: int) -> None:
        self._automaton, self._now_ns = automaton, now_ns

    def __enter__(self) -> None:
        return

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, *_: object) -> bool:
        if not isinstance(error, VerbRefused):
            return False
        self._automaton.fail(DriveError.REFUSED, self._now_ns, str(error))
        return True
