"""The arm as users know it: moved by its port and by verbs, with things missing, stuck and nonsense typed."""

import math
import re
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import pytest

from device_profiles.walter.servo_packets import packet
from device_profiles.walter.settings import KEPT_BYTES, SECTION, ArmMemory
from hil.testing import Bench

READY_MS = 1000.0
JOINTS = ("hip", "upperarm", "forearm", "ellbow", "wrist")


def arm(**keys: Any) -> Bench:
    """A bench with one arm that is ready; ``faults`` are the bench's."""
    faults = keys.pop("faults", [])
    made = Bench({"bench": "t", "devices": {"w1": {"profile": "walter"} | keys}, "faults": faults})
    made.run(ms=READY_MS)
    made.port("w1").read()
    return made


@pytest.fixture
def bench() -> Iterator[Bench]:
    with arm() as made:
        yield made


def say(bench: Bench, text: str, ms: float = 60.0) -> str:
    bench.port("w1").write(text.encode("latin-1") + b"\r")
    bench.run(ms=ms)
    return bench.port("w1").read().decode("latin-1")


def switch_on(bench: Bench) -> None:
    assert say(bench, "POWER on") == ">ok\r\n>"
    assert say(bench, "ENABLE") == ">ok\r\n>"


def positions(bench: Bench) -> list[float]:
    return [bench.axis(f"w1.{name}").snapshot().position_deg for name in (*JOINTS, "hand", "gripper")]


def test_a_stream_of_targets_moves_all_axes(bench: Bench) -> None:
    switch_on(bench)
    targets = (20, -10, -20, 15, 30, 40, 25)
    for step in range(1, 11):
        now = " ".join(f"{target * step / 10:.2f}" for target in targets)
        assert say(bench, f"MOVETO {now} 100", ms=100) == ">ok\r\n>"
    bench.run(ms=1000)
    assert positions(bench) == pytest.approx(targets, abs=0.5)


def test_the_servos_get_a_round_every_56_ms_whatever_moves(bench: Bench) -> None:
    switch_on(bench)
    begun_ns = bench.now_ns
    for step in range(100):
        angles = [30 * math.sin(2 * math.pi * (step + 1) / 40 + joint) for joint in range(5)]
        servos = 60 * math.sin(step / 10), 30 + 20 * math.sin(step / 10)
        said = " ".join(f"{deg:.2f}" for deg in (*angles, *servos))
        bench.port("w1").write(f"MOVETO {said} 100\r".encode())
        bench.run(ms=100)
    sent = [(at_ns, data) for at_ns, data in bench.port("w1.servo").timeline if at_ns > begun_ns]
    rounds_ms = [at_ns / 1e6 for at_ns, data in sent if data[3:5] == b"\xfd\x06"]
    assert len(rounds_ms) == pytest.approx(10_000 / 56, abs=1)
    late = [ms - rounds_ms[0] - 56 * place for place, ms in enumerate(rounds_ms)]
    # A round waits for the end of a pass: its pulses take 2 us each.
    assert all(-0.03 < each < 0.03 for each in late)


@pytest.mark.parametrize(("backwards", "sign"), [(None, -1), (0, 1), (1, -1)])
def test_the_elbow_counts_its_own_pulses_backwards(backwards: int | None, sign: int) -> None:
    setting = {} if backwards is None else {"axes": {"ellbow": {"axis": {"counts_backwards": backwards}}}}
    with arm(**setting) as bench:
        switch_on(bench)
        ellbow = bench.axis("w1.ellbow")
        bench.port("w1").write(b"MOVETO 0 0 0 30 0 0 0 1000\r")
        seen = [ellbow.snapshot()]
        for _ in range(2000):
            bench.run(ms=0.05)
            seen.append(ellbow.snapshot())
        counted = [
            b.measured_deg - a.measured_deg
            for a, b in pairwise(seen)
            if b.step_position == a.step_position + 1
            and b.drive_integral == a.drive_integral  # no sample between
        ]
        assert len(counted) > 10
        assert counted == pytest.approx([sign * 1.8 / 4 / 7.4375] * len(counted), rel=1e-3)


def test_the_elbow_runs_away_without_its_encoder_and_the_wrist_does_not(bench: Bench) -> None:
    switch_on(bench)
    for name in ("ellbow", "wrist"):
        bench.fault("bus_no_answer", f"w1.{name}")
    bench.run(ms=200)
    say(bench, "MOVETO 0 0 0 10 10 0 0 1000", ms=3000)
    assert bench.axis("w1.ellbow").snapshot().position_deg > 100
    assert bench.axis("w1.wrist").snapshot().position_deg == pytest.approx(10, abs=0.5)


def test_verbs_move_a_joint_within_its_limits(bench: Bench) -> None:
    switch_on(bench)
    said = bench.axis("w1.forearm").do("move_to", position_deg=90.0, duration_ms=500)
    assert said["set_point"] == 34.0
    bench.axis("w1").do("move_abs", position_deg=-10.0, velocity_rpm=2.0)
    bench.run(ms=300)
    assert bench.axis("w1.forearm").snapshot().ramp_left_ms > 0
    bench.axis("w1.forearm").do("stop", how="grace")
    stopped_deg = bench.axis("w1.forearm").snapshot().to_be_deg
    bench.run(ms=1500)
    assert bench.axis("w1.forearm").snapshot().position_deg == pytest.approx(stopped_deg, abs=0.5)
    assert bench.axis("w1.hip").snapshot().position_deg == pytest.approx(-10, abs=0.5)


def test_verbs_need_power(bench: Bench) -> None:
    with pytest.raises(Exception, match="POWER on and ENABLE"):
        bench.axis("w1.hip").do("move_to", position_deg=10.0)


def test_power_that_goes_while_it_moves_leaves_the_joints_where_they_are(bench: Bench) -> None:
    switch_on(bench)
    say(bench, "MOVETO 60 0 0 0 0 0 0 2000", ms=800)
    assert say(bench, "POWER off") == ">ok\r\n>"
    stood = positions(bench)
    bench.run(ms=3000)
    assert positions(bench) == stood
    assert 5 < stood[0] < 40
    pulses = bench.axis("w1.hip").snapshot().joint_pulses
    bench.run(ms=100)
    assert bench.axis("w1.hip").snapshot().joint_pulses > pulses  # its law goes on, against nothing


def test_a_reset_while_it_moves_starts_again_where_it_stands(bench: Bench) -> None:
    switch_on(bench)
    say(bench, "MOVETO 60 0 0 0 0 0 0 2000", ms=800)
    bench.device("w1").reset()
    stood = positions(bench)
    bench.run(ms=READY_MS)
    assert bench.port("w1").read() == b"WALTER's Cortex\r\n>"
    assert positions(bench) == stood
    said = say(bench, "GET 0")
    assert float(said.split("ang=")[1].split()[0]) == pytest.approx(stood[0], abs=0.03)


def test_a_missing_encoder_is_told_once_and_written_to_the_logger() -> None:
    gone = {"fault": "bus_no_answer", "target": "w1.forearm"}
    with arm(faults=[gone]) as bench:
        assert say(bench, "ENABLE") == ">nok(12)\r\n>"
        assert say(bench, "ENABLE") == ">nok(0)\r\n>"
        assert " i2c0=(0x40,0x41,0x43) i2c1=(0x40,0x54)>ok" in say(bench, "INFO")
        bench.port("w1.logger").read()
        assert say(bench, "SETUP", ms=700) == ">nok(12)\r\n>"
        log = bench.port("w1.logger").read().decode()
        assert "   comcheck(0x42) failed!\r\n" in log
        assert "forearm(2)6.retry ERROR:enc comm\r\n" in log
        assert "enc(0x42) not ok!\r\n" in log
        assert "forearm(2)FATAL:encoder not ok\r\n" in log
        assert " n=2 ang=0.00 " in say(bench, "GET 2")


def test_an_encoder_that_is_lost_in_motion_leaves_the_joint_to_its_own_count(bench: Bench) -> None:
    switch_on(bench)
    say(bench, "MOVETO 0 0 -20 0 0 0 0 1000", ms=500)
    bench.port("w1.logger").read()
    bench.fault("bus_no_answer", "w1.forearm")
    bench.run(ms=1000)
    log = bench.port("w1.logger").read().decode()
    assert log == "".join(f"forearm(2){n}.retry ERROR:enc comm\r\n" for n in range(1, 6))
    assert bench.axis("w1.forearm").snapshot().position_deg == pytest.approx(-20, abs=1)


def test_a_noisy_bus_loses_single_readings(bench: Bench) -> None:
    switch_on(bench)
    bench.fault("bus_no_answer", "w1.hip", rate=0.2, seed=3)
    bench.port("w1.logger").read()
    say(bench, "MOVETO 20 0 0 0 0 0 0 1000", ms=3000)
    log = bench.port("w1.logger").read().decode()
    assert 10 < log.count(".retry") < 60
    assert bench.axis("w1.hip").snapshot().position_deg == pytest.approx(20, abs=1)


def test_a_joint_that_is_stuck_is_pulsed_in_vain_and_comes_when_it_is_free(bench: Bench) -> None:
    switch_on(bench)
    jam = bench.fault("shaft_jam", "w1.wrist")
    say(bench, "MOVETO 0 0 0 0 10 0 0 500", ms=2000)
    wrist = bench.axis("w1.wrist").snapshot()
    assert wrist.position_deg == 0
    assert wrist.joint_pulses > 200
    jam.clear()
    bench.run(ms=2000)
    assert bench.axis("w1.wrist").snapshot().position_deg == pytest.approx(10, abs=0.5)


def test_more_load_than_the_motor_holds_stops_a_joint(bench: Bench) -> None:
    switch_on(bench)
    bench.axis("w1.wrist").load_torque_Nm = 1.0
    say(bench, "MOVETO 0 0 0 0 10 0 0 500", ms=1000)
    assert bench.axis("w1.wrist").snapshot().position_deg == 0


def test_more_load_than_a_servo_holds_stops_it(bench: Bench) -> None:
    switch_on(bench)
    hand = bench.axis("w1.hand")
    begun_deg = hand.snapshot().position_deg
    hand.load_torque_Nm = 1.0
    say(bench, "MOVETO 0 0 0 0 0 30 0 500", ms=1000)
    assert hand.snapshot().position_deg == begun_deg
    hand.load_torque_Nm = 0.1
    bench.run(ms=100)
    assert hand.snapshot().position_deg == pytest.approx(30, abs=0.5)


def test_a_joint_that_is_turned_by_hand_is_brought_back(bench: Bench) -> None:
    switch_on(bench)
    say(bench, "MOVETO 5 0 0 0 0 0 0 100", ms=500)
    bench.fault("steps_lost", "w1.hip", turn_deg=-3.0)
    assert bench.axis("w1.hip").snapshot().position_deg == pytest.approx(2, abs=0.4)
    bench.run(ms=1000)
    assert bench.axis("w1.hip").snapshot().position_deg == pytest.approx(5, abs=0.4)


def test_mute_servos_can_be_answered_at_their_port() -> None:
    mute = [{"fault": "bus_no_answer", "target": f"w1.{name}"} for name in ("hand", "gripper")]
    keys = {"bauds": {"servo": None}}
    with arm(faults=mute, **keys) as bench:
        assert say(bench, "ENABLE") == ">nok(41)\r\n>"
        servo = bench.port("w1.servo")
        servo.read()
        bench.port("w1").write(b"SETUP\r")
        for _ in range(600):
            bench.run(ms=1)
            sent = servo.read()
            if sent[4:5] == b"\x07":
                servo.write(packet(sent[3], 0x47, bytes(2)))
        assert bench.port("w1").read() == b">ok\r\n>"


def test_the_knob_leads_the_current_joint(bench: Bench) -> None:
    assert say(bench, "KNOB 0") == ">ok\r\n>"
    bench.run(ms=500)
    assert bench.axis("w1.hip").snapshot().to_be_deg == 0
    assert say(bench, "KNOB -1") == ">ok\r\n>"


def test_another_place_of_the_knob_is_another_angle() -> None:
    with arm(axes={"hip": {"registers": {"knob_counts": 512 + 128}}}) as bench:
        bench.port("w1.logger").read()
        say(bench, "KNOB 0", ms=2000)
        assert bench.axis("w1.hip").snapshot().position_deg == pytest.approx(33.75, abs=0.5)
        assert bench.port("w1.logger").read().startswith(b"knob:set to 33.8")


def test_without_a_light_driver_it_is_ready_sooner() -> None:
    config = {"profile": "walter", "axes": {"hip": {"registers": {"has_lights": 0}}}}
    with Bench({"bench": "t", "devices": {"w1": config}}) as bench:
        bench.run(ms=470)
        assert bench.port("w1").read().endswith(b"\r\n>")
        assert say(bench, "INFO").count("0x54") == 0


def test_two_joints_are_kept_without_power_and_the_others_are_not(bench: Bench) -> None:
    for number in (0, 1, 2):
        assert say(bench, f"SET {number} min=-12.5") == ">ok\r\n>"
    bench.run(ms=10_100)
    assert bench.port("w1").read() == b"EEPROM saved.\r\n"
    assert len(bench.device("w1").nvm[SECTION]) == 2 + KEPT_BYTES
    bench.device("w1").reset()
    bench.run(ms=READY_MS)
    bench.port("w1").read()
    kept = [
        f"min={low}" in say(bench, f"GET {number}")
        for number, low in enumerate(("-12.50", "-12.50", "-180.00"))
    ]
    assert kept == [True, True, True]


class FullDisk:
    """Memory that nothing can be written to."""

    def commit(self, *_: object) -> bool:
        return False


def test_a_save_that_failed_is_not_said_to_have_gone() -> None:
    with Bench({"bench": "t", "devices": {"w1": {"profile": "walter"}}}, store=FullDisk()) as bench:
        bench.run(ms=READY_MS)
        bench.port("w1").read()
        say(bench, "SET 0 min=-12.5")
        bench.run(ms=10_100)
        assert bench.port("w1").read() == b""


@pytest.mark.parametrize(
    ("eeprom", "why"),
    [
        (b"", "no mark"),
        (b"\x01\x02" + bytes(116), "no mark"),
        (ArmMemory().kept()[:60], "58 of 116"),
        (ArmMemory().kept()[:2] + b"\x07" * 116, "log flags"),
        (ArmMemory().kept()[:10] + b"\x09" + ArmMemory().kept()[11:], "actuator 0"),
        (ArmMemory().kept()[:22] + b"\xff" * 4 + ArmMemory().kept()[26:], "no hip|none|actuator"),
    ],
)
def test_an_eeprom_of_another_version_changes_nothing(eeprom: bytes, why: str) -> None:
    memory = ArmMemory()
    said = memory.read(eeprom)
    assert said is not None
    assert re.search(why, said)
    assert memory.image() == ArmMemory().image()


# ---- what is typed wrong ----


def test_a_line_of_more_than_128_characters_is_cut(bench: Bench) -> None:
    said = say(bench, "ECHO " + "x" * 200, ms=200)
    assert said == "x" * 123 + ">ok\r\n>"


def test_nul_and_noise_are_dropped(bench: Bench) -> None:
    assert say(bench, "EC\0H\x7fO\xff h\x80i\n") == "hi>ok\r\n>"


def test_targets_at_1_kHz_are_all_taken() -> None:
    with arm(baud=None) as bench:
        switch_on(bench)
        for step in range(500):
            bench.port("w1").write(b"MOVETO %.3f 0 0 0 0 0 0 20\r" % (step / 25))
            bench.run(ms=1)
        bench.run(ms=1000)
        assert bench.port("w1").read() == b">ok\r\n>" * 500
        assert bench.axis("w1.hip").snapshot().position_deg == pytest.approx(19.96, abs=0.5)


@pytest.mark.parametrize(
    ("text", "reply"),
    [
        ("SET", ">nok(4)\r\n>"),
        ("SET 7 min=3", ">nok(3)\r\n>"),
        ("SET -1 min=3", ">nok(3)\r\n>"),
        ("SET 0 min=nan", ">nok(3)\r\n>"),
        ("SET 0 min=inf", ">nok(3)\r\n>"),
        ("SET 0 speed=1e9", ">nok(3)\r\n>"),
        ("SET 0 =5", ">nok(3)\r\n>"),
        ("SET 0 min", ">nok(3)\r\n>"),
        ("SET 0 acc=-700", ">ok\r\n>"),
        ("SET 0 speed=0", ">ok\r\n>"),
        ("SET 5 speed=3", ">ok\r\n>"),
        ("MOVETO 1 2 3 4 5 6 7", ">nok(4)\r\n>"),
        ("MOVETO 1 2 3 4 5 6 nan 100", ">nok(4)\r\n>"),
        ("MOVETO a b c d e f g 70000", ">ok\r\n>"),
        ("STEP 0 nan", ">nok(3)\r\n>"),
        ("KNOB 8", ">nok(3)\r\n>"),
    ],
)
def test_nonsense_gets_the_boards_answer(bench: Bench, text: str, reply: str) -> None:
    assert say(bench, text) == reply
    say(bench, "SETUP", ms=700)
    say(bench, "MOVETO 10 10 10 10 10 10 10 100", ms=300)
    assert say(bench, "ECHO lives") == "lives>ok\r\n>"
    assert bench.device("w1").failed is None


def test_replies_take_the_time_of_the_line(bench: Bench) -> None:
    bench.port("w1").write(b"ECHO a\r")
    begun_ns = bench.now_ns
    bench.run(ms=20)
    (at_ns, _), *_ = bench.port("w1").read_timed()
    assert 7 * 86_805 <= at_ns - begun_ns <= 7 * 86_806 + 20_000


def test_print_switches_checksums_on(bench: Bench) -> None:
    bench.port("w1.printer").read()
    assert say(bench, "PRINT \\ba\\b", ms=200) == ">ok\r\n>"
    assert bench.port("w1.printer").read() == b" \x1b!\x08a\x1b!\x00"
    assert say(bench, "ECHO a") == "chksum expected>nok(1)\r\n>"
    assert say(bench, "CHECKSUM off") == ">ok\r\n>"


def test_lights_show_what_it_does(bench: Bench) -> None:
    switch_on(bench)
    levels = bench.device("w1").do("lights")
    assert (levels["channel_2"], levels["channel_9"], levels["channel_7"]) == (100, 74, 0)


# ---- what the article says otherwise ----


def test_only_a_set_up_closes_the_servos_relay_again(bench: Bench) -> None:
    switch_on(bench)
    assert say(bench, "POWER off") == ">ok\r\n>"
    assert "powered" not in say(bench, "INFO")
    say(bench, "POWER on")
    assert "powered" in say(bench, "INFO")
    assert say(bench, "ENABLE", ms=3900) == ""
    bench.run(ms=300)
    assert bench.port("w1").read() == b">ok\r\n>"
    say(bench, "SETUP", ms=600)
    say(bench, "POWER on")
    assert say(bench, "ENABLE") == ">ok\r\n>"


def test_a_forced_set_up_can_fail_and_takes_the_power_away() -> None:
    with arm() as bench:
        switch_on(bench)
        bench.fault("bus_no_answer", "w1.forearm")
        assert "nok(" in say(bench, "SETUP force", ms=1000)
        assert "powered" not in say(bench, "INFO")


def test_a_joint_is_sampled_each_20_ms(bench: Bench) -> None:
    switch_on(bench)
    bench.port("w1").write(b"MOVETO 20 0 0 0 0 0 0 1000\r")
    rates = []
    for _ in range(500):
        bench.run(ms=1)
        rates.append(bench.axis("w1").snapshot().drive_integral)
    changes = [at for at, (before, after) in enumerate(pairwise(rates)) if before != after]
    assert len(changes) == pytest.approx(500 / 20, abs=2)
