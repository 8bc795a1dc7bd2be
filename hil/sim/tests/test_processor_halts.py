"""Checks of a processor that halts, is counted and is written to, by who debugs it."""

import struct
from collections.abc import Callable

import pytest

from hil.core.core_processor import CoreProcessor
from hil.sim.bench import BenchRuntime
from hil.sim.group import Group
from hil.sim.inputs import WriteMemory
from hil.sim.twin import Twin
from hil.testing import Bench
from hil.vocab.time import SimTimeNs

PROGRAM = struct.pack(
    "<6H",
    0xE080,  # 0: ldi r24, 0
    0x9583,  # 2: inc r24
    0xD001,  # 4: rcall 8
    0xCFFD,  # 6: rjmp 2
    0x0000,  # 8: nop
    0x9508,  # A: ret
)
TURN = 11
"""Cycles from one inc to the next: 1 + 3 + 1 + 4 + 2."""
LOOP, CALLED = 2, 8
R24 = 24
MS = 1_000_000


class Held:
    """Debugger that holds the group where the processor halts."""

    def __init__(self, group: Group) -> None:
        self.group, self.halts, self.others = group, 0, list[str]()

    def halted(self) -> None:
        self.group.is_held = True
        self.halts += 1

    def loaded(self) -> None:
        self.others.append("loaded")

    def removed(self) -> None:
        self.others.append("removed")


class Chip:
    """Processor of a bench in memory that is debugged."""

    def __init__(self, bench: Bench) -> None:
        self.runtime: BenchRuntime = bench.runtime
        self.device: Twin = self.runtime.devices["u1"]
        self.processor: CoreProcessor = self.device.processor
        self.group = self.runtime.parts.group_of("u1")
        self.debugger = self.device.debugger = Held(self.group)
        self.start()

    def start(self) -> None:
        """Load the program, and start it."""
        self.processor.load(0, PROGRAM)
        self.processor.set_fuses(0xFF, 0xDF, 0xFD, 0x3F)  # no boot loader
        self.processor.reset(1)
        self.begun = self.processor.cycles

    @property
    def cycles(self) -> int:
        """Cycles since the reset."""
        return self.processor.cycles - self.begun

    def go(self, *breakpoints: int, is_step: bool = False, at_most_ns: int = MS) -> int:
        """Let it go on, to where it halts, or for so long; answers the program counter."""
        self.processor.debug.go(breakpoints, is_step=is_step)
        self.group.is_held = False
        self.group.advance(SimTimeNs(self.group.now_ns + at_most_ns))
        return self.processor.program_counter


@pytest.fixture
def chip(bench: Callable[..., Bench]) -> Chip:
    made = bench({"bench": "b", "devices": {"u1": {"profile": "uno"}}})
    made.run(ms=1)
    return Chip(made)


def test_it_halts_before_the_instruction_at_a_breakpoint(chip: Chip) -> None:
    assert chip.go(CALLED) == CALLED
    assert chip.cycles == 5  # ldi, inc, rcall
    assert chip.processor.debug.is_halted
    assert chip.group.now_ns == MS + 312  # 5 cycles of 62.5 ns, down
    assert chip.go(CALLED) == CALLED
    assert (chip.cycles, chip.processor.data(R24, 1)) == (5 + TURN, b"\x02")
    assert chip.go(LOOP, CALLED) == LOOP
    assert chip.debugger.halts == 3


def test_breakpoints_stay_when_the_power_goes(chip: Chip) -> None:
    chip.go(CALLED)
    chip.device.axis.power_up()
    chip.start()
    assert chip.go(CALLED) == CALLED
    assert chip.cycles == 5


def test_time_stands_where_it_halts(chip: Chip) -> None:
    chip.go(CALLED)
    chip.group.advance(SimTimeNs(chip.group.now_ns + MS))
    assert chip.group.now_ns == MS + 312
    assert chip.cycles == 5


def test_a_step_is_one_instruction(chip: Chip) -> None:
    chip.processor.debug.halt()
    assert [chip.go(is_step=True) for _ in range(6)] == [2, 4, 8, 10, 6, 2]
    assert chip.cycles == 1 + TURN
    assert chip.go(4, is_step=True) == 4
    assert chip.go(4, is_step=True) == 8  # the instruction at a breakpoint, too


def test_without_breakpoints_it_runs_on(chip: Chip) -> None:
    chip.go(CALLED)
    chip.go()
    assert not chip.processor.debug.is_halted
    assert chip.group.now_ns == 2 * MS + 312


@pytest.mark.parametrize("how", ["breakpoints", "counts", "steps"])
def test_who_debugs_it_changes_nothing(how: str, bench: Callable[..., Bench]) -> None:
    chips = [Chip(bench({"bench": "b", "devices": {"u1": {"profile": "uno"}}})) for _ in range(2)]
    free, debugged = chips
    free.go()
    if how == "counts":
        debugged.processor.debug.count([0, LOOP, CALLED], LOOP)
    while debugged.group.now_ns < MS:
        breakpoints = [CALLED] if how == "breakpoints" else []
        left_ns = MS - debugged.group.now_ns
        debugged.go(*breakpoints, is_step=how == "steps", at_most_ns=left_ns)
    assert debugged.processor.data(0, 0x900) == free.processor.data(0, 0x900)
    assert debugged.processor.cycles == free.processor.cycles


def test_cycles_are_counted_by_function(chip: Chip) -> None:
    debug = chip.processor.debug
    debug.count([0, LOOP, CALLED], LOOP)
    chip.go()
    cycles, rows = debug.counted()
    turns = rows[2].calls
    assert sum(row.cycles for row in rows) == pytest.approx(cycles, abs=4)  # one is under way
    assert turns == pytest.approx(cycles / TURN, abs=1)
    assert rows[0] == (1, 1)
    assert rows[1].cycles == pytest.approx(6 * turns, abs=6)
    assert set(debug.laps) == {TURN}
    assert len(debug.laps) == 1024
    debug.count([])
    assert debug.counted()[1] == []
    assert debug.laps == []


def test_the_lowest_address_on_the_stack_is_kept(chip: Chip) -> None:
    assert chip.processor.debug.stack_lowest == 0x8FF
    chip.go(CALLED)
    assert chip.processor.debug.stack_lowest == 0x8FE
    chip.processor.reset(1)
    assert chip.processor.debug.stack_lowest == 0x8FF


def test_a_debugger_writes_by_inputs(chip: Chip) -> None:
    chip.go(CALLED)
    chip.runtime.apply_to(chip.device, WriteMemory("data", R24, "7f"))
    chip.runtime.apply_to(chip.device, WriteMemory("eeprom", 3, "abcd"))
    chip.runtime.apply_to(chip.device, WriteMemory("pc", 0))
    assert chip.processor.data(R24, 1) == b"\x7f"
    assert chip.processor.eeprom[3:5] == b"\xab\xcd"
    assert chip.go(is_step=True) == 2
    assert chip.processor.data(R24, 1) == b"\x00"
