"""Behaviour of the board besides printing: the loop, the driver's pins, modes, and the oddities Q1 to Q6."""

import struct
from array import array
from pathlib import Path

import pytest

from hil.core import Snapshot
from hil.testing import Bench

STEP_NS = 7385 * 1000 / 48
HELD_DEG = 4000 * 360 / 16384


def board(count: int | None = 4000, table: str = "identity", **device: object) -> Bench:
    """Bench at 5000 ms with the start-up's text read; the encoder holds ``count``, or is on the shaft
    (None)."""
    config = {"profile": "mechaduino", "port": "memory", "flash": {"table": table}} | device
    bench = Bench({"bench": "quirks", "devices": {"m1": config}})
    if count is not None:
        bench.axis("m1").script_encoder([(0, count)])
    bench.run_until(5000)
    bench.port("m1").read()
    return bench


def typed(bench: Bench, text: bytes, ms: float = 0) -> bytes:
    bench.port("m1").write(text)
    bench.run(ms)
    return bench.port("m1").read()


def state(bench: Bench) -> Snapshot:
    return bench.axis("m1").snapshot()


def pins(bench: Bench) -> tuple[int, ...]:
    now = state(bench)
    return (now.vref1, now.vref2, now.in1, now.in2, now.in3, now.in4)


# ---- the loop ----


@pytest.mark.parametrize(("command", "stops_after_ms"), [(b"p", 0), (b"s", 10), (b"y", 0)])
def test_p_s_and_y_stop_the_loop(command: bytes, stops_after_ms: int) -> None:
    # read_angle() stops it; s waits 10 ms for its step first.
    bench = board()
    typed(bench, b"xy", 500)
    assert state(bench).loop_on == 1
    typed(bench, command, stops_after_ms)
    assert state(bench).loop_on == 0
    frozen = (state(bench).control_steps, pins(bench))
    bench.run(99.9 - stops_after_ms)
    assert (state(bench).control_steps, pins(bench)) == frozen
    bench.run(1000)
    assert state(bench).loop_on == (command == b"y")


def test_the_first_step_comes_one_period_after_the_start_and_the_others_do_not_drift() -> None:
    bench = board()
    typed(bench, b"y", 100)
    assert (state(bench).loop_on, state(bench).control_steps) == (1, 0)
    bench.run(0.153853)
    assert state(bench).control_steps == 0
    bench.run(0.000001)
    assert state(bench).control_steps == 1
    bench.run_until(5100 + 100_000)
    assert state(bench).control_steps == 100_000_000_000 * 48 // (7385 * 1000)


def test_p_freezes_the_coils_and_a_new_set_point_does_nothing() -> None:
    bench = board()
    typed(bench, b"xyr90\n", 500)
    before = pins(bench)
    assert state(bench).U == 115
    typed(bench, b"pr0\n", 500)
    assert (pins(bench), state(bench).r) == (before, 0.0)


def test_n_drops_both_currents_and_leaves_the_directions() -> None:
    bench = board()
    typed(bench, b"d" + b"s" * 5, 600)
    _, _, *directions = pins(bench)
    assert pins(bench)[:2] != (0, 0)
    typed(bench, b"n")
    assert pins(bench) == (0, 0, *directions)
    typed(bench, b"xyr90\n", 500)
    _, _, *directions = pins(bench)
    typed(bench, b"n", 500)
    assert pins(bench) == (0, 0, *directions)
    assert state(bench).loop_on == 0


def test_r_and_k_leave_the_loop_running_while_they_wait() -> None:
    bench = board()
    typed(bench, b"xy", 500)
    for command in (b"r", b"\n", b"k", b"p", b"p"):
        steps = state(bench).control_steps
        typed(bench, command, 100)
        assert state(bench).loop_on == 1
        assert state(bench).control_steps - steps in (649, 650)


def test_a_step_up_turns_the_motor_back() -> None:
    # output() is called with the angle's negative: 1.8 deg a step, towards smaller counts; d turns it.
    bench = board(None)
    typed(bench, b"ssss", 500)
    start = state(bench).position_deg
    typed(bench, b"s", 300)
    assert state(bench).position_deg == pytest.approx(start - 1.8, abs=0.05)
    typed(bench, b"dss", 600)
    assert state(bench).position_deg == pytest.approx(start + 1.8, abs=0.05)


# ---- modes ----


def single(x: float) -> float:
    value: float = struct.unpack("f", struct.pack("f", x))[0]
    return value


@pytest.mark.parametrize("mode", ["", "x", "v", "t", "h"])
def test_y_overwrites_the_set_point_in_every_mode(mode: str) -> None:
    bench = board()
    answer = typed(bench, b"r7\n" + mode.encode() + b"y", 100)
    assert answer == b"Enter setpoint:\r\n7.00\r\nNew setpoint 87.89\r\n"
    bench.run(1000)
    now = state(bench)
    assert (now.r, now.mode, now.loop_on) == (HELD_DEG, ord(mode) if mode else 0, 1)
    # x: on the spot. v: 87.89 rpm wanted of a shaft at rest, the integral at its limit. t: 87.89 counts.
    assert {"": 0, "x": 0, "v": 115, "t": 87, "h": 0}[mode] == now.U
    if mode == "h":  # commutated open loop at 69 counts; |yw - r| is below one step
        assert max(now.vref1, now.vref2) in range(49, 70)


def test_torque_below_one_count_is_none() -> None:
    # U is an int: 0.99 counts are 0.
    bench = board()
    typed(bench, b"ty", 200)
    typed(bench, b"r0.99\n", 10)
    assert (state(bench).u, state(bench).U, pins(bench)[:2]) == (
        single(99 * single(single(0.1) * 0.1)),
        0,
        (0, 0),
    )
    typed(bench, b"r-1.5\n", 10)
    assert (state(bench).u, state(bench).U) == (-1.5, 1)


def test_the_led_shows_an_error_below_a_tenth() -> None:
    bench = board()
    typed(bench, b"kpi0\nq\nxy", 600)
    assert state(bench).led == 1
    typed(bench, b"r88\n", 10)
    assert state(bench).led == 0
    # Torque mode keeps the old error, and with it the LED.
    typed(bench, b"t\nr0\n", 10)
    assert (state(bench).led, state(bench).e) == (0, 88 - HELD_DEG)


# ---- Q1 to Q6 ----


def test_q1_first_enable_above_180_degrees_makes_a_full_turn() -> None:
    # y_1 starts at 0: the first step sees a jump of more than 180 deg and counts a turn down.
    bench = board(12000)
    typed(bench, b"xy", 101)
    now = state(bench)
    assert (now.wrap_count, now.r, now.e) == (-1, 263.671875, 360.0)
    bench = board(None, axis={"start_deg": 263.7})
    start = state(bench).position_deg
    typed(bench, b"xy", 2000)
    assert state(bench).position_deg == pytest.approx(start + 360, abs=0.5)


def test_q2_state_survives_n_y_r_and_a_change_of_mode() -> None:
    bench = board()
    typed(bench, b"xyr88\n", 101)
    typed(bench, b"", 5)
    integral = state(bench).ITerm
    steps = state(bench).control_steps
    assert 0 < integral < 150
    typed(bench, b"n", 100)
    assert (state(bench).ITerm, state(bench).control_steps) == (integral, steps)
    # y's set-point is where the encoder stands: e = 0, and the integral stays as it was.
    typed(bench, b"y", 200)
    now = state(bench)
    assert (now.e, now.ITerm) == (0.0, integral)
    typed(bench, b"t", 10)
    assert state(bench).ITerm == integral
    typed(bench, b"x", 10)
    assert state(bench).ITerm == integral


def test_q2_velocity_after_power_up_starts_at_a_hundred_times_the_angle() -> None:
    # The first step sees yw jump from 0: v = vLPFb * angle, vLPFb = 99.8176 (0x42c7a29a).
    bench = board()
    typed(bench, b"vy", 100.2)
    assert state(bench).control_steps == 1
    v_lpf_b = struct.unpack(">f", bytes.fromhex("42c7a29a"))[0]
    assert state(bench).v == single(v_lpf_b * HELD_DEG)
    # After a step in another mode yw_1 is known, and v starts at 0.
    bench = board()
    typed(bench, b"xy", 200)
    typed(bench, b"v", 10)
    assert state(bench).v == 0.0


def test_q3_hybrid_mode_counts_a_turn_every_step() -> None:
    # y_1 stays 0 in mode h, so each step sees the same jump of 263 deg.
    bench = board(12000)
    typed(bench, b"hy", 100)
    for _ in range(5):
        bench.run(50)
        now = state(bench)
        assert now.control_steps > 0
        assert now.wrap_count == -now.control_steps


def test_q5_a_cold_encoder_answers_the_first_reading_with_0() -> None:
    bench = board(spi_previous_command=0)
    assert typed(bench, b"p", 100).endswith(b"79.10, raw encoder: 4000\r\n")
    assert typed(bench, b"p", 100).endswith(b"87.89, raw encoder: 4000\r\n")


def test_q6_the_encoder_check_disturbs_the_loop_for_a_step_each_frame() -> None:
    # The step after DIAAGC's frame takes that register (0x180, 8.4375 deg) for the angle.
    bench = board()
    typed(bench, b"xy", 1000)
    before = state(bench).control_steps
    typed(bench, b"e", 0.2)
    now = state(bench)
    assert now.control_steps - before in (1, 2)
    seen = {round(now.yw, 4)}
    bench.run(10)
    assert state(bench).yw == HELD_DEG
    assert seen <= {8.4375, round(HELD_DEG, 4)}
    assert state(bench).loop_on == 1


# ---- the look-up table ----


@pytest.mark.parametrize(
    ("entries", "warns"),
    [
        ({}, True),
        ({1: 5.0, 127: 5.0, 1023: 5.0, 16383: 5.0}, True),
        ({0: 0.001}, False),
        ({128: 0.001}, False),
        ({1024: 0.001}, False),
    ],
)
def test_the_warning_looks_at_three_entries_only(
    tmp_path: Path, entries: dict[int, float], warns: bool
) -> None:
    table = array("f", bytes(65536))
    for count, angle in entries.items():
        table[count] = angle
    path = tmp_path / "table.bin"
    path.write_bytes(table.tobytes())
    device = {"profile": "mechaduino", "port": "memory", "flash": {"table": str(path)}}
    bench = Bench({"bench": "quirks", "devices": {"m1": device}})
    bench.run(4000)
    warning = (4000_000_000, b"WARNING: Lookup table is empty! Run calibration\r\n")
    assert [piece for piece in bench.port("m1").read_timed() if piece[0] != 3000_000_000] == [warning] * warns


def test_power_up_keeps_the_flash_and_loses_what_is_in_ram() -> None:
    bench = board(None, table="empty")
    typed(bench, b"c", 30000)
    typed(bench, b"kpp10\nq\nkop2.5\nxy", 200)
    typed(bench, b"r10\n", 100)
    calibrated = bench.device("m1").nvm["lookup"]
    assert any(calibrated)
    now = state(bench)
    assert (now.pKp, now.PA, now.mode, now.loop_on) == (10.0, 2.5, ord("x"), 1)
    position_deg = now.position_deg
    bench.device("m1").reset()
    now = state(bench)
    assert (now.pKp, now.PA, now.mode, now.loop_on) == (15.0, single(1.8), 0, 0)
    assert (now.r, now.wrap_count, now.ITerm, now.control_steps) == (0.0, 0, 0.0, 0)
    assert now.position_deg == position_deg
    assert (now.vref1, now.vref2, now.in1, now.in2, now.in3, now.in4) == (37, 37, 0, 1, 0, 1)
    reset_ns = bench.now_ns
    bench.port("m1").read()
    bench.run(5000)
    ((at_ns, menu),) = bench.port("m1").read_timed()
    assert at_ns == reset_ns + 3_000_000_000
    assert menu.startswith(b"\r\n\r\n----- Mechaduino 0.X -----\r\n")
    assert bench.device("m1").nvm["lookup"] == calibrated
    assert b"pKp = 15.0000000000" in typed(bench, b"kpq\n")


def test_a_reset_forgets_what_was_typed() -> None:
    bench = board()
    typed(bench, b"kp")
    bench.device("m1").reset()
    bench.run(4000)
    bench.port("m1").read()
    assert typed(bench, b"p", 100) == b"stepNumber: 0 , Angle: 87.89, raw encoder: 4000\r\n"


# ---- pins ----


def test_each_rising_edge_of_step_moves_the_set_point_by_a_32nd_of_a_step() -> None:
    bench = board()
    device = bench.device("m1")
    pulse_dir(bench)
    for _ in range(32):
        device.pin("D1", 1)
        device.pin("D1", 1)  # no edge
        device.pin("D1", 0)
    assert state(bench).r == pytest.approx(1.8, abs=1e-5)
    device.pin("D0", 1)
    for _ in range(64):
        device.pin("D1", 1)
        device.pin("D1", 0)
    assert state(bench).r == pytest.approx(-1.8, abs=1e-5)


def pulse_dir(bench: Bench) -> None:
    """Let the firmware know that the level of its dir input is low."""
    bench.device("m1").pin("D0", 1)
    bench.device("m1").pin("D0", 0)


def stepped_deg(bench: Bench) -> float:
    """Amount that a pulse at the step input adds to the set-point."""
    before = state(bench).r
    bench.device("m1").pin("D1", 1)
    bench.device("m1").pin("D1", 0)
    return round(state(bench).r - before, 5)


def test_dir_is_one_variable_of_the_pin_and_of_the_letters() -> None:
    bench = board()
    assert stepped_deg(bench) == -0.05625  # false at power-up, whatever the level is
    typed(bench, b"d", 10)
    assert stepped_deg(bench) == 0.05625
    bench.device("m1").pin("D0", 1)
    assert stepped_deg(bench) == -0.05625
    assert b"stepNumber: 1 ," in typed(bench, b"s", 200)
    bench.device("m1").pin("D0", 0)
    assert stepped_deg(bench) == 0.05625
    assert b"stepNumber: 0 ," in typed(bench, b"s", 200)
    typed(bench, b"d", 10)
    assert stepped_deg(bench) == -0.05625
    bench.device("m1").pin("D0", 0)  # no edge
    assert stepped_deg(bench) == -0.05625


def test_a_calibration_leaves_dir_true() -> None:
    bench = board(None)
    typed(bench, b"c", 30_000)
    assert stepped_deg(bench) == 0.05625


def test_a_reset_makes_dir_false_and_leaves_the_level() -> None:
    bench = board()
    bench.device("m1").pin("D0", 1)
    bench.device("m1").pin("D0", 0)
    bench.device("m1").reset()
    bench.run(5000)
    assert (stepped_deg(bench), state(bench).pin_dir) == (-0.05625, 0)


@pytest.mark.parametrize("how", ["n", "D2"])
def test_a_disabled_board_lets_the_shaft_go(how: str) -> None:
    bench = board(None)
    typed(bench, b"xyr30\n", 2000)
    if how == "n":
        typed(bench, b"n", 50)
    else:
        bench.device("m1").pin("D2", 1)
        bench.run(50)
    off = state(bench)
    assert (off.loop_on, off.current_a_A, off.current_b_A) == (0, 0, 0)
    bench.axis("m1").load_torque_Nm = 0.02
    bench.run(500)
    assert abs(state(bench).position_deg - off.position_deg) > 90


def test_an_enable_pin_that_goes_low_starts_the_loop_again() -> None:
    bench = board(None)
    typed(bench, b"xyr30\n", 2000)
    bench.device("m1").pin("D2", 1)
    bench.run(50)
    bench.device("m1").pin("D2", 0)
    bench.run(500)
    assert state(bench).loop_on == 1
    assert state(bench).position_deg == pytest.approx(30, abs=0.5)


def test_step_pulses_turn_the_motor_in_closed_loop() -> None:
    bench = board(None)
    typed(bench, b"xy", 500)
    pulse_dir(bench)
    start = state(bench).position_deg
    for _ in range(320):
        bench.device("m1").pin("D1", 1)
        bench.run(0.05)
        bench.device("m1").pin("D1", 0)
        bench.run(0.05)
    bench.run(500)
    assert state(bench).position_deg == pytest.approx(start + 18, abs=0.1)


def test_the_enable_input_is_active_low() -> None:
    bench = board()
    typed(bench, b"xyr90\n", 300)
    bench.device("m1").pin("D2", 1)
    assert state(bench).loop_on == 0
    # 0.1.4 left the power-up current, (int)(0.33 * 115), in both coils.
    assert pins(bench)[:2] == (0, 0)
    bench.run(10)
    bench.device("m1").pin("D2", 0)
    assert state(bench).loop_on == 1
    bench.device("m1").pin("D3", 1)
    assert state(bench).pin_d3 == 1


@pytest.mark.parametrize("hardware", ["0.1", "0.2"])
def test_both_hardware_versions_run_the_same_firmware(hardware: str) -> None:
    bench = board(hardware=hardware)
    assert typed(bench, b"p", 100) == b"stepNumber: 0 , Angle: 87.89, raw encoder: 4000\r\n"
