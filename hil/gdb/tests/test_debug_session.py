"""Checks of the dialogue with GDB, at a chip that is made up: each instruction has two bytes."""

from collections.abc import Collection, Iterator

import pytest

from hil.gdb.avr_target import MemorySpace
from hil.gdb.debug_session import DebugSession
from hil.gdb.remote_packets import packed


class FakeChip:
    """Chip that runs when the test says so, along ``path``."""

    def __init__(self) -> None:
        self.memories = {
            MemorySpace.FLASH: bytearray(range(256)) * 128,
            MemorySpace.DATA: bytearray(0x900),
            MemorySpace.EEPROM: bytearray(0x400),
        }
        self.program_counter = 0x100
        self.path: Iterator[int] = iter(range(0x102, 0x8000, 2))
        self.going: tuple[frozenset[int], bool] | None = None
        self.resets = 0

    def read(self, space: MemorySpace, at: int, count: int) -> bytes:
        return bytes(self.memories[space][at : at + count])

    def write(self, space: MemorySpace, at: int, data: bytes) -> None:
        if space is MemorySpace.FLASH:
            raise ValueError("no")
        self.memories[space][at : at + len(data)] = data

    def jump(self, address: int) -> None:
        self.program_counter = address

    def go(self, breakpoints: Collection[int], *, is_step: bool) -> None:
        self.going = frozenset(breakpoints), is_step

    def halt(self) -> None:
        self.going = None

    def reset(self) -> None:
        self.program_counter, self.resets = 0, self.resets + 1

    def words(self) -> str:
        return "cycle 5"

    def run(self) -> None:
        """Run to the next stop."""
        assert self.going is not None
        breakpoints, is_step = self.going
        self.program_counter = next(self.path)
        while not is_step and self.program_counter not in breakpoints:
            self.program_counter = next(self.path)
        self.going = None


class Gdb:
    """Session with what it has sent."""

    def __init__(self) -> None:
        self.chip = FakeChip()
        self.out = bytearray()
        self.session = DebugSession(self.chip, self.out.extend)
        assert self.ask(b"QStartNoAckMode") == b"OK"

    def tell(self, payload: bytes) -> None:
        self.out.clear()
        self.session.received(packed(payload))

    def ask(self, payload: bytes) -> bytes:
        self.tell(payload)
        return self.answer()

    def answer(self) -> bytes:
        said = bytes(self.out).removeprefix(b"+")
        assert said[:1] == b"$"
        assert packed(said[1:-3]) == said
        return said[1:-3]

    def run(self) -> bytes:
        """Let the chip run until the session stops."""
        while self.chip.going:
            self.chip.run()
            self.session.stopped()
        return self.answer()


def stop(pc: int) -> bytes:
    return b"T05" + f"20:00;21:0000;22:{pc.to_bytes(4, 'little').hex()};thread:1;".encode()


def test_packets_are_acknowledged_until_gdb_wants_none() -> None:
    out = bytearray()
    session = DebugSession(FakeChip(), out.extend)
    session.received(b"+$qC#b4")
    assert bytes(out) == b"+$QC1#c5"
    out.clear()
    session.received(b"-$qC#00")
    assert bytes(out) == b"$QC1#c5-"
    out.clear()
    session.received(b"$QStart")
    session.received(b"NoAckMode#b0$qAttached#8f")
    assert bytes(out) == b"+$OK#9a$1#31"


def test_registers_are_read_and_set() -> None:
    gdb = Gdb()
    gdb.chip.memories[MemorySpace.DATA][:3] = b"\x01\x02\x03"
    gdb.chip.memories[MemorySpace.DATA][0x5D:0x60] = b"\xff\x08\x82"
    registers = bytes.fromhex(gdb.ask(b"g").decode())
    assert registers[:3] == b"\x01\x02\x03"
    assert registers[32:] == b"\x82\xff\x08\x00\x01\x00\x00"
    assert gdb.ask(b"p22") == b"00010000"
    assert gdb.ask(b"P21=cd04") == b"OK"
    assert gdb.ask(b"P22=24000000") == b"OK"
    assert gdb.chip.program_counter == 0x24
    assert gdb.ask(b"p21") == b"cd04"
    assert gdb.ask(b"G" + bytes(39).hex().encode()) == b"OK"
    assert gdb.ask(b"g") == bytes(39).hex().encode()


@pytest.mark.parametrize(
    ("packet", "answer"),
    [
        (b"m10,4", b"10111213"),
        (b"m8000fe,2", b"0000"),
        (b"m8008ff,4", b"00"),
        (b"m810000,1", b"00"),
        (b"m8010000,1", b"E01"),
        (b"m900000,4", b"E01"),
        (b"mzz,1", b"E01"),
        (b"M0,1:00", b"E01"),
        (b"M8008ff,2:0000", b"E01"),
        (b"M800100,2:00", b"E01"),
        (b"p23", b"E01"),
        (b"P21=cd", b"E01"),
        (b"Z2,800100,2", b""),
        (b"!", b""),
        (b"vMustReplyEmpty", b""),
        (b"Hg0", b"OK"),
        (b"T1", b"OK"),
        (b"qfThreadInfo", b"m1"),
        (b"qsThreadInfo", b"l"),
        (b"?", stop(0x100)),
        (b"qRcmd,74696d65", b"6379636c6520350a"),
        (b"vCont?", b"vCont;c;C;s;S;r"),
    ],
)
def test_answers(packet: bytes, answer: bytes) -> None:
    assert Gdb().ask(packet) == answer


def test_memory_is_written_as_digits_and_as_bytes() -> None:
    gdb = Gdb()
    assert gdb.ask(b"M800100,2:abcd") == b"OK"
    assert gdb.ask(b"X810001,3:" + b"#$}") == b"OK"
    assert gdb.ask(b"X800100,0:") == b"OK"
    assert gdb.chip.memories[MemorySpace.DATA][0x100:0x102] == b"\xab\xcd"
    assert gdb.chip.memories[MemorySpace.EEPROM][1:4] == b"#$}"


@pytest.mark.parametrize("packet", [b"c", b"vCont;c", b"C05", b"vCont;c:1"])
def test_it_runs_to_a_breakpoint(packet: bytes) -> None:
    gdb = Gdb()
    assert gdb.ask(b"Z0,10c,2") == b"OK"
    assert gdb.ask(b"Z1,108,2") == b"OK"
    assert gdb.ask(b"z1,108,2") == b"OK"
    gdb.tell(packet)
    assert not gdb.out
    assert gdb.run() == stop(0x10C)


@pytest.mark.parametrize("packet", [b"s", b"vCont;s:1", b"S05"])
def test_it_steps(packet: bytes) -> None:
    gdb = Gdb()
    gdb.tell(packet)
    assert gdb.run() == stop(0x102)


def test_it_steps_within_a_line() -> None:
    gdb = Gdb()
    gdb.tell(b"vCont;r100,108:1")
    assert gdb.run() == stop(0x108)
    gdb.ask(b"Z0,10c,2")
    gdb.tell(b"vCont;r108,110:1")
    assert gdb.run() == stop(0x10C)


def test_ctrl_c_halts_what_runs_and_nothing_else() -> None:
    gdb = Gdb()
    gdb.tell(b"c")
    gdb.session.received(b"\x03")
    assert gdb.answer() == stop(0x100).replace(b"T05", b"T02")
    assert gdb.chip.going is None
    gdb.out.clear()
    gdb.session.received(b"\x03")
    gdb.session.stopped()
    assert not gdb.out


@pytest.mark.parametrize(
    ("path", "end"),
    [
        ([0x40, 0x500, 0x502, 0x102, 0x104], 0x102),  # behind the instruction
        ([0x40, 0x500, 0x502, 0x100, 0x102], 0x102),  # before it
        ([0x40, 0x500, 0x502, 0x106], 0x502),  # with a breakpoint in its routine
    ],
)
def test_a_step_goes_over_an_interrupt(path: list[int], end: int) -> None:
    gdb = Gdb()
    gdb.chip.path = iter(path)
    back = path[3] // 2
    gdb.chip.memories[MemorySpace.DATA][0x5D:0x5F] = b"\x00\x08"
    gdb.chip.memories[MemorySpace.DATA][0x801:0x803] = back.to_bytes(2, "big")
    if end == 0x502:
        gdb.ask(b"Z0,502,2")
    gdb.tell(b"s")
    assert gdb.run().endswith(stop(end)[-21:])


def test_a_reset_from_elsewhere_is_told_while_it_runs() -> None:
    gdb = Gdb()
    gdb.session.was_reset()
    gdb.tell(b"c")
    gdb.session.was_reset(is_other_program=True)
    assert bytes.fromhex(gdb.answer()[1:].decode()) == (
        b"[hil: the chip was given another program: `file` reads its symbols]\n"
    )
    assert gdb.chip.going is not None


def test_monitor_reset_resets_the_chip() -> None:
    gdb = Gdb()
    gdb.ask(b"qRcmd," + b"reset halt".hex().encode())
    assert (gdb.chip.resets, gdb.chip.program_counter) == (1, 0)
    assert b"monitor reset: " in bytes.fromhex(gdb.ask(b"qRcmd," + b"help".hex().encode()).decode())


@pytest.mark.parametrize("packet", [b"D", b"k", b"vKill;1"])
def test_the_chip_runs_when_gdb_leaves(packet: bytes) -> None:
    gdb = Gdb()
    gdb.ask(b"Z0,10c,2")
    gdb.tell(packet)
    assert gdb.session.is_over
    assert gdb.chip.going == (frozenset(), False)
    gdb.out.clear()
    gdb.session.received(b"$c#63")
    gdb.session.close("late")
    assert not gdb.out


def test_a_session_that_is_closed_says_why_and_lets_the_chip_run() -> None:
    gdb = Gdb()
    gdb.tell(b"c")
    gdb.session.close("u1 is no more in the bench")
    assert bytes(gdb.out).startswith(b"$O" + b"[hil: u1 is no more in the bench]\n".hex().encode())
    assert b"$W00#" in gdb.out
    gdb = Gdb()
    gdb.session.close()
    assert gdb.chip.going == (frozenset(), False)


def test_noise_and_endless_packets_do_no_harm() -> None:
    gdb = Gdb()
    gdb.out.clear()
    gdb.session.received(b"\x00\xffnoise$" + b"x" * 20_000)
    assert gdb.ask(b"qC") == b"QC1"
