"""Energy and heat of an EasyDriver, alone and under an Arduino's sketch."""

import io
import math

import pytest
from driver_sweep import config

from hil.sim.bench import BenchHooks
from hil.sim.input_log import InputLogWriter
from hil.testing import Bench, replay
from hil.wire.step_dir import generate, parse_train

BENCH = {
    "bench": "t",
    "devices": {
        "u1": {"profile": "uno"},
        "d1": {"profile": "easydriver", "axis": {"phase_current_A": 0.135, "phase_inductance_H": 0.05}},
    },
    "wires": [{"from": "u1.D6", "to": "d1.step"}, {"from": "u1.D7", "to": "d1.dir"}],
}


def test_the_sketch_turns_the_motor_by_one_turn() -> None:
    with Bench(BENCH) as bench:
        bench.run(ms=100)
        start_deg = bench.axis("d1").snapshot().position_deg
        bench.port("u1").write(b"move 1600\n")
        bench.run(ms=500)
        shot = bench.axis("d1").snapshot()
        assert (shot.steps_taken, shot.timing_errors, shot.lost_steps) == (1600, 0, 0)
        assert shot.position_deg - start_deg == pytest.approx(360.0, abs=0.3)
        assert bench.port("u1").read().endswith(b"moving 1600 steps, 144 us each\r\nmoved 1600 steps\r\n")


@pytest.mark.parametrize("fast_decay_pct", [0.0, 39.4, 100.0])
@pytest.mark.parametrize("rate_Hz", [500.0, 20_000.0])
def test_energy_is_kept_also_where_the_motor_stalls(rate_Hz: float, fast_decay_pct: float) -> None:
    inductance_H, inertia_kg_m2, detent_Nm, teeth = 0.05, 3.5e-6, 0.0077, 50
    numbers = {"full_step_error_pct": 0.0, "fast_decay_pct": fast_decay_pct}
    with Bench(config(12.0, inductance_H, 0.3, **numbers)) as bench:
        names = ("electrical_J", "copper_J", "friction_J", "load_J", "current_a_A", "current_b_A")
        energies = bench.axis("d1").record(*names, "velocity_rpm", "position_deg", interval_ms=0.5)
        bench.axis("d1").load_torque_Nm = 0.02
        bench.device("d1").drive(generate(-1000, rate_Hz))
        bench.run(ms=300)
        kept = []
        for _, electrical, copper, friction, load, a_A, b_A, rpm, deg in energies.rows:
            motion = 0.5 * inertia_kg_m2 * (rpm * math.tau / 60) ** 2
            coils = 0.5 * inductance_H * (a_A**2 + b_A**2)
            magnets = -detent_Nm / (4 * teeth) * math.cos(4 * teeth * math.radians(deg))
            kept.append(electrical - copper - friction - load - motion - coils - magnets)
        drawn = energies.rows[-1][1]
        assert drawn > 0.1
        assert max(kept) - min(kept) < 2e-3 * drawn
        lost = bench.axis("d1").snapshot().lost_steps
        assert (lost != 0) == (rate_Hz > 10_000)


def test_a_driver_that_is_too_hot_is_off_until_it_has_cooled() -> None:
    with Bench(config(12.0, 0.005, 0.75, ambient_degC=60.0, phase_resistance_ohm=5.0)) as bench:
        heat = bench.axis("d1").record("junction_degC", "outputs_on", "is_too_hot", interval_ms=20)
        bench.run(ms=60_000)
        hottest = max(row[1] for row in heat.rows)
        assert 165.0 < hottest < 166.5
        turns = [
            (before, now)
            for before, now in zip(heat.rows, heat.rows[1:], strict=False)
            if before[2] != now[2]
        ]
        assert [now[2] for _, now in turns][:3] == [0, 1, 0]
        assert [now[3] for _, now in turns][:3] == [1, 0, 1]
        assert turns[1][1][1] == pytest.approx(150.0, abs=1.5)
        # The first heating, by the law that the figures give: 50 K/W, 10 s.
        rise_K = 50 * (0.25 + 2 * 0.75 * math.sqrt(0.5) * (1.18 + 1.83 * 0.75 * math.sqrt(0.5)))
        expected_s = 10 * math.log(rise_K / (rise_K - (165 - 60)))
        assert turns[0][1][0] * 1e-9 == pytest.approx(expected_s, abs=0.2)


def test_a_driver_within_its_figures_stays_on() -> None:
    with Bench(config(12.0, 0.005, 0.75, phase_resistance_ohm=5.0)) as bench:
        bench.run(ms=100_000)
        shot = bench.axis("d1").snapshot()
        assert (shot.outputs_on, shot.junction_degC) == (1, pytest.approx(151.5, abs=0.1))


@pytest.mark.parametrize(
    ("peak_A", "steps", "coils_W"),
    [(0.4 * math.sqrt(2), 0, 2 * 0.4 * (1.7 + 0.21)), (0.75, 4, 0.75 * (1.9 + 0.65))],
)
def test_it_is_as_warm_as_the_data_sheets_voltages_make_it(peak_A: float, steps: int, coils_W: float) -> None:
    """Source and sink at the data sheet's two currents, in both coils and in one; 50 mA of 5 V; 50 K/W."""
    with Bench(config(12.0, 0.005, peak_A, phase_resistance_ohm=5.0)) as bench:
        bench.device("d1").drive(generate(-max(steps, 1), 100.0) if steps else [])
        bench.run(ms=100_000)
        shot = bench.axis("d1").snapshot()
        assert shot.junction_degC == pytest.approx(25 + 50 * (0.25 + coils_W), abs=0.5)


@pytest.mark.parametrize(("fast_decay_pct", "times"), [(100.0, 1.0), (39.4, 0.394), (0.0, 0.0)])
def test_a_falling_current_gets_the_part_of_the_supply_that_pfd_sets(
    fast_decay_pct: float, times: float
) -> None:
    """Half a step from home with a heavy rotor: one coil's current falls to 0, the other one's rises."""
    inductance_H, resistance_ohm, supply_V = 0.05, 0.5, 12.0
    numbers = {
        "phase_resistance_ohm": resistance_ohm,
        "fast_decay_pct": fast_decay_pct,
        "inertia_kg_m2": 0.02,
    }
    with Bench(config(supply_V, inductance_H, 0.3, **numbers)) as bench:
        bench.run(ms=50)
        bench.device("d1").pin("MS2", 0)
        bench.device("d1").pin("dir", 1)
        bench.run(ms=1)
        before_A = bench.axis("d1").snapshot().current_b_A
        bench.device("d1").pin("step", 1)
        bench.run(ms=0.1)  # the plant's own node, at which the command changes
        first = bench.axis("d1").snapshot()
        bench.run(ms=0.3)
        shot = bench.axis("d1").snapshot()
        assert before_A == pytest.approx(0.3 * math.sqrt(0.5))
        fallen_A = first.current_b_A - shot.current_b_A
        own_V = resistance_ohm * (first.current_b_A + shot.current_b_A) / 2
        assert fallen_A == pytest.approx((times * supply_V + own_V) * 0.3e-3 / inductance_H, rel=0.15)
        assert shot.current_a_A - first.current_a_A < -0.06  # with all of the supply
        bench.device("d1").pin("enable", 1)
        bench.run(ms=0.2)
        held_A = bench.axis("d1").snapshot().current_b_A
        bench.run(ms=0.2)
        gone_A = held_A - bench.axis("d1").snapshot().current_b_A
        assert gone_A == pytest.approx(supply_V * 0.2e-3 / inductance_H, rel=0.25)


def test_a_logic_analysers_file_drives_all_inputs() -> None:
    text = "Time [s],STEP,DIR,MS1,MS2,enable\n0,0,1,0,0,1\n1e-3,1,1,0,0,1\n2e-3,0,1,0,0,1\n3e-3,1,1,0,0,0\n"
    with Bench(config(12.0, 0.05, 0.3)) as bench:
        bench.device("d1").drive(parse_train(text, "capture.csv"))
        bench.run(ms=2.5)
        assert bench.axis("d1").snapshot().outputs_on == 0
        bench.run(ms=10)
        shot = bench.axis("d1").snapshot()
        assert (shot.outputs_on, shot.microsteps, shot.steps_taken, shot.timing_errors) == (1, 1, 2, 0)
        assert shot.commanded_deg == pytest.approx(0.9 + 3.6)


def test_a_bench_of_both_replays_identically() -> None:
    log = io.StringIO()
    with Bench(BENCH, around=BenchHooks(log=InputLogWriter(log, "t", BENCH, {}))) as bench:
        bench.run(ms=100)
        for typed, ms in ((b"swing 100 3000\n", 150.0), (b"stop\n", 3.3), (b"move -33\npin 8 1\n", 0.7)):
            bench.port("u1").write(typed)
            bench.run(ms=ms)
        bench.device("d1").pin("enable", 1)
        bench.run(ms=40)
        state = bench.axis("d1").snapshot()
    assert state.steps_taken != 0
    assert replay(log.getvalue().splitlines(keepends=True)).difference() is None
