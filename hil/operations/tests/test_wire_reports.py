"""A bus that hil does not have: its wires are in status, metrics and health."""

from collections.abc import Iterator, Mapping, Sequence
from types import SimpleNamespace
from typing import Any

from hil.discovery.named_kinds import find_wire_infos
from hil.live.places import Places
from hil.operations.health import problem_kinds
from hil.operations.metrics import metric_rows
from hil.operations.wire_reports import listed_wires, wire_problems
from hil.sim.bench import BenchRuntime
from hil.testing import Bench
from hil.vocab.monitoring import HealthProblem
from hil.vocab.wire import Report, WireInfo, WireTap, one_of

REPORTS = WireInfo(
    "circles",
    "ring",
    lambda reports: (),
    (one_of("hil_ring_turns_total", "counter", "turns", "ring", lambda told: told["turns"]),),
    (("ring", "a ring is open"),),
)


class Ring:
    """Wire that goes round."""

    kind, name = "rings", "r"

    def counters(self, elapsed_ns: int) -> dict[str, Any]:
        return {"ring": self.name, "turns": 3}

    def report(self, elapsed_ns: int, taps: Sequence[WireTap], cards: Mapping[str, Any]) -> Report:
        return self.counters(elapsed_ns) | {"notes": [], "taps": len(taps)}

    def problems(self, taps: Sequence[WireTap]) -> Iterator[HealthProblem]:
        yield HealthProblem("ring", self.name, "it is open", "close it")


def ringed(bench: Bench) -> BenchRuntime:
    sim, ring = bench._runtime, Ring()
    sim.parts.add_wire("r", ring, sim.parts.group_of("m1"))  # type: ignore[arg-type]
    return sim


def test_a_wire_of_any_bus_is_told() -> None:
    kinds = {**find_wire_infos(), "rings": REPORTS}
    with Bench({"bench": "t", "devices": {"m1": {"profile": "mechaduino"}}}) as bench:
        sim, places = ringed(bench), Places()
        assert listed_wires(sim, places, "rings") == [{"ring": "r", "turns": 3, "notes": [], "taps": 0}]
        assert [problem.about for problem in wire_problems(sim, places)] == ["r"]
        assert problem_kinds(kinds)["ring"] == "a ring is open"
        scrape: Any = SimpleNamespace(of=SimpleNamespace(sim=sim))
        (row,) = (row for row in metric_rows(kinds) if row.metric.name == "hil_ring_turns_total")
        assert list(row.read(scrape)) == [(("r",), 3)]
