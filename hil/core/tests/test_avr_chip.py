"""An ATmega328P by its data sheet (DS40002061): small programs, and what they see of the chip around them.

``avr_programs`` has them with their sources and ``build.sh``, which made them. What they keep is from 200h
on.
"""

import shutil
import subprocess
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import pytest

from hil.core._processor import WITHOUT_FRAMES, Processor

PROGRAMS = Path(__file__).parent / "avr_programs"
KEPT, GPIOR0, GPIOR1, ENDED = 0x200, 0x3E, 0x4A, 0xA5
TCNT1L, ICR1L = 0x84, 0x86
SBI_PIND_4 = bytes((0x4C, 0x9A))
NOTE_STACK = 2
ALL_PINS = (1 << 20) - 1
HIGH = 1
TO_BIT_9 = 64
"""Clocks of a bit that ``serial.S`` listens at."""
COMPILER = "5.4.0"

Edge = tuple[int, int, int]


def records(name: str) -> list[tuple[int, bytes]]:
    """Addresses and bytes of a program: what its Intel HEX has for data."""
    lines = [bytes.fromhex(line[1:]) for line in (PROGRAMS / f"{name}.hex").read_text().split()]
    return [(int.from_bytes(line[1:3], "big"), line[4:-1]) for line in lines if line[3] == 0]


def chip_with(name: str) -> Processor:
    chip = Processor()
    for at, data in records(name):
        chip.load(data, at)
    chip.reset()
    chip.watch(ALL_PINS | WITHOUT_FRAMES)
    return chip


def kept(chip: Processor, count: int) -> list[int]:
    return [chip.peek(KEPT + n) for n in range(count)]


def has_ended(chip: Processor) -> bool:
    return chip.peek(GPIOR0) == ENDED


def edges_of(chip: Processor, pin: int, until: int) -> list[tuple[int, int]]:
    """Cycles and levels of a pin's edges up to a cycle, with the one that made it an output."""
    events = chip.run(until)
    return [(cycle, drive) for cycle, kind, number, drive in events if kind == "pin" and number == pin]


def gaps(cycles: Sequence[int]) -> list[int]:
    return [later - earlier for earlier, later in pairwise(cycles)]


def joined(one: Processor, other: Processor, pins: tuple[int, ...], cycles: int) -> None:
    """Run two chips with some of their pins wired together."""
    for cycle in range(cycles):
        one.run(cycle)
        other.run(cycle)
        for driver, driven in ((one, other), (other, one)):
            for pin in pins:
                drive = driver.driven(pin)
                driven.pin(pin, drive if drive <= HIGH else -1)


def test_a_counter_reads_as_written_and_counts_on() -> None:
    chip = chip_with("counting")
    chip.run(2000)
    assert has_ended(chip)
    as_written, two_later, flags, count, wrapped, matched, low, compare, temp = kept(chip, 9)
    assert (as_written, two_later) == (10, 12)
    assert (flags, count) == (0, 25)  # a write of the compare value blocks the match: 15.7.2
    assert (wrapped & 0b011, matched & 0b011) == (0b001, 0b010)  # TOV at FFh alone, never at OCR0A
    assert (low, compare, temp) == (0x34, 0x56, 0x12)


def test_a_handler_raises_its_own_compare_value() -> None:
    edges = edges_of(chip_with("ramp"), 4, 20_000)[1:]
    assert gaps([cycle for cycle, _ in edges])[:5] == [8 * (100 + 10 * n) for n in range(1, 6)]


def test_fast_pwm_with_icr1_takes_compare_values_at_its_end() -> None:
    chip = chip_with("fast_pwm")
    events = [event for event in chip.run(1000) if event[1] == "pin"]
    pulses = [cycle for cycle, _, pin, _ in events if pin == 9][1:]
    marks = [cycle for cycle, _, pin, _ in events if pin == 4][1:]
    assert set(gaps(pulses[::2])) == {100}
    assert set(gaps(pulses)[::2]) == {50}  # OCR1A + 1
    assert len(marks) in (9, 10)  # once in each period, also that in which it is written
    assert chip.duty(9) == pytest.approx(0.5)


def test_phase_correct_pwm_at_its_ends_and_between() -> None:
    edges = edges_of(chip_with("phase_pwm"), 9, 2400)
    levels = [level for _, level in edges]
    assert levels[:3] == [0, 1, 0]  # OCR1A 0: low; at TOP: high; then PWM
    assert edges[1][0] > 621, "high before D4 told that OCR1A is at TOP"
    steady = [cycle for cycle, _ in edges[3:]]
    assert set(gaps(steady[::2])) == {100}  # 2 TOP
    assert set(gaps(steady)[::2]) == {40}  # 2 OCR1A


def test_one_instruction_runs_after_sei_and_reti() -> None:
    chip = chip_with("entering")
    chip.run(1000)
    assert has_ended(chip)
    assert kept(chip, 4) == [1, 1, 1, 2]


def test_ports_are_read_behind_a_synchroniser_and_toggled_by_pin() -> None:
    chip = chip_with("ports")
    chip.pin(8, 0)
    chip.run(1000)
    assert has_ended(chip)
    assert kept(chip, 8) == [0, 5, 7, 7, 4, 2, 0, 4]


def test_the_watchdog_interrupts_and_resets() -> None:
    chip = chip_with("watching")
    resets = [event for event in chip.run(3_000_000) if event[1] == "reset"]
    assert has_ended(chip)
    alone, control, barks, causes, after, off = kept(chip, 6)
    assert (alone, control, barks) == (0, 0x40, 4)
    assert (causes, after, off) == (0b1001, 0x08, 0)
    assert len(resets) == 1
    assert resets[0][0] == pytest.approx(5 * 256_000, abs=200)  # 16 ms each


def test_eeprom_writes_take_time_and_spm_waits_for_the_boot_section() -> None:
    chip = chip_with("memory")
    edges = edges_of(chip, 13, 100_000)
    assert has_ended(chip)
    assert kept(chip, 7) == [0, 2, 0x5A, 1, chip.flash[0], 0x1E, 0xDF]
    assert chip.eeprom[7] == 0x5A
    assert edges[-1][0] - edges[-2][0] == pytest.approx(16_000 * 3.4, abs=20)
    assert chip.flash[0x1000:0x1080] == b"\xff" * 0x80


def test_bytes_go_out_back_to_back_and_come_in_with_their_errors() -> None:
    chip = chip_with("serial")
    sent = [(cycle, bits) for cycle, kind, bits, _ in chip.run(400) if kind == "sent"]
    assert [chr(bits) for _, bits in sent] == ["a", "b"]  # the last before TXEN stays; with UDRE 0 none
    assert sent[1][0] - sent[0][0] == 10 * 8
    assert kept(chip, 3) == [0x22, 0x02, 0x62]
    assert chip.bit_cycles == TO_BIT_9
    for start, data, is_broken in ((500, 0x155, False), (1500, 0x0AA, False), (2500, 0x111, True)):
        assert chip.hear(start, data | 1 << 9, TO_BIT_9, 10, is_broken)
    chip.run(4000)
    assert has_ended(chip)
    heard = [tuple(kept(chip, 12)[n : n + 3]) for n in (3, 6, 9)]
    told = [(status & 0x1C, control & 2, byte) for status, control, byte in heard]
    assert told == [(0, 2, 0x55), (0x04, 0, 0xAA), (0x10, 2, 0x11)]


@pytest.mark.parametrize(("percent", "is_heard"), [(-2, True), (2, True), (-12, False), (12, False)])
def test_a_sender_at_another_rate_is_understood_or_not(percent: int, is_heard: bool) -> None:
    chip = chip_with("serial")
    chip.run(400)
    bit_cycles = TO_BIT_9 * (1 + percent / 100)
    for n in range(3):
        assert chip.hear(500 + 1500 * n, 0x155 | 1 << 9, bit_cycles, 10)
    chip.run(6000)
    heard = [tuple(kept(chip, 12)[n : n + 3]) for n in (3, 6, 9)]
    assert ([(a & 0x1C, b & 2, byte) for a, b, byte in heard] == [(0, 2, 0x55)] * 3) == is_heard


def test_a_wire_is_heard_as_a_character_is() -> None:
    chip = chip_with("serial")
    chip.run(400)
    for start in (500, 1500, 2500):
        bits = 0x155 | 1 << 9
        for number, level in enumerate([0, *(bits >> n & 1 for n in range(10)), 1]):
            chip.run(start + TO_BIT_9 * number)
            chip.pin(0, level)
    chip.run(4000)
    assert has_ended(chip)
    assert [kept(chip, 12)[n] for n in (5, 8, 11)] == [0x55] * 3


def test_sleep_starts_a_conversion_and_free_running_ones_follow() -> None:
    chip = chip_with("converting")
    chip.volts(0, 3.0)
    edges = edges_of(chip, 4, 10_000)
    assert kept(chip, 4) == [614 & 0xFF, 614 >> 8, 614 << 6 & 0xFF, 614 >> 2]
    between = gaps([cycle for cycle, _ in edges[4:]])
    assert sum(between) / len(between) == pytest.approx(13 * 8, abs=0.1)
    assert set(between) <= {103, 104, 105}


def test_pins_outside_interrupt_count_and_capture() -> None:
    chip = chip_with("outside")
    for pin in (4, 5, 8, 9):
        chip.pin(pin, 0)
    for cycle, pin, level in ((100, 2, 0), (150, 2, 1), (200, 4, 1)):
        chip.run(cycle)
        chip.pin(pin, level)
    for n in range(5):
        chip.run(250 + 40 * n)
        chip.pin(5, 1)
        chip.run(270 + 40 * n)
        chip.pin(5, 0)
    chip.run(470)
    chip.pin(9, 1)
    (counting,) = [cycle for cycle, drive in edges_of(chip, 7, 800) if drive == HIGH]
    for cycle, level in ((800, 1), (803, 0), (850, 1)):  # three samples are too few for the noise canceller
        chip.run(cycle)
        chip.pin(8, level)
    chip.run(1000)
    assert has_ended(chip)
    by_level, by_change, edges, low, high = kept(chip, 5)
    assert (by_level, by_change, edges) == (1, 1, 5)
    assert low + 256 * high == 850 + 3 + 4 - (
        counting - 4
    )  # synchroniser and canceller; SBIs since it counts


def test_a_two_wire_master_alone_gets_no_answer() -> None:
    chip = chip_with("two_wires")
    chip.run(2000)
    assert has_ended(chip)
    assert kept(chip, 3) == [0xF8, 0x08, 0x20]


def test_a_two_wire_master_waits_while_a_line_is_held_low() -> None:
    chip = chip_with("two_wires")
    chip.pin(18, 0)
    chip.run(50_000)
    assert not has_ended(chip)
    assert kept(chip, 1) == [0xF8]


def test_a_two_wire_master_and_a_slave() -> None:
    master, slave = chip_with("two_wires"), chip_with("two_wires_slave")
    joined(master, slave, (18, 19), 6000)
    assert has_ended(master)
    assert kept(master, 10) == [0xF8, 0x08, 0x18, 0x28, 0x10, 0x40, 0x50, 0x32, 0x58, 0x33]
    statuses, data = kept(slave, 12)[::2], kept(slave, 12)[1::2]
    assert statuses == [0x60, 0x80, 0xA0, 0xA8, 0xB8, 0xC0]
    assert data[1] == 0xC5


@pytest.mark.parametrize("mode", [0, 4, 8, 12, 0x20, 0x24])
def test_a_byte_goes_both_ways_between_two_chips(mode: int) -> None:
    """Modes 0 to 3 by CPOL and CPHA, and DORD."""
    master, slave = chip_with("spi_master"), chip_with("spi_slave")
    for chip in (master, slave):
        chip.poke(GPIOR1, mode)
    joined(master, slave, (10, 11, 12, 13), 1200)
    assert has_ended(master)
    assert has_ended(slave)
    assert kept(master, 3) == [0x40, 0x93, 0]  # WCOL, the byte, and SPIF is gone with its reading
    assert kept(slave, 1) == [0xC5]


@pytest.mark.parametrize("name", ["ramp", "fast_pwm", "converting"])
def test_a_copy_goes_on_as_the_chip_does(name: str) -> None:
    chip = chip_with(name)
    chip.volts(1, 2.0)
    chip.run(3333)
    copy = chip.copy()
    first = chip.run(9999)
    assert first
    chip.restore(copy)
    assert chip.run(9999) == first


def test_a_copy_of_another_length_is_refused() -> None:
    with pytest.raises(ValueError, match="a copy of a processor has"):
        Processor().restore(b"123")


def test_it_stands_before_a_breakpoint_and_goes_on() -> None:
    chip, free = chip_with("ramp"), chip_with("ramp")
    (start,) = [at for at in range(0, 0x100, 2) if chip.flash[at : at + 2] == SBI_PIND_4]
    chip.break_at(start)
    halts = []
    while chip.cycles < 5000:
        chip.run(5000)
        if chip.is_at_break:
            halts.append(chip.begins)
            assert chip.registers()["pc"] == start
    toggles = [cycle for cycle, _ in edges_of(free, 4, 5000)][1:]
    assert halts == [cycle - 2 for cycle in toggles]  # SBI takes two clocks
    chip.break_at(start, is_on=False)
    assert chip.run(9000) == free.run(9000)


def test_the_lowest_stack_is_kept_and_told() -> None:
    chip = chip_with("entering")
    chip.stack_floor(0x8FF)
    told = [(number, value) for _, kind, number, value in chip.run(1000) if kind == "note"]
    assert told == [(NOTE_STACK, 0x8FE)]
    assert chip.stack_lowest == 0x8FE


def test_timers_stand_still_in_power_down_and_while_the_crystal_starts_up() -> None:
    """TCCR1B = 1, SMCR = 5, EIMSK = 1, SEI, SLEEP: D2 wakes it by its level."""
    words = (0xE001, 0x9300, 0x0081, 0xE005, 0xBF03, 0xE001, 0xBB0D, 0x9478, 0x9588, 0xCFFF)
    chip = Processor()
    chip.load(b"".join(word.to_bytes(2, "little") for word in words))
    chip.reset()
    chip.pin(2, 1)
    chip.run(100)
    assert chip.is_asleep
    count = chip.peek(TCNT1L)
    assert count < 10
    chip.pin(2, 0)
    chip.run(5000)
    assert not chip.is_asleep
    chip.pin(8, 1)  # an edge at ICP1
    chip.run(100 + 3 + 16_384)
    assert chip.peek(TCNT1L) == count
    chip.run(chip.cycles + 4)
    assert chip.peek(TCNT1L) == count + 4


def test_a_frame_stands_still_in_power_down() -> None:
    """UBRR0 = 16, U2X, TXEN, UDR0 = 55h, SMCR = 5, SLEEP."""
    sends = (0xE100, 0x9300, 0x00C4, 0xE002, 0x9300, 0x00C0, 0xE008, 0x9300, 0x00C1, 0xE505, 0x9300, 0x00C6)
    chip = Processor()
    chip.load(b"".join(word.to_bytes(2, "little") for word in (*sends, 0xE005, 0xBF03, 0x9588, 0xCFFF)))
    chip.reset()
    chip.watch(ALL_PINS)
    assert [kind for _, kind, _, _ in chip.run(1000)][-3:] == ["line", "sent", "note"]  # asleep for good
    assert chip.is_asleep
    assert chip.run(20_000) == []


@pytest.mark.parametrize("begins", range(22))
def test_a_match_while_a_handler_is_entered_is_kept(begins: int) -> None:
    """Flags go where the entry begins, at clock 32; the timer counts until 42, and matches each 23."""
    chip = chip_with("matching")
    chip.poke(GPIOR1, begins)
    chip.run(2000)
    assert has_ended(chip)
    second = 46 - begins
    assert kept(chip, 2) == [2 if 32 < second <= 42 else 1, 1]


def test_a_look_at_a_wide_register_shows_its_bytes_not_temp() -> None:
    chip = chip_with("counting")
    chip.run(2000)
    chip.peek(ICR1L)
    assert [chip.peek(TCNT1L), chip.peek(TCNT1L + 1)] == [0x34, 0x12]


def test_the_programs_are_what_their_sources_make(tmp_path: Path) -> None:
    if not (compiler := shutil.which("avr-gcc")):
        pytest.skip("avr-gcc is not installed: sudo apt install gcc-avr avr-libc")
    said = subprocess.run([compiler, "-dumpversion"], capture_output=True, text=True, check=True)
    version = said.stdout.strip()
    if version != COMPILER:
        pytest.skip(f"avr-gcc is {version}, and the programs were made with {COMPILER}")
    subprocess.run(["sh", PROGRAMS / "build.sh", tmp_path], check=True)
    made = {path.name: path.read_bytes() for path in tmp_path.glob("*.hex")}
    assert made == {path.name: path.read_bytes() for path in PROGRAMS.glob("*.hex")}
    assert len(made) == len(list(PROGRAMS.glob("*.S")))
