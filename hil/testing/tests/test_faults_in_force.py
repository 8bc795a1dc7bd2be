"""Faults that overlap, one dialogue each; ``test_faults_overlap.py`` tries all orders of all kinds."""

import pytest

from hil.sim.inputs import Do
from hil.testing import Bench
from hil.vocab.faults import FaultRefused
from hil.vocab.time import SimTimeNs

SERVO = {"profile": "mechaduino", "flash": {"table": "identity"}}
CONFIG = {
    "bench": "f",
    "devices": {"s1": {"profile": "sac"}, "m1": SERVO, "m2": SERVO | {"plant": "full"}},
    "segments": {"bus0": {"stations": ["s1"], "taps": {"master": {"port": "memory"}}}},
}


@pytest.fixture
def bench() -> Bench:
    made = Bench(CONFIG)
    made.run(ms=4500)
    for name in ("s1", "m1", "m2"):
        made.port(name).read()
    return made


def supply_V(bench: Bench) -> float:
    return bench._runtime.devices["m2"].axis.supply_V()


@pytest.mark.parametrize("first_ends_first", [True, False])
def test_two_sags(bench: Bench, first_ends_first: bool) -> None:
    sags = {volts: bench.fault("supply_sag", "m2", supply_V=volts) for volts in (6.0, 10.0)}
    assert supply_V(bench) == 10
    sags[6.0 if first_ends_first else 10.0].clear()
    assert supply_V(bench) == (10 if first_ends_first else 6)
    sags[10.0 if first_ends_first else 6.0].clear()
    assert supply_V(bench) == 24


def test_a_board_without_supply_can_have_another_sag(bench: Bench) -> None:
    bench.fault("supply_sag", "m2", supply_V=0.0)
    bench.fault("supply_sag", "m2", supply_V=5.0)
    assert supply_V(bench) == 5


def test_a_load_that_is_set_leaves_the_faults_alone(bench: Bench) -> None:
    axis = bench.axis("m1")
    with bench.fault("shaft_load", "m1", torque_Nm=0.05), bench.fault("shaft_load", "m1", torque_Nm=-0.02):
        assert axis.load_torque_Nm == pytest.approx(0.03)
        axis.load_torque_Nm = 0.0
        assert axis.load_torque_Nm == pytest.approx(0.03)
        axis.load_torque_Nm = 0.1
    assert axis.load_torque_Nm == 0.1


def test_a_board_without_power_is_not_started_by_a_reset(bench: Bench) -> None:
    first, second = (bench.fault("node_brown_out", "s1") for _ in range(2))
    bench.device("s1").reset()
    bench.fault("node_reset", "s1")
    first.clear()
    bench.run(ms=3000)
    assert bench.port("s1").read() == b""
    assert bench.device("s1").failed == f"no power (fault {second.number})"
    second.clear()
    bench.run(ms=3000)
    assert bench.port("s1").read() == b"SAC 1.0\r\nSAC>"


def test_a_motor_whose_board_has_no_power_has_none(bench: Bench) -> None:
    bench.port("m1").write(b"s")
    bench.run(ms=300)
    with bench.fault("node_brown_out", "m1"):
        bench.run(ms=10)
        state = bench.axis("m1").snapshot()
        assert (state.current_a_A, state.current_b_A) == (0, 0)


def test_a_board_that_hangs_hangs_after_a_reset(bench: Bench) -> None:
    with bench.fault("node_hang", "s1"):
        bench.device("s1").reset()
        bench.run(ms=3000)
        assert bench.port("s1").read() == b""
    bench.run(ms=3000)
    assert bench.port("s1").read() == b"SAC 1.0\r\nSAC>"


def test_a_station_that_was_taken_off_stays_off(bench: Bench) -> None:
    """A real node with its address took the station off; the wire's fault is another matter."""
    wire = bench._runtime.segments["bus0"]
    fault = bench.fault("wire_cut", "s1.network")
    wire.give_way("s1.network")
    fault.clear()
    assert wire.stations["s1.network"].is_cut
    wire.set_address("s1.network", 99)
    assert not wire.stations["s1.network"].is_cut
    wire.give_way("s1.network")
    with bench.fault("wire_cut", "s1.network"):
        wire.set_address("s1.network", 100)
        assert wire.stations["s1.network"].is_cut
    assert not wire.stations["s1.network"].is_cut


@pytest.mark.parametrize(("kind", "target"), [("node_reset", "s1"), ("steps_lost", "m1")])
def test_what_happens_once_is_listed_until_it_happens(bench: Bench, kind: str, target: str) -> None:
    fault = bench.fault(kind, target, start_s=0.1)
    assert fault.is_active
    bench.run(ms=100)
    assert not fault.is_active
    assert not bench.fault(kind, target).is_active
    with pytest.raises(FaultRefused, match="there is no fault 1; there are none"):
        bench._runtime.clear_fault(1)


@pytest.mark.parametrize("kind", [None, "node_reset", "node_brown_out"])
def test_motions_that_were_to_come_end_with_the_power(bench: Bench, kind: str | None) -> None:
    """The power cut drops, like a reset, what was asked of the board before."""
    at_ns = bench.now_ns + 4_000_000_000
    verb = bench._runtime.devices["m1"].verbs["enable"]
    do = Do(verb.name, tuple(verb.filled({}).items()), SimTimeNs(at_ns))
    bench._runtime.apply_to(bench._runtime.devices["m1"], do)
    if kind:
        bench.fault(kind, "m1", for_s=0.1)
    bench.run(ms=6000)
    assert bench.axis("m1").snapshot().loop_on == (kind is None)
