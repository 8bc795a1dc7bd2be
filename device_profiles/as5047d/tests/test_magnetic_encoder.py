"""Frames of an AS5047D, clocked by hand, and the shaft that its magnet is on."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from hil.testing import Bench
from hil.wire.step_dir import Edges

ANGLE, DIAAGC, ERRFL, MAG, NOP = 0xFFFF, 0xFFFC, 0x4001, 0x7FFD, 0xC000
"""Commands that read, with even parity."""
EF = 0x4000
HALF_ms = 0.0005
"""Half a clock of 1 MHz."""
Make = Callable[..., Bench]


@pytest.fixture
def make() -> Iterator[Make]:
    made: list[Bench] = []

    def bench(magnet: object = "d1", **keys: object) -> Bench:
        device: dict[str, Any] = {"profile": "as5047d", **keys}
        if magnet is not None:
            device["magnet"] = magnet
        devices = {"e1": device, "d1": {"profile": "easydriver", "axis": {"start_deg": 0.0}}}
        made.append(Bench({"bench": "t", "devices": devices}))
        made[0].run(ms=20)  # the motor comes to rest
        return made[0]

    yield bench
    for each in made:
        each.close()


def frame(bench: Bench, word: int, clocks: int = 16) -> int:
    """Send a frame, and answer what comes back; a bit is taken at the fall of CLK."""
    device, axis = bench.device("e1"), bench.runtime.devices["e1"].axis
    device.pin("CSn", 0)
    answer = 0
    for bit in reversed(range(clocks)):
        device.pin("MOSI", word >> bit & 1)
        device.pin("CLK", 1)
        bench.run(ms=HALF_ms)
        answer = answer << 1 | axis.output_levels()["MISO"]
        device.pin("CLK", 0)
        bench.run(ms=HALF_ms)
    device.pin("CSn", 1)
    return answer


def read(bench: Bench, command: int) -> int:
    """Read a register: its answer comes with the next frame."""
    frame(bench, command)
    return frame(bench, NOP)


def is_even(word: int) -> bool:
    return word.bit_count() % 2 == 0


def even(word: int) -> int:
    return word if is_even(word) else word | 0x8000


def angle_deg(bench: Bench) -> float:
    word = read(bench, ANGLE)
    assert is_even(word)
    assert not word & EF
    return (word & 0x3FFF) * 360 / 16384


def shaft_deg(bench: Bench) -> float:
    return bench.axis("d1").snapshot().position_deg % 360


def turn(bench: Bench, steps: int = 100) -> None:
    driver = bench.device("d1")
    for _ in range(steps):
        driver.drive([Edges(2000, "step", 1), Edges(4000, "step", 0)])
        bench.run(ms=0.5)
    bench.run(ms=50)


def test_it_reads_the_shaft_that_its_magnet_is_on(make: Make) -> None:
    bench = make()
    assert angle_deg(bench) == pytest.approx(shaft_deg(bench), abs=0.03)
    turn(bench)
    assert 20 < 360 - shaft_deg(bench) < 25
    assert angle_deg(bench) == pytest.approx(shaft_deg(bench), abs=0.03)


def test_the_angle_is_that_of_the_end_of_the_frame_before(make: Make) -> None:
    bench = make()
    frame(bench, ANGLE)
    before_deg = shaft_deg(bench)
    turn(bench)
    assert (frame(bench, NOP) & 0x3FFF) * 360 / 16384 == pytest.approx(before_deg, abs=0.03)


@pytest.mark.parametrize("zero_deg", [90.0, -30.0])
@pytest.mark.parametrize("is_reversed", [False, True])
def test_the_magnet_has_a_zero_and_a_direction(make: Make, zero_deg: float, is_reversed: bool) -> None:
    bench = make({"of": "d1", "zero_deg": zero_deg, "reversed": is_reversed})
    turn(bench)
    seen_deg = (shaft_deg(bench) - zero_deg) * (-1 if is_reversed else 1)
    assert angle_deg(bench) == pytest.approx(seen_deg % 360, abs=0.03)


def test_a_zero_that_is_told_moves_no_magnet(make: Make) -> None:
    bench = make()
    before_deg = angle_deg(bench)
    bench.axis("d1").zero()
    assert angle_deg(bench) == pytest.approx(before_deg, abs=0.03)


def test_without_a_magnet_the_field_is_too_weak(make: Make) -> None:
    bench = make(None)
    assert [read(bench, command) & 0x3FFF for command in (ANGLE, DIAAGC, MAG)] == [0, 0x09FF, 0]


def test_registers_begin_as_the_data_sheet_has_them(make: Make) -> None:
    bench = make()
    assert [read(bench, command) & 0x3FFF for command in (DIAAGC, ERRFL, NOP)] == [0x0180, 0, 0]
    bench.device("e1").set_register("diaagc", 0x0980)
    assert read(bench, DIAAGC) & 0x3FFF == 0x0980


@pytest.mark.parametrize(
    ("word", "clocks", "error"),
    [
        (ANGLE ^ 0x8000, 16, 4),
        (0xC004, 16, 4),
        (0x4004, 16, 2),
        (0x3FFF, 16, 2),
        (ANGLE, 15, 1),
        (ANGLE << 1, 17, 1),
    ],
)
def test_an_error_is_in_each_answer_until_it_is_read(make: Make, word: int, clocks: int, error: int) -> None:
    bench = make()
    frame(bench, word, clocks)
    assert frame(bench, ANGLE) & 0x7FFF == EF  # it was not carried out
    assert frame(bench, ERRFL) & EF
    assert frame(bench, NOP) & 0x7FFF == EF | error
    assert frame(bench, NOP) & EF == 0


def test_a_zero_position_can_be_written(make: Make) -> None:
    bench = make({"of": "d1", "zero_deg": -200.0})
    position = round(angle_deg(bench) * 16384 / 360)
    for register, content in ((0x0016, position >> 6), (0x0017, position & 0x3F)):
        frame(bench, even(register))
        assert frame(bench, even(content)) & 0x3FFF == 0
        assert frame(bench, NOP) & 0x3FFF == content
    assert angle_deg(bench) == pytest.approx(0, abs=0.05)


def test_the_direction_can_be_written(make: Make) -> None:
    bench = make({"of": "d1", "zero_deg": -200.0})
    before_deg = angle_deg(bench)
    frame(bench, even(0x0018))
    assert frame(bench, even(0x0005)) & 0x3FFF == 1
    assert angle_deg(bench) == pytest.approx(360 - before_deg, abs=0.05)


def test_a_node_that_is_not_selected_hears_nothing(make: Make) -> None:
    bench = make()
    device = bench.device("e1")
    for _ in range(16):
        device.pin("CLK", 1)
        device.pin("CLK", 0)
    assert bench.axis("e1").snapshot().spi_frames == 0
    assert bench.axis("e1").snapshot().errfl == 0


def test_faults_of_an_encoder_are_the_chips(make: Make) -> None:
    bench = make({"of": "d1", "zero_deg": -200.0})
    true_deg = angle_deg(bench)
    with bench.fault("encoder_slip", "e1", counts=1000):
        assert angle_deg(bench) == pytest.approx(true_deg + 1000 * 360 / 16384, abs=0.05)
    with bench.fault("encoder_disconnect", "e1"):
        assert read(bench, ANGLE) == 0xFFFF
    with bench.fault("encoder_freeze", "e1"):
        turn(bench)
        assert angle_deg(bench) == pytest.approx(true_deg, abs=0.05)
    assert angle_deg(bench) == pytest.approx((shaft_deg(bench) + 200) % 360, abs=0.05)
