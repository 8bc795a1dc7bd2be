"""Processors that are wired: to each other, and to a driver with a motor."""

from itertools import pairwise

import pytest
from avr_words import DDRD, NOP, PIND, PORTD, TOGGLE, cbi, program, rjmp, sbi, sbis
from test_processor import axis_of, started_on_line

from hil.testing import Bench

SLOW_NOPS = 400
"""Between the steps of a motor: a pulse each 1,604 cycles, 100 us."""
COPY = program(sbi(DDRD, 4), sbis(PIND, 3), rjmp(2), sbi(PORTD, 4), rjmp(-4), cbi(PORTD, 4), rjmp(-6))
"""D4 follows D3."""
SQUARE = program(
    sbi(DDRD, 6),
    *(sbi(PORTD, 6), *[NOP] * SLOW_NOPS, cbi(PORTD, 6), *[NOP] * SLOW_NOPS, rjmp(-2 * SLOW_NOPS - 3)),
)
"""A square at D6."""
TWO = {
    "bench": "two",
    "devices": {"u1": {"profile": "uno"}, "u2": {"profile": "uno"}},
    "wires": [{"from": "u1.D6", "to": "u2.D3"}, {"from": "u2.D4", "to": "u1.D5"}],
}


def edges_of_two(cuts_ms: list[float]) -> tuple[list[tuple[int, str, int]], ...]:
    with Bench(TWO) as bench:
        started_on_line(bench, "u1", SQUARE)
        started_on_line(bench, "u2", COPY)
        for name in ("u1", "u2"):
            axis_of(bench, name).record_edges(True, ["D6", "D4"])
        for ms in cuts_ms:
            bench.run(ms)
        return tuple(axis_of(bench, name).take_edges() for name in ("u1", "u2"))


def test_one_follows_the_other_within_a_few_cycles() -> None:
    sent, followed = edges_of_two([2.0])
    assert len(sent) in range(78, 82)
    assert len(followed) in range(len(sent) - 1, len(sent) + 1)
    delays_ns = [late - at for (at, _, _), (late, _, _) in zip(sent, followed, strict=False)]
    # The synchroniser takes up to 1.5 cycles, a round of the loop up to 8, the change of the pin 2.
    assert all(6 * 62.5 <= delay_ns <= 12 * 62.5 for delay_ns in delays_ns)


def test_it_does_not_matter_how_their_time_is_cut() -> None:
    assert edges_of_two([2.0]) == edges_of_two([0.3, 0.000777, *[0.05] * 30, 0.199223])


@pytest.mark.parametrize("edges_Hz", [10_000])
def test_a_motor_turns_by_the_steps_of_a_program(edges_Hz: int) -> None:
    config = {
        "bench": "motor",
        "devices": {"u1": {"profile": "uno"}, "e1": {"profile": "easydriver"}},
        "wires": [{"from": "u1.D6", "to": "e1.step"}],
    }
    with Bench(config) as bench:
        started_on_line(bench, "u1", SQUARE)
        motor = axis_of(bench, "e1")
        before_deg = motor.get("commanded_deg")
        bench.run(100)
        # Each rise is a step of an eighth of 1.8 deg; high and low last 100 us / 2 and a few cycles.
        steps = round((motor.get("commanded_deg") - before_deg) / (1.8 / 8))
        assert abs(steps) in range(edges_Hz // 10 * 2 - 20, edges_Hz // 10 * 2 + 1)


def test_a_fast_program_makes_each_of_its_edges() -> None:
    with Bench(TWO) as bench:
        started_on_line(bench, "u1", TOGGLE)
        axis = axis_of(bench)
        axis.record_edges(True, ["D13"])
        bench.run(1)
        times_ns = [at_ns for at_ns, _, _ in axis.take_edges()]
        assert {later - at for at, later in pairwise(times_ns)} == {250}
