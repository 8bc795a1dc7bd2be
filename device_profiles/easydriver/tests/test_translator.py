"""Pins of the EasyDriver: its translator, and the timing of the A3967's data sheet."""

import math
from collections.abc import Iterator

import pytest

from hil.testing import Bench
from hil.testing.faces import DeviceFace
from hil.wire.step_dir import Edges

EIGHTHS = {(0, 0): 8, (1, 0): 4, (0, 1): 2, (1, 1): 1}
"""Eighths of a full step in a step, by MS1 and MS2: table 1 of the data sheet."""
CURRENT_A = 0.3


@pytest.fixture
def bench() -> Iterator[Bench]:
    driver = {"profile": "easydriver", "axis": {"phase_current_A": CURRENT_A}}
    with Bench({"bench": "t", "devices": {"d1": driver}}) as made:
        made.run(ms=20)
        yield made


def driver(bench: Bench) -> DeviceFace:
    return bench.device("d1")


def field(bench: Bench, name: str) -> float:
    return bench.axis("d1").snapshot().as_dict()[name]


def edges(bench: Bench, *rows: tuple[int, str, int]) -> None:
    """Drive pins at times in nanoseconds from now, and wait."""
    driver(bench).drive([Edges(at_ns, pin, level) for at_ns, pin, level in rows])
    bench.run(ms=1)


def pulse(bench: Bench, high_ns: int = 2000, low_ns: int = 2000) -> None:
    edges(bench, (low_ns, "step", 1), (low_ns + high_ns, "step", 0))


def settled(bench: Bench) -> tuple[float, float]:
    """Currents of both coils, once they have come to rest."""
    bench.run(ms=20)
    shot = bench.axis("d1").snapshot()
    return shot.current_a_A, shot.current_b_A


def test_it_begins_at_home_with_eighth_steps(bench: Bench) -> None:
    shot = bench.axis("d1").snapshot()
    assert (shot.microsteps, shot.translator, shot.outputs_on) == (8, 4, 1)
    assert [abs(current) for current in settled(bench)] == pytest.approx([CURRENT_A * math.sqrt(0.5)] * 2)
    assert shot.position_deg == pytest.approx(0.9, abs=0.2)


@pytest.mark.parametrize("mode", EIGHTHS)
def test_a_step_is_as_long_as_ms1_and_ms2_say(bench: Bench, mode: tuple[int, int]) -> None:
    driver(bench).pin("MS1", mode[0])
    driver(bench).pin("MS2", mode[1])
    driver(bench).pin("dir", 1)
    seen = []
    for _ in range(4 * 8 // EIGHTHS[mode]):
        bench.run(ms=1)
        pulse(bench)
        seen.append(field(bench, "translator"))
        angle = 2 * math.pi * field(bench, "translator") / 32
        expected = (-CURRENT_A * math.sin(angle), CURRENT_A * math.cos(angle))
        assert settled(bench) == pytest.approx(expected, abs=1e-6)
    places = [(4 + EIGHTHS[mode] * (k + 1)) % 32 for k in range(len(seen))]
    assert seen == places
    assert field(bench, "microsteps") == 8 // EIGHTHS[mode]
    assert field(bench, "commanded_deg") == pytest.approx(0.9 + 7.2)


def test_the_direction_pin_turns_the_way_round(bench: Bench) -> None:
    for level, angle_deg in ((1, 0.9 + 0.225), (0, 0.9), (0, 0.9 - 0.225)):
        driver(bench).pin("dir", level)
        bench.run(ms=1)
        pulse(bench)
        assert field(bench, "commanded_deg") == pytest.approx(angle_deg)
    assert field(bench, "steps_taken") == -1


@pytest.mark.parametrize(("start", "direction", "end"), [(5, 1, 12), (5, 0, 4), (4, 1, 12), (4, 0, 28)])
def test_a_coarser_mode_goes_on_at_its_own_places(bench: Bench, start: int, direction: int, end: int) -> None:
    driver(bench).pin("dir", 1)
    for _ in range(start - 4):
        bench.run(ms=1)
        pulse(bench)
    for pin in ("MS1", "MS2"):
        driver(bench).pin(pin, 0)
    driver(bench).pin("dir", direction)
    bench.run(ms=1)
    pulse(bench)
    assert field(bench, "translator") == end


@pytest.mark.parametrize(
    ("high_ns", "low_ns", "steps"), [(1000, 1000, 3), (999, 5000, 0), (5000, 999, 1), (500_000, 1000, 3)]
)
def test_pulses_and_pauses_take_a_microsecond_at_least(
    bench: Bench, high_ns: int, low_ns: int, steps: int
) -> None:
    driver(bench).pin("dir", 1)
    bench.run(ms=1)
    at_ns = [5000 + k * (high_ns + low_ns) for k in range(3)]
    rows = [edge for rise in at_ns for edge in ((rise, "step", 1), (rise + high_ns, "step", 0))]
    edges(bench, *rows)
    bench.run(ms=5)
    shot = bench.axis("d1").snapshot()
    assert (shot.steps_taken, shot.pulses_ignored) == (steps, 3 - steps)
    assert shot.commanded_deg == pytest.approx(0.9 + 0.225 * steps)
    assert (shot.timing_errors > 0) == (steps < 3)


@pytest.mark.parametrize("pin", ["dir", "MS1", "MS2"])
@pytest.mark.parametrize(("after_ns", "errors"), [(-200, 0), (-199, 1), (0, 1), (199, 1), (200, 0)])
def test_direction_and_mode_stand_still_around_a_step(
    bench: Bench, pin: str, after_ns: int, errors: int
) -> None:
    level = 0 if pin.startswith("MS") else 1
    change, rise = (5000 + after_ns, pin, level), (5000, "step", 1)
    rows = [rise, change] if after_ns > 0 else [change, rise]
    edges(bench, *rows, (9000, "step", 0))
    assert (field(bench, "timing_errors"), field(bench, "steps_taken") != 0) == (errors, True)


@pytest.mark.parametrize(("after_ns", "errors"), [(-200, 0), (-199, 1), (199, 1), (200, 0)])
def test_reset_stands_still_around_a_step(bench: Bench, after_ns: int, errors: int) -> None:
    driver(bench).pin("reset", int(after_ns > 0))
    bench.run(ms=1)
    change, rise = (5000 + after_ns, "reset", int(after_ns < 0)), (5000, "step", 1)
    rows = [rise, change] if after_ns > 0 else [change, rise]
    edges(bench, *rows, (9000, "step", 0))
    assert (field(bench, "timing_errors"), field(bench, "steps_taken")) == (errors, -1)


def test_reset_goes_home_and_takes_the_current_off(bench: Bench) -> None:
    driver(bench).pin("dir", 1)
    for _ in range(3):
        bench.run(ms=1)
        pulse(bench)
    driver(bench).pin("reset", 0)
    assert settled(bench) == pytest.approx((0.0, 0.0))
    pulse(bench)
    shot = bench.axis("d1").snapshot()
    assert (shot.translator, shot.pulses_ignored, shot.outputs_on) == (4, 1, 0)
    driver(bench).pin("reset", 1)
    bench.run(ms=1)
    pulse(bench)
    assert (field(bench, "translator"), field(bench, "outputs_on")) == (5, 1)


@pytest.mark.parametrize(("after_ns", "is_heard"), [(999_999, False), (1_000_000, True)])
def test_after_sleep_it_hears_steps_in_a_millisecond(bench: Bench, after_ns: int, is_heard: bool) -> None:
    driver(bench).pin("sleep", 0)
    bench.run(ms=5)
    assert settled(bench) == pytest.approx((0.0, 0.0))
    edges(bench, (0, "sleep", 1), (after_ns, "step", 1), (after_ns + 5000, "step", 0))
    bench.run(ms=5)
    assert field(bench, "pulses_ignored") == (0 if is_heard else 1)
    assert abs(field(bench, "steps_taken")) == (1 if is_heard else 0)


def test_it_counts_steps_while_its_outputs_are_off(bench: Bench) -> None:
    driver(bench).pin("dir", 1)
    driver(bench).pin("enable", 1)
    assert settled(bench) == pytest.approx((0.0, 0.0))
    pulse(bench)
    assert (field(bench, "translator"), field(bench, "outputs_on")) == (5, 0)
    driver(bench).pin("enable", 0)
    assert settled(bench) == pytest.approx(
        (-CURRENT_A * math.sin(5 * math.pi / 16), CURRENT_A * math.cos(5 * math.pi / 16)), abs=1e-6
    )


def test_a_reset_of_the_board_begins_at_home(bench: Bench) -> None:
    driver(bench).pin("dir", 1)
    bench.run(ms=1)
    pulse(bench)
    driver(bench).reset()
    bench.run(ms=20)
    shot = bench.axis("d1").snapshot()
    assert (shot.translator, shot.steps_taken, shot.pin_dir) == (4, 0, 1)
