"""What the axes of a bench tell a run of the verbs that it has given them for later."""

from collections.abc import Mapping

import pytest

from hil.runs import BenchAxes
from hil.sim.inputs import Do
from hil.telemetry import Sampler
from hil.testing import Bench
from hil.vocab.time import ms
from hil.vocab.verbs import Verb, VerbRefused

SOON_MS, NOW_MS = 100, 4500


@pytest.mark.parametrize("due_ms", [NOW_MS + SOON_MS, NOW_MS - SOON_MS], ids=["in time", "late"])
def test_a_verb_that_could_not_be_done_at_its_time_is_told(due_ms: int) -> None:
    """Also one that comes when its time is over, and is done at once."""
    with Bench({"bench": "t", "devices": {"m1": {"profile": "mechaduino"}}}) as bench:
        runtime = bench._runtime
        axes = BenchAxes(runtime, Sampler(runtime))
        bench.run_until(ms=NOW_MS)
        axes.give("m1", position(runtime.devices["m1"].verbs, at_ns=ms(due_ms)))
        bench.run(ms=2 * SOON_MS)
        told = axes.refusals("m1")
        assert len(told) == 1
        assert told[0].startswith("position: ")
        assert axes.refusals("m1") == []


def test_a_verb_that_is_wanted_now_is_refused_now() -> None:
    with Bench({"bench": "t", "devices": {"m1": {"profile": "mechaduino"}}}) as bench:
        runtime = bench._runtime
        axes = BenchAxes(runtime, Sampler(runtime))
        bench.run_until(ms=NOW_MS)
        with pytest.raises(VerbRefused):
            axes.give("m1", position(runtime.devices["m1"].verbs))
        assert axes.refusals("m1") == []


def position(verbs: Mapping[str, Verb], at_ns: int | None = None) -> Do:
    return Do("position", tuple(verbs["position"].filled({"position_deg": 1.0}).items()), at_ns)
