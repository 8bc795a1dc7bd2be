"""Debuggers of a bench's processors: GDB's sessions, and the time that stands for them.

A bench has one time: while a processor stands at a breakpoint, that of its group stands at that
instruction, and the bench's is held as `hil pause` holds it. With something real in the bench, whose time
cannot stand, the group alone waits, and catches up when it goes on.
"""

import asyncio
from collections.abc import Callable, Collection

from hil.gdb.avr_target import MemorySpace
from hil.gdb.debug_session import DebugSession
from hil.sim.bench import BenchRuntime
from hil.sim.debugger import NO_DEBUGGER
from hil.sim.group import Group
from hil.sim.inputs import Reset, WriteMemory
from hil.sim.twin import Twin
from hil.vocab.time import NS_PER_MS, SimTimeNs

STEP_NS = NS_PER_MS
"""Simulated time within which most steps end: they need no time of the bench."""
_SPACES = {MemorySpace.DATA: "data", MemorySpace.EEPROM: "eeprom"}


class ChipOfBench:
    """Processor of a twin, as ``hil.gdb.avr_target.DebuggedChip``."""

    def __init__(self, sim: BenchRuntime, device: Twin, stand: Callable[[bool], None]) -> None:
        self._sim, self._device, self._stand = sim, device, stand
        self._processor = device.processor
        self._group: Group = sim.parts.group_of(device.name)

    def read(self, space: MemorySpace, at: int, count: int) -> bytes:
        if space is MemorySpace.DATA:
            return self._processor.data(at, count)
        memory = self._processor.flash if space is MemorySpace.FLASH else self._processor.eeprom
        return memory[at : at + count]

    def write(self, space: MemorySpace, at: int, data: bytes) -> None:
        if space is MemorySpace.FLASH:
            raise ValueError("`hil sketch load` gives it another program")
        self._sim.apply_to(self._device, WriteMemory(_SPACES[space], at, data.hex()))

    @property
    def program_counter(self) -> int:
        return self._processor.program_counter

    def jump(self, address: int) -> None:
        if not 0 <= address < len(self._processor.flash):
            raise ValueError("no such address")
        self._sim.apply_to(self._device, WriteMemory("pc", address))

    def go(self, breakpoints: Collection[int], *, is_step: bool) -> None:
        group = self._group
        with self._sim.real_time.owning(group):
            self._processor.debug.go(breakpoints, is_step=is_step)
            group.is_held = False
            if is_step:
                group.advance(SimTimeNs(group.now_ns + STEP_NS))
        if not self.is_held:
            self._stand(False)

    def halt(self) -> None:
        with self._sim.present(self._device) as group:
            self._processor.debug.halt()
            group.is_held = True
        self.stand()

    def reset(self) -> None:
        self._sim.apply_to(self._device, Reset())

    def words(self) -> str:
        return f"cycle {self._processor.cycles}, {self._group.now_ns / 1e9:.9f} s of the bench"

    # ---- for the session ----

    @property
    def is_held(self) -> bool:
        """True while the group's time stands."""
        return self._group.is_held

    def hold(self) -> None:
        """Let the group's time stand where it is."""
        self._group.is_held = True

    def stand(self) -> None:
        """Let the bench's time stand, too."""
        self._stand(True)

    def let_time_go_on(self) -> None:
        self._group.is_held = False
        self._stand(False)


class ChipDebugging:
    """Session of a GDB with one processor, as ``hil.vocab.device.ProcessorSession``."""

    def __init__(self, sim: BenchRuntime, device: Twin, stand: Callable[[bool], None]) -> None:
        self._sim, self._device, self._stand = sim, device, stand
        self._chip: ChipOfBench | None = None
        self._session: DebugSession | None = None

    def begin(self, send: Callable[[bytes], object], hang_up: Callable[[], object]) -> None:
        if self._device.debugger is not NO_DEBUGGER:
            raise ConnectionError("another session was faster")
        self._loop, self._hang_up = asyncio.get_running_loop(), hang_up
        self._device.debugger = self
        self._chip = ChipOfBench(self._sim, self._device, self._stand)
        self._session = DebugSession(self._chip, send)
        self._device.power.listeners.append(self._power_changed)

    def received(self, data: bytes) -> bool:
        if not self._session:
            return True
        self._session.received(data)
        return self._session.is_over

    def close(self, why: str = "") -> None:
        """End the session, and let the processor run. ``why``: said in GDB, if it waits."""
        session, chip, self._session = self._session, self._chip, None
        if session and chip:
            self._device.debugger = NO_DEBUGGER
            self._device.power.listeners.remove(self._power_changed)
            session.close(why)
            chip.go((), is_step=False)
            chip.let_time_go_on()

    # ---- what happens to the processor ----

    def halted(self) -> None:
        if self._session and self._chip:
            self._chip.hold()
            self._loop.call_soon(self._tell_stop)  # the group is owned now

    def _tell_stop(self) -> None:
        if self._session and self._chip and self._chip.is_held:
            self._chip.stand()
            self._session.stopped()

    def loaded(self) -> None:
        if self._session:
            self._session.was_reset(is_other_program=True)

    def removed(self) -> None:
        self.close(f"{self._device.name} has left the bench")
        self._hang_up()

    def _power_changed(self, is_on: bool) -> None:
        if is_on and self._session:
            self._session.was_reset()
