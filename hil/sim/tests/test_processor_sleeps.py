"""A processor that sleeps, and what wakes it: it goes on from then, not from where it fell asleep."""

import pytest
from avr_words import DDRB, NOP, PINB, ldi, out, program, rjmp, sbi, sts
from test_processor import axis_of, started

from hil.testing import Bench

PCICR, PCMSK2, SMCR = 0x68, 0x6D, 0x33
"""Addresses of registers; SMCR's is of I/O."""
SEI, SLEEP, RETI = (0x9478,), (0x9588,), (0x9518,)
VECTOR = 0x0A
"""Word of PCINT2's vector. Source: DS40002061, 16.4."""
IDLE, POWER_DOWN = 0x01, 0x05
START_UP_ms = 16384 / 16000
"""Clocks of a Uno's crystal after power-down."""


def sleeper(mode: int) -> bytes:
    """Program that sleeps until D3 changes, and then changes D13."""
    main = [ldi(16, 1 << 3), sts(PCMSK2, 16), ldi(16, 1 << 2), sts(PCICR, 16), ldi(16, mode), out(SMCR, 16)]
    main += [SEI, sbi(DDRB, 5), SLEEP, sbi(PINB, 5), rjmp(-3)]
    return program(rjmp(VECTOR), *[NOP] * (VECTOR - 1), RETI, *main)


@pytest.mark.parametrize(("mode", "late_ms"), [(IDLE, 0.0), (POWER_DOWN, START_UP_ms)])
@pytest.mark.parametrize("asleep_ms", [0.05, 10.0, 500.0])
def test_a_pin_wakes_it_at_its_time(mode: int, late_ms: float, asleep_ms: float) -> None:
    with Bench({"bench": "b", "devices": {"u1": {"profile": "uno"}}}) as bench:
        started(bench, sleeper(mode))
        axis = axis_of(bench)
        axis.record_edges(True, ["D13"])
        begun_ns = bench.now_ns
        for level in (1, 0):
            bench.run(asleep_ms)
            bench.device("u1").pin("D3", level)
        bench.run(asleep_ms + 2)
        times_ms = [(at_ns - begun_ns) / 1e6 for at_ns, _, _ in axis.take_edges()]
        expected_ms = [asleep_ms + late_ms, 2 * asleep_ms + late_ms][: 1 if late_ms > asleep_ms else 2]
        assert times_ms == pytest.approx(expected_ms, abs=0.003)


def test_a_wire_wakes_it_at_its_time() -> None:
    devices = {"u1": {"profile": "uno"}, "u2": {"profile": "uno"}}
    config = {"bench": "b", "devices": devices, "wires": [{"from": "u2.D6", "to": "u1.D3"}]}
    with Bench(config) as bench:
        started(bench, sleeper(IDLE))
        sender = axis_of(bench, "u2")
        axis_of(bench).record_edges(True, ["D13"])
        bench.run(7)
        at_ns = bench.now_ns
        sender.write("D6", 1)
        bench.run(1)
        assert [told - at_ns for told, _, _ in axis_of(bench).take_edges()] == [pytest.approx(1000, abs=2000)]


def test_a_clock_that_is_off_leaves_its_time() -> None:
    with Bench({"bench": "b", "devices": {"u1": {"profile": "uno"}}}) as bench:
        processor = started(bench, sleeper(IDLE))
        bench.run(100)
        bench.fault("chip_clock_off", "u1", percent=10.0)
        bench.run(1)
        assert processor.cycles in range(16_000 * 100, 16_000 * 102)
