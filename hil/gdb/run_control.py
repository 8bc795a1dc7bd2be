"""Running and standing of a chip: breakpoints, and steps, which may be of one instruction or of a line.

A step that an interrupt of the chip comes into ends behind the interrupt's routine, unless there is a
breakpoint in it.
"""

from hil.gdb.avr_target import VECTOR_BYTES, VECTORS, DebuggedChip, return_address

_VECTORS_END = VECTORS * VECTOR_BYTES


class RunControl:
    """Run of a chip, which stands at first."""

    def __init__(self, chip: DebuggedChip) -> None:
        self._chip = chip
        self.breakpoints = set[int]()
        """Byte addresses before whose instructions it stops."""
        self.is_running = False
        self._within = range(0)
        """Addresses within which steps go on."""
        self._stepped_from: int | None = None
        """Address of the instruction that a step is to carry out; None: it runs freely."""
        self._returns_to: int | None = None
        """Address behind an interrupt's routine, which came into a step."""

    def go(self) -> None:
        """Let it run to a breakpoint."""
        self._begin(None)
        self._chip.go(self.breakpoints, is_step=False)

    def step(self, within: range = range(0)) -> None:
        """Let it carry out one instruction, and further ones as long as they stand within these addresses."""
        self._begin(self._chip.program_counter)
        self._within = within
        self._chip.go(self.breakpoints, is_step=True)

    def let_go(self) -> None:
        """Let it run without breakpoints."""
        self.breakpoints.clear()
        self._begin(None)
        self._chip.go((), is_step=False)

    def halt(self) -> None:
        self._chip.halt()
        self.is_running = False

    def forget_step(self) -> None:
        """Note that it is no more where a step began: it stops where it comes to next."""
        self._stepped_from = self._returns_to = None

    def stopped(self) -> bool:
        """Note that the chip has stopped; false: it goes on, since it has not come yet to where a step
        ends."""
        self.is_running = self.is_running and self._goes_on(self._chip.program_counter)
        return not self.is_running

    def _begin(self, origin: int | None) -> None:
        self.is_running, self._within = True, range(0)
        self._stepped_from, self._returns_to = origin, None

    def _goes_on(self, pc: int) -> bool:
        if (origin := self._stepped_from) is None:
            return False
        if self._returns_to is not None:
            if pc != self._returns_to:
                return False  # a breakpoint in the interrupt's routine
            self._returns_to = None
            if pc != origin:
                return self._steps_on(pc)
            self._chip.go(self.breakpoints, is_step=True)  # it came before the instruction
            return True
        is_vector = 0 < pc < _VECTORS_END and pc % VECTOR_BYTES == 0
        if is_vector and origin >= _VECTORS_END and pc not in self.breakpoints:
            self._returns_to = return_address(self._chip)
            self._chip.go(self.breakpoints | {self._returns_to}, is_step=False)
            return True
        return self._steps_on(pc)

    def _steps_on(self, pc: int) -> bool:
        if pc not in self._within or pc in self.breakpoints:
            return False
        self._stepped_from = pc
        self._chip.go(self.breakpoints, is_step=True)
        return True
