"""A station that babbles: when each burst begins, with which bytes, and that nothing is drawn for nothing."""

from typing import Any

import pytest

from hil.testing import Bench
from hil.wire.byte_faults import Chance
from hil.wire.serial_line import character_ns

CONFIG: dict[str, Any] = {
    "bench": "f",
    "devices": {"s1": {"profile": "sac"}},
    "segments": {"bus0": {"stations": ["s1"], "taps": {"a": {"port": "memory"}, "b": {"port": "memory"}}}},
}
BAUD = 38400
MS = 1_000_000


def seeded(seed: int, count: int) -> bytes:
    chance = Chance(seed)
    return bytes(chance.bits() & 0xFF for _ in range(count))


@pytest.mark.parametrize(("every_ms", "size"), [(40.0, 20), (5.0, 50), (0.1, 1)])
def test_when_it_speaks_and_what(every_ms: float, size: int) -> None:
    """A burst begins a period after the one before, or when that is out if it takes longer."""
    bench = Bench(CONFIG)
    bench.fault("node_babble", "bus0.a", bytes=size, every_ms=every_ms, seed=3)
    bench.run(ms=500)
    heard = bench.tap("bus0.b").read()
    period_ns = max(round(every_ms * MS), character_ns(size, BAUD))
    bursts = bench.segment("bus0").counters(1)["stations"]["bus0.a"]["bursts"]
    assert bursts == -(-500 * MS // period_ns)
    complete = (500 * MS - character_ns(size, BAUD)) // period_ns + 1
    assert heard[: size * complete] == seeded(3, size * complete)


def test_what_is_longer_than_its_period_costs_what_is_on_the_line(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = []
    bits = Chance.bits
    monkeypatch.setattr(Chance, "bits", lambda self: drawn.append(1) or bits(self))
    bench = Bench(CONFIG)
    for tap in ("a", "b"):
        bench.fault("node_babble", f"bus0.{tap}", bytes=1000, every_ms=0.1)
    bench.run(ms=1000)
    assert len(drawn) <= 2 * (BAUD / 10 + 1000)
