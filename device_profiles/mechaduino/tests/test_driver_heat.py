"""Heat of the board's A4954: shutdown and return by the current that its choppers are told."""

import io
import math

import pytest

from hil.sim.bench import BenchHooks
from hil.sim.input_log import InputLogWriter
from hil.testing import Bench, replay

K_PER_W, BRIDGE_OHM, WARMING_S, HOT_degC, COOL_degC = 35.0, 1.3, 10.0, 160.0, 140.0
"""Figures of hil/core/native/law/servo.c."""
AT_POWER_UP_W = BRIDGE_OHM * 2 * (37 * 3.3 / 255 / 1.5) ** 2
"""Heat of the currents that the firmware begins with: 37 counts in each coil."""


def _config(**keys):
    return {"bench": "t", "devices": {"m1": {"profile": "mechaduino", **keys}}}


def _bench(**keys):
    return Bench(_config(**keys))


def _push(bench):
    """Have the loop push a shaft that is stuck with its whole effort."""
    bench.run(ms=4100)
    bench.fault("shaft_jam", "m1")
    bench.port("m1").write(b"xyr90\n")


def test_a_stock_board_never_becomes_too_hot() -> None:
    with _bench(axis={"ambient_degC": 85}) as bench:
        _push(bench)
        bench.run(ms=100_000)
        shot = bench.axis("m1").snapshot()
        current_A = shot.uMAX * 3.3 / 255 / 1.5
        assert (shot.U, shot.is_too_hot, shot.thermal_trips) == (shot.uMAX, 0, 0)
        assert shot.junction_degC == pytest.approx(85 + K_PER_W * BRIDGE_OHM * current_A**2, abs=1)


def test_a_board_at_rest_warms_up_by_the_currents_of_its_start() -> None:
    with _bench() as bench:
        bench.run(ms=10_000)
        rise_K = K_PER_W * AT_POWER_UP_W
        expected_degC = 25 + rise_K * (1 - math.exp(-10 / WARMING_S))
        assert bench.axis("m1").snapshot().junction_degC == pytest.approx(expected_degC, abs=0.01)
        bench.run(ms=300_000)
        assert bench.axis("m1").snapshot().junction_degC == pytest.approx(25 + rise_K, abs=0.01)


@pytest.mark.parametrize("plant", ["simple", "full"])
def test_a_driver_that_is_too_hot_is_off_until_it_has_cooled(plant: str) -> None:
    names = ("junction_degC", "is_too_hot", "current_a_A", "current_b_A", "ITerm")
    with _bench(parameters={"iMAX": 2.0}, plant=plant) as bench:
        heat = bench.axis("m1").record(*names, interval_ms=50)
        _push(bench)
        bench.run(ms=30_000)
        shot = bench.axis("m1").snapshot()
        assert shot.thermal_trips > 1
        assert 0 < shot.too_hot_at_ns != shot.cooled_at_ns
        pairs = list(zip(heat.rows, heat.rows[1:], strict=False))
        turns = [now for before, now in pairs if before[2] != now[2]]
        assert [row[2] for row in turns][:4] == [1, 0, 1, 0]
        assert [row[1] for row in turns][:4] == pytest.approx([160, 140, 160, 140], abs=2)
        off = [now for before, now in pairs if before[2] and now[2]]
        assert off
        assert all(abs(row[3]) + abs(row[4]) < 1e-6 for row in off)
        # The first heating, by the law that the figures give.
        rise_K = K_PER_W * BRIDGE_OHM * (shot.vref1**2 + shot.vref2**2) * (3.3 / 255 / 1.5) ** 2
        (begin_degC,) = (row[1] for row in heat.rows if row[0] == 4_100_000_000)
        begin_K = begin_degC - 25
        expected_s = 4.1 + WARMING_S * math.log((rise_K - begin_K) / (rise_K - (HOT_degC - 25)))
        assert turns[0][0] * 1e-9 == pytest.approx(expected_s, abs=0.3)
        # It cools to the air.
        cooling_s = WARMING_S * math.log((HOT_degC - 25) / (COOL_degC - 25))
        assert (turns[1][0] - turns[0][0]) * 1e-9 == pytest.approx(cooling_s, abs=0.2)


def test_hot_air_has_it_too_hot_with_less_current() -> None:
    for ambient_degC, trips in ((25, False), (70, True)):
        with _bench(parameters={"iMAX": 1.5}, axis={"ambient_degC": ambient_degC}) as bench:
            _push(bench)
            bench.run(ms=60_000)
            assert (bench.axis("m1").snapshot().thermal_trips > 0) == trips


def test_a_motor_that_is_not_connected_heats_nothing() -> None:
    with _bench(parameters={"iMAX": 2.0}) as bench:
        bench.fault("motor_unplugged", "m1")
        _push(bench)
        bench.run(ms=100_000)
        assert bench.axis("m1").snapshot().junction_degC == pytest.approx(25, abs=0.01)


def test_a_reset_cools_nothing() -> None:
    with _bench(parameters={"iMAX": 2.0}) as bench:
        _push(bench)
        while not bench.axis("m1").snapshot().is_too_hot:
            bench.run(ms=100)
        before_degC = bench.axis("m1").snapshot().junction_degC
        bench.device("m1").reset()
        bench.run(ms=10)
        shot = bench.axis("m1").snapshot()
        assert (shot.is_too_hot, shot.thermal_trips) == (1, 1)
        assert shot.junction_degC == pytest.approx(before_degC, abs=1)
        bench.run(ms=5000)
        shot = bench.axis("m1").snapshot()
        assert (shot.is_too_hot, shot.current_a_A != 0) == (0, True)


def test_a_fault_and_heat_end_each_for_itself() -> None:
    with _bench(parameters={"iMAX": 2.0}) as bench:
        _push(bench)
        while not bench.axis("m1").snapshot().is_too_hot:
            bench.run(ms=100)
        fault = bench.fault("thermal_trip", "m1")
        bench.run(ms=5000)
        shot = bench.axis("m1").snapshot()
        assert (shot.is_too_hot, shot.current_a_A, shot.current_b_A) == (0, 0, 0)
        fault.clear()
        bench.run(ms=100)
        assert bench.axis("m1").snapshot().current_a_A != 0


def test_boards_are_as_warm_alone_as_together() -> None:
    """Lanes move boards together; a look at one's heat is none at the others'."""
    seen = []
    for others in (0, 5):
        config = _config(parameters={"iMAX": 2.0})
        config["devices"] |= {
            f"x{i}": {"profile": "mechaduino", "flash": {"table": "identity"}} for i in range(others)
        }
        with Bench(config) as bench:
            for i in range(others):
                bench.port(f"x{i}").write(b"xyr45\n")
            _push(bench)
            bench.run(ms=20_000)
            seen.append(bench.axis("m1").snapshot())
    assert seen[0] == seen[1]
    assert seen[0].thermal_trips > 0


def test_a_run_with_its_heat_runs_again_to_the_byte() -> None:
    log, config = io.StringIO(), _config(parameters={"iMAX": 2.0})
    with Bench(config, around=BenchHooks(log=InputLogWriter(log, "t", config, {}))) as bench:
        _push(bench)
        bench.run(ms=25_000)
        assert bench.axis("m1").snapshot().thermal_trips > 0
    assert replay(log.getvalue().splitlines(keepends=True)).difference() is None


def test_drives_with_the_same_law_have_no_heat() -> None:
    with Bench({"bench": "t", "devices": {"d1": {"profile": "modbus_drive"}}}) as bench:
        bench.run(ms=1000)
        shot = bench.axis("d1").snapshot()
        assert (shot.junction_degC, shot.is_too_hot) == (0, 0)
