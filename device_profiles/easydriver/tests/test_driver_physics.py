"""Energy and heat of an EasyDriver, alone and under an Arduino's sketch."""

import io
import math

import pytest
from driver_sweep import config

from hil.sim.bench import Around
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


@pytest.mark.parametrize("rate_Hz", [500.0, 20_000.0])
def test_energy_is_kept_also_where_the_motor_stalls(rate_Hz: float) -> None:
    inductance_H, inertia_kg_m2, detent_Nm, teeth = 0.05, 3.5e-6, 0.0077, 50
    with Bench(config(12.0, inductance_H, 0.3, full_step_error_pct=0.0)) as bench:
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
        # The first heating, by the law that the figures give: 2.3 V, 50 K/W, 10 s.
        rise_K = 50 * 2.3 * 2 * 0.75 * math.sqrt(0.5)
        expected_s = 10 * math.log(rise_K / (rise_K - (165 - 60)))
        assert turns[0][1][0] * 1e-9 == pytest.approx(expected_s, abs=0.15)


def test_a_driver_within_its_figures_stays_on() -> None:
    with Bench(config(12.0, 0.005, 0.75, phase_resistance_ohm=5.0)) as bench:
        bench.run(ms=100_000)
        shot = bench.axis("d1").snapshot()
        assert (shot.outputs_on, shot.junction_degC) == (1, pytest.approx(147.0, abs=1.0))


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
    with Bench(BENCH, around=Around(log=InputLogWriter(log, "t", BENCH, {}))) as bench:
        bench.run(ms=100)
        for typed, ms in ((b"swing 100 3000\n", 150.0), (b"stop\n", 3.3), (b"move -33\npin 8 1\n", 0.7)):
            bench.port("u1").write(typed)
            bench.run(ms=ms)
        bench.device("d1").pin("enable", 1)
        bench.run(ms=40)
        state = bench.axis("d1").snapshot()
    assert state.steps_taken != 0
    assert replay(log.getvalue().splitlines(keepends=True)).difference() is None
