"""A processor in a bench: its pins, its line, its faults, in the bench's time."""

from itertools import pairwise

import pytest
from avr_words import CONVERT, ECHO, KEEP, PWM_64_OF_256, RESULT, TOGGLE, burst

from hil.core import CoreAxis
from hil.core.abi import ProcessorMemory
from hil.core.core_processor import CoreProcessor
from hil.testing import Bench

CONFIG = {"bench": "one", "devices": {"u1": {"profile": "uno"}}}
NO_BOOT = 0xFF, 0xDF, 0xFD, 0xFF
"""Fuses and lock bits of a chip that starts at address 0."""
CYCLE_NS = 62.5
CHARACTER_NS = 85_000
"""Ten bits of 136 cycles at 16 MHz."""


def axis_of(bench: Bench, name: str = "u1") -> CoreAxis:
    return bench.runtime.devices[name].axis


def started(bench: Bench, flash: bytes, name: str = "u1") -> CoreProcessor:
    """Load a program, and start it, once the board's own sketch has started."""
    bench.run(50)
    processor = axis_of(bench, name).processor
    assert processor
    processor.set_fuses(*NO_BOOT)
    processor.load(0, flash)
    processor.reset(1)
    bench.port(name).read()
    return processor


def edges(bench: Bench, pin: str, ms: float) -> list[tuple[int, int]]:
    axis = axis_of(bench)
    axis.record_edges(True, [pin])
    bench.run(ms)
    taken = axis.take_edges()
    axis.record_edges(False)
    return [(at_ns, level) for at_ns, _, level in taken]


def test_edges_come_at_their_cycles() -> None:
    with Bench(CONFIG) as bench:
        started(bench, TOGGLE)
        begun_ns = bench.now_ns
        found = edges(bench, "D13", 1)
        # SBI DDRB and SBI PINB take two cycles each, RJMP two: a level each four.
        assert found[0] == (begun_ns + 4 * CYCLE_NS, 1)
        assert [later - at for (at, _), (later, _) in pairwise(found)] == [250] * 3999


@pytest.mark.parametrize("cuts", [[30], [1] * 30])
def test_a_chip_that_is_held_while_it_starts_up_stands_where_it_was(cuts: list[float]) -> None:
    with Bench(CONFIG) as bench:
        processor = started(bench, TOGGLE)
        begun = processor.cycles
        processor.reset(1, 1_056_398)
        for ms in cuts:
            bench.run(ms)
        processor.hold()
        assert processor.cycles - begun == 30 * 16_000


def test_it_does_not_matter_how_time_is_cut() -> None:
    def sent(cuts: list[float]) -> tuple[object, object]:
        with Bench(CONFIG) as bench:
            started(bench, ECHO)
            bench.run(1)
            bench.port("u1").write(b"hello")
            bench.run(0.3)
            bench.port("u1").write(b"world")
            for ms in cuts:
                bench.run(ms)
            return bench.port("u1").read_timed(), axis_of(bench).get("cycles")

    assert sent([5.0]) == sent([0.123456, 0.07, 0.000001, 1.0] + [0.01] * 100 + [2.806543])


def test_bytes_come_and_go_at_the_lines_speed() -> None:
    with Bench(CONFIG) as bench:
        started(bench, ECHO)
        bench.run(1)
        begun_ns = bench.now_ns
        bench.port("u1").write(b"Hello")
        bench.run(2)
        timed = bench.port("u1").read_timed()
        assert b"".join(data for _, data in timed) == b"Hello"
        # The last byte is there after 49.5 bits; the program sends it back within some instructions.
        last_ns = timed[-1][0] - begun_ns
        assert 4.95 * CHARACTER_NS < last_ns < 5.05 * CHARACTER_NS


def test_a_fast_clock_makes_all_of_it_fast() -> None:
    with Bench(CONFIG) as bench:
        started(bench, TOGGLE)
        fault = bench.fault("chip_clock_off", "u1", percent=10)
        assert len(edges(bench, "D13", 1)) == pytest.approx(4400, abs=2)
        fault.clear()
        assert len(edges(bench, "D13", 1)) == pytest.approx(4000, abs=2)


def test_a_stuck_pin_does_not_move() -> None:
    with Bench(CONFIG) as bench:
        started(bench, TOGGLE)
        with bench.fault("chip_pin_stuck", "u1", pin=13, level=1):
            bench.run(1)
            assert len(edges(bench, "D13", 1)) == 0
            assert axis_of(bench).output_levels()["D13"] == 1
        assert len(edges(bench, "D13", 1)) > 3000


def test_a_bit_flips_once() -> None:
    with Bench(CONFIG) as bench:
        processor = started(bench, TOGGLE)
        before = processor.flash
        bench.fault("chip_bit_flip", "u1", memory="flash", address=4, bit=0)
        assert processor.flash[4] == before[4] ^ 1
        bench.fault("chip_bit_flip", "u1", memory="sram", address=0x200, bit=7)
        assert processor.data(0x200, 1) == b"\x80"


@pytest.mark.parametrize(("kept_pct", "stay"), [(100, range(100, 101)), (50, range(30, 70)), (0, range(4))])
def test_sram_keeps_a_part_through_a_sag(kept_pct: int, stay: range) -> None:
    with Bench(CONFIG) as bench:
        processor = started(bench, TOGGLE)
        for address in range(0x100, 0x164):
            processor.poke(address, 0xA5)
        bench.fault("chip_brown_out", "u1", kept_pct=kept_pct, seed=1)
        assert processor.data(0x100, 100).count(0xA5) in stay
        assert edges(bench, "D13", 60) == []  # it starts up
        assert len(edges(bench, "D13", 20)) > 1000
        assert processor.data(0x54, 1) == b"\x05"  # BORF, and PORF from the start


@pytest.mark.parametrize("is_worn", [False, True])
def test_a_worn_eeprom_keeps_what_it_had(is_worn: bool) -> None:
    with Bench(CONFIG) as bench:
        bench.run(50)
        if is_worn:
            bench.fault("chip_eeprom_worn", "u1")
        processor = started(bench, KEEP)
        bench.run(10)
        assert processor.eeprom[3] == (0xFF if is_worn else 0x5A)


LINE = {
    "bench": "line",
    "devices": {"u1": {"profile": "uno"}, "u2": {"profile": "uno"}},
    "segments": {"bus0": {"stations": ["u1.main", "u2.main"], "taps": {"tap": {"port": "memory"}}}},
}


@pytest.mark.parametrize(
    ("driven_cycles", "heard"), [(None, b"\x55"), (2, b""), (300, b"\xff"), (680, b"\xf5")]
)
def test_a_driver_that_goes_off_early_cuts_the_byte(driven_cycles: int | None, heard: bytes) -> None:
    with Bench(LINE) as bench:
        for name, flash in (("u1", burst(driven_cycles)), ("u2", ECHO)):
            started_on_line(bench, name, flash)
        sender = axis_of(bench).processor
        assert sender
        sender.drives_line("D2")
        bench.run(5)
        bench.tap("bus0.tap").read()
        axis_of(bench).pin("D3", 1)
        bench.run(5)
        assert bench.tap("bus0.tap").read()[:1] == heard


def started_on_line(bench: Bench, name: str, flash: bytes) -> None:
    bench.run(50)
    processor = axis_of(bench, name).processor
    assert processor
    processor.set_fuses(*NO_BOOT)
    processor.load(0, flash)
    processor.reset(1)


def test_a_pwm_pin_has_a_mean_voltage() -> None:
    with Bench(CONFIG) as bench:
        started(bench, PWM_64_OF_256)
        bench.run(1)
        assert axis_of(bench).get("d6_V") == pytest.approx(5 * 64 / 256)
        axis_of(bench).set("vcc_V", 3.3)
        assert axis_of(bench).get("d6_V") == pytest.approx(3.3 * 64 / 256)


def test_a_converter_finds_a_voltage_that_follows_a_field() -> None:
    config = CONFIG | {
        "devices": {"u1": {"profile": "uno"}, "u2": {"profile": "uno"}},
        "wires": [{"from": "u2.D13", "to": "u1.D7"}],
    }
    with Bench(config) as bench:
        started(bench, CONVERT)
        started(bench, PWM_64_OF_256, "u2")
        processor = axis_of(bench).processor
        assert processor
        axis_of(bench).set("a0_V", 2.5)
        bench.run(2)
        assert int.from_bytes(processor.data(RESULT, 2), "little") == 512
        processor.measure(0, axis_of(bench, "u2").id, axis_of(bench, "u2").index("d6_V"), 0.5, 1.0)
        axis_of(bench).set("a0_V", 1.0)
        bench.run(2)
        assert int.from_bytes(processor.data(RESULT, 2), "little") == int((1.0 + 0.5 * 1.25) * 1024 / 5)


def test_memories_are_read_from_any_place_on() -> None:
    with Bench(CONFIG) as bench:
        processor = started(bench, bytes(range(64)))
        processor.hold()
        native, axis = axis_of(bench)._native, axis_of(bench).id
        assert native.processor_read(axis, ProcessorMemory.flash, 5, 4) == bytes((5, 6, 7, 8))
        assert native.processor_read(axis, ProcessorMemory.flash, 32_764, 4) == b"\xff" * 4


@pytest.mark.parametrize(
    ("low", "cycles"),
    [
        (0xFF, 16_384 + 14 + 1_040_000),  # crystal, slowly rising power
        (0xDF, 16_384 + 14),  # with brown-out detection
        (0xE2, 14 + 1_040_000),  # RC oscillator
        (0x62, 14 + 130_000),  # as it comes from the factory: its clock divided by 8
    ],
)
def test_fuses_say_how_long_it_takes_to_start(low: int, cycles: int) -> None:
    with Bench(CONFIG) as bench:
        processor = started(bench, TOGGLE)
        processor.set_fuses(low, 0xDE, 0xFD, 0xFF)
        assert processor.start_up_cycles == cycles


def test_a_reference_of_its_own_stays_when_the_supply_changes() -> None:
    with Bench(CONFIG) as bench:
        processor = started(
            bench, bytes(CONVERT).replace(bytes((0x00, 0xE4)), bytes((0x00, 0xE0)), 1)
        )  # AREF
        axis = axis_of(bench)
        axis.set("a0_V", 1.25)
        for supply_V, counted in ((5.0, 256), (2.5, 512)):
            axis.set("vcc_V", supply_V)
            bench.run(2)
            assert int.from_bytes(processor.data(RESULT, 2), "little") == counted
        axis._native.processor_supply(axis.id, 5.0, 2.5)
        axis.set("vcc_V", 3.3)
        bench.run(2)
        assert int.from_bytes(processor.data(RESULT, 2), "little") == 512
