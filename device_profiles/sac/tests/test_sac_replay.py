"""Log of a bench in memory, whose outputs are recorded and looked at, replays identically; the states, too,
of which the log has checksums."""

import io
from collections.abc import Callable, Mapping
from random import Random
from typing import Any

import pytest

from hil.sim.bench import BenchHooks
from hil.sim.input_log import InputLogWriter
from hil.sim.twin import Twin
from hil.testing import Bench, replay

TYPED = (
    *(
        b"+",
        b"-",
        b"+",
        b"-",
        b"+-",
        b"m5\r",
        b"m-20v300\r",
        b"mv60\r",
        b"S\r",
        b"s\r",
        b"xm3\r",
        b"y",
        b"l\r",
    ),
    *(b"$R\r", b"$O1\r", b"$CK200\r", b"$n\r", b"vd\r", b"q\r", b"qs\r", b"la\r", b"cf\r"),
)
WAITS_MS = (0.01, 0.3, 1.0, 5.0, 40.0, 300.0)
WIRES: tuple[list[dict[str, str]], ...] = (
    [],
    [],
    [{"from": "s1.clk", "to": "s2.EnA"}, {"from": "s1.OP_SA", "to": "s2.EnB"}],
    [{"from": "s2.clk", "to": "s1.Estop"}],
)


class LateStore:
    """Memory whose answers are inputs, as a daemon's are: they stand in the log."""

    def __init__(self) -> None:
        self._waiting: list[Callable[[bool], bool]] = []

    def commit(
        self, device: Twin, sections: Mapping[str, bytes], answered: Callable[[bool], bool]
    ) -> bool | None:
        self._waiting.append(answered)
        return None

    def answer(self) -> None:
        while self._waiting:
            self._waiting.pop(0)(True)


class PromptStore(LateStore):
    """Memory that answers within the turn, as the kit's own."""

    def commit(self, device: Twin, sections: Mapping[str, bytes], answered: Callable[[bool], bool]) -> bool:
        return True


@pytest.mark.parametrize("store", [LateStore(), PromptStore()], ids=["late", "prompt"])
@pytest.mark.parametrize("seed", range(8))
def test_what_was_typed_at_boards_whose_outputs_are_recorded(seed: int, store: LateStore) -> None:
    random = Random(seed)
    devices = {name: {"profile": "sac", "plant": random.choice(("simple", "full"))} for name in ("s1", "s2")}
    config: dict[str, Any] = {"bench": "typed", "devices": devices, "wires": random.choice(WIRES)}
    text = io.StringIO()
    with Bench(config, store=store, around=BenchHooks(log=InputLogWriter(text, "test", config, {}))) as bench:
        bench.run(1200)
        for _ in range(60):
            name = random.choice(list(devices))
            if random.random() < 0.03:
                bench.device(name).reset()
                bench.run(1200)
            bench.port(name).write(random.choice(TYPED))
            bench.run(random.choice(WAITS_MS) * random.random())
            store.answer()
            if random.random() < 0.3:
                bench.axis(name).snapshot()
                bench.device(name).pin("clk").edges()
    assert replay(text.getvalue().splitlines(keepends=True)).difference() is None


def test_a_single_pulse_is_as_high_as_it_is_long() -> None:
    config = {"bench": "pulse", "devices": {"s1": {"profile": "sac"}}}
    with Bench(config) as bench:
        bench.run(1200)
        bench.port("s1").write(b"+")
        bench.run(1)
        (rise_ns, _), (fall_ns, _) = bench.device("s1").pin("clk").edges()
        assert fall_ns - rise_ns == 30_000  # the factory's K
        bench.port("s1").write(b"+")
        bench.run(0.27)  # a character takes 0.26 ms
        assert bench.axis("s1").snapshot().pin_clk == 1
