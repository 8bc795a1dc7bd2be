"""What the axes of a bench tell a run of the verbs that it has given them."""

from collections.abc import Mapping

import pytest

from hil.runs import BenchAxes
from hil.sim.inputs import Do
from hil.telemetry import Sampler
from hil.testing import Bench
from hil.vocab.time import ms
from hil.vocab.verbs import Verb, VerbRefused

SOON_MS, NOW_MS = 100, 4500


def test_a_verb_that_could_not_be_done_at_its_time_is_told() -> None:
    with Bench({"bench": "t", "devices": {"m1": {"profile": "mechaduino"}}}) as bench:
        runtime = bench._runtime
        axes, told = BenchAxes(runtime, Sampler(runtime)), list[str]()
        bench.run_until(ms=NOW_MS)
        given = position(runtime.devices["m1"].verbs, at_ns=ms(NOW_MS + SOON_MS))
        axes.give("m1", given, told.append)
        assert told == []
        bench.run(ms=2 * SOON_MS)
        assert len(told) == 1
        assert told[0].startswith("position: ")


@pytest.mark.parametrize("due_ms", [None, NOW_MS - SOON_MS], ids=["now", "late"])
def test_a_verb_that_is_done_at_once_is_refused_at_once(due_ms: int | None) -> None:
    """Also one that comes when its time is over."""
    with Bench({"bench": "t", "devices": {"m1": {"profile": "mechaduino"}}}) as bench:
        runtime = bench._runtime
        axes, told = BenchAxes(runtime, Sampler(runtime)), list[str]()
        bench.run_until(ms=NOW_MS)
        given = position(runtime.devices["m1"].verbs, None if due_ms is None else ms(due_ms))
        with pytest.raises(VerbRefused):
            axes.give("m1", given, told.append)
        assert told == []


def position(verbs: Mapping[str, Verb], at_ns: int | None = None) -> Do:
    return Do("position", tuple(verbs["position"].filled({"position_deg": 1.0}).items()), at_ns)
