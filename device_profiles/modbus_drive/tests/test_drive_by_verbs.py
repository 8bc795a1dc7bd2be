"""The drive by its verbs, in runs and with streams that stop; and what a master sees of that."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from hil.testing import Bench, ConfigError, check_profile
from hil.vocab.time import NS_PER_S
from hil.vocab.verbs import VerbRefused

Make = Callable[..., Any]
BOARD = Path(__file__).parents[1]


def test_it_passes_the_checks_of_all_boards() -> None:
    check_profile(BOARD)


def test_verbs_move_it_and_the_registers_say_so(master: Make) -> None:
    plc = master()
    assert plc.drive.do("enable")["set_point"] == 0.0
    assert plc.status == {"enabled"}
    answer = plc.drive.do("move_abs", position_deg=90.0)
    assert answer["set_point"] == 90.0
    assert answer["ends_after_ns"] == 350_000_000
    assert plc.status == {"enabled", "moving"}
    plc.run(400)
    assert plc.kept(0, 2) == (0, 9000)
    plc.drive.do("move_rel", angle_deg=-30.0, velocity_rpm=600.0, acceleration_rpm_per_s=60_000.0)
    plc.run(100)
    assert plc.position_deg == pytest.approx(60.0, abs=0.1)
    assert plc.kept(2, 2) == (60, 600)  # what a verb was given is its own
    plc.drive.do("position", position_deg=61.0)
    assert plc.status == {"enabled", "moving"}
    plc.drive.do("disable")
    assert plc.status == set()
    assert plc.kept(4) == (0,)


def test_stop_ends_moves_and_what_is_followed(master: Make) -> None:
    plc = master()
    plc.put(4, 1 | 16)
    plc.target(5.0)
    plc.drive.do("stop", how="prejudice")
    plc.target(50.0)
    plc.run(100)
    assert plc.position_deg == pytest.approx(5.0, abs=1.0)
    assert plc.kept(4) == (1,)
    plc.drive.do("move_abs", position_deg=3600.0, velocity_rpm=600.0)
    plc.run(500)
    answer = plc.drive.do("stop", acceleration_rpm_per_s=6000.0)
    plc.run(answer["ends_after_ns"] / 1e6 + 50)
    assert plc.position_deg == pytest.approx(answer["set_point"], abs=0.3)


@pytest.mark.parametrize(
    ("verb", "given", "why"),
    [
        ("move_abs", {"position_deg": 1.0}, "the control loop is off"),
        ("position", {"position_deg": 1.0}, "the control loop is off"),
        ("write", {"start": 1}, "the control loop is off"),
    ],
)
def test_what_it_does_not_do_now(master: Make, verb: str, given: dict[str, float], why: str) -> None:
    plc = master()
    with pytest.raises(VerbRefused, match=why) as caught:
        plc.drive.do(verb, **given)
    assert caught.value.code == "not_now"


def test_with_a_fault_it_wants_that_cleared(master: Make) -> None:
    plc = master()
    plc.drive.do("enable")
    plc.drive.set_register("errfl", 1)
    plc.run(20)
    with pytest.raises(VerbRefused, match="fault 2, the encoder reports an error; clear it first"):
        plc.drive.do("enable")
    plc.drive.do("clear_fault")
    plc.drive.do("enable")
    plc.run(20)
    assert plc.status == {"enabled"}


def test_while_it_starts_it_takes_nothing() -> None:
    with Bench({"bench": "t", "devices": {"m1": {"profile": "modbus_drive"}}}) as bench:
        bench.run(ms=100)
        for verb in ("enable", "write", "clear_fault"):
            with pytest.raises(VerbRefused, match=r"start|has just got"):
                bench.device("m1").do(verb)


@pytest.mark.parametrize(
    ("policy", "status"), [("hold", {"enabled"}), ("decelerate", {"enabled"}), ("torque_off", set())]
)
def test_a_stream_that_stops_ends_as_the_configuration_says(
    master: Make, policy: str, status: set[str]
) -> None:
    plc = master({"setpoints": {"timeout_ms": 200, "policy": policy}})
    plc.put(4, 1 | 16)
    for step in range(5):
        plc.target(step)
    plc.run(300)
    assert plc.status == status
    assert "no set-point for 200 ms" in plc.drive.notes["set-points"]
    assert plc.kept(4)[0] & 1 == (policy != "torque_off")


def test_a_target_that_is_not_followed_is_no_stream(master: Make) -> None:
    plc = master({"setpoints": {"timeout_ms": 100, "policy": "torque_off"}})
    plc.target(90.0, control=(10, 600, 1 | 2))
    plc.run(2000)
    assert plc.status == {"enabled"}
    assert plc.position_deg == pytest.approx(90.0, abs=0.1)
    assert plc.drive.notes == {}


def test_a_run_moves_it(master: Make) -> None:
    plc = master()
    plc.drive.do("enable")
    run = {"run": "there", "axes": {"m1": {"velocity_rpm": 120}}, "steps": [{"move": {"m1": 90}}]}
    progress = plc.bench.perform(run)
    assert progress.state == "done"
    assert plc.position_deg == pytest.approx(90.0, abs=0.1)
    assert plc.kept(0, 2) == (0, 9000)


def test_a_run_does_not_begin_with_the_loop_off(master: Make) -> None:
    run = {"run": "there", "axes": {"m1": {"velocity_rpm": 120}}, "steps": [{"move": {"m1": 90}}]}
    with pytest.raises(ConfigError, match=r"its control loop is off \(`hil axis m1 enable` first\)"):
        master().bench.perform(run)


OWN = {
    "modbus_map": 1,
    "word_order": "low_first",
    "position_deg": {"holding": 100, "type": "f32"},
    "status": {"enabled": {"discrete": 3}, "moving": {"holding": 102, "bit": 8}},
    "set_point_deg": {"holding": 200, "type": "f32", "scale": -1},
    "control": {"enable": {"coil": 0}, "start": {"coil": 1}, "stop": {"holding": 102, "bit": 0}},
}


def test_with_a_map_of_its_own_it_is_another_drive(master: Make) -> None:
    from bridges.modbus.protocol.client_side import read, write, write_single
    from bridges.modbus.protocol.pdu import Table

    plc = master({"map": OWN})
    assert plc.told(0) == 2  # nothing there
    plc.put(200, 0x0000, 0xC2B4)  # -90.0, the low word first; the scale turns it round
    plc.ask(write(Table.COILS, 0, (1, 1)))
    plc.run(100)
    assert plc.kept(102) == (1 << 8,)
    plc.run(500)
    assert plc.ask(read(Table.DISCRETE_INPUTS, 3)) == (1,)
    assert plc.ask(read(Table.COILS, 0, 2)) == (1, 1)
    high = plc.kept(100, 2)[1]
    assert high == 0x42B4  # some 90.0
    assert plc.put(100, 0) == 2  # it is only told
    assert plc.put(102, 1 << 8) == ()  # a told bit beside one that is taken
    assert plc.ask(write_single(Table.COILS, 0, 0)) == ()
    assert plc.ask(read(Table.DISCRETE_INPUTS, 3)) == (0,)


def test_a_drive_that_turns_keeps_a_ramp_that_is_longer_than_a_path_at_a_speed(
    master: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("device_profiles.modbus_drive.firmware.TURNS_FOR_NS", 2 * NS_PER_S)
    monkeypatch.setattr("device_profiles.modbus_drive.firmware.TURNS_AGAIN_NS", NS_PER_S)
    plc = master()
    plc.drive.do("enable")
    plc.drive.do("run", velocity_rpm=60, acceleration_rpm_per_s=10)
    plc.run(3000)
    assert plc.axis.snapshot().velocity_rpm == pytest.approx(30, abs=1)
    plc.run(12_000)
    assert plc.axis.snapshot().velocity_rpm == pytest.approx(60, abs=1)
