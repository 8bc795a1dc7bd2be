"""Set-point time-out: it stops the axis to the nanosecond, with each policy, on both boards."""

from typing import Any

import pytest

from hil.testing import Bench
from hil.vocab.time import NS_PER_MS

AFTER_MS = 12.345678
AFTER_NS = 12_345_678
NOTE = "set-points"


def make(profile: str, policy: str = "hold", after_ms: float = AFTER_MS, **more: Any) -> Bench:
    device = {
        "profile": profile,
        "port": "memory",
        "flash": {"table": "identity"} if profile == "mechaduino" else {},
        "setpoints": {"timeout_ms": after_ms, "policy": policy, **more},
    }
    bench = Bench({"bench": "t", "devices": {"d": device}})
    bench.run(4500)
    if profile == "mechaduino":
        bench.axis("d").do("enable")
        bench.run(500)
    bench.port("d").read()
    return bench


def to_ns(bench: Bench, at_ns: int) -> Any:
    bench.run((at_ns - bench.now_ns) / NS_PER_MS)
    assert bench.now_ns == at_ns
    assert bench.device("d").failed is None
    return bench.axis("d").snapshot()


def note(bench: Bench) -> str | None:
    return bench.device("d").notes.get(NOTE)


STREAMS = [
    ("position", {"position_deg": 40.0}),
    ("velocity", {"velocity_rpm": 30.0}),
    ("torque", {"effort_count": 15.0}),
]


@pytest.mark.parametrize(("verb", "parameters"), STREAMS)
def test_hold_keeps_the_angle_of_the_moment(verb: str, parameters: dict[str, float]) -> None:
    bench = make("mechaduino")
    armed_ns = bench.axis("d").do(verb, **parameters)["effective_at_ns"]
    before = to_ns(bench, armed_ns + AFTER_NS - 1)
    assert (before.r, note(bench)) == (next(iter(parameters.values())), None)
    state = to_ns(bench, armed_ns + AFTER_NS)
    assert (state.mode, state.loop_on) == (ord("x"), 1)
    assert abs(state.r - state.position_deg) < 0.05
    assert note(bench) == "no set-point for 12.3457 ms: hold (1 times)"
    assert to_ns(bench, armed_ns + 10 * AFTER_NS).r == state.r
    assert note(bench) == "no set-point for 12.3457 ms: hold (1 times)"


def test_decelerate_begins_its_ramp_at_the_moment() -> None:
    bench = make("mechaduino", "decelerate", acceleration_rpm_per_s=300.0)
    armed_ns = bench.axis("d").do("velocity", velocity_rpm=60.0)["effective_at_ns"]
    assert to_ns(bench, armed_ns + AFTER_NS - 1).following == 0
    state = to_ns(bench, armed_ns + AFTER_NS)
    assert (state.following, state.r) == (1, 60.0)
    state = to_ns(bench, armed_ns + AFTER_NS + 100 * NS_PER_MS)
    assert 30.0 <= state.r < 30.1  # of the latest control step
    state = to_ns(bench, armed_ns + AFTER_NS + 201 * NS_PER_MS)
    assert (state.following, state.r, state.mode, state.loop_on) == (0, 0.0, ord("v"), 1)


def test_decelerate_lets_a_position_stand_and_an_effort_go() -> None:
    for verb, parameters in STREAMS[::2]:
        bench = make("mechaduino", "decelerate")
        armed_ns = bench.axis("d").do(verb, **parameters)["effective_at_ns"]
        assert to_ns(bench, armed_ns + AFTER_NS - 1).r == next(iter(parameters.values()))
        r = to_ns(bench, armed_ns + AFTER_NS + NS_PER_MS).r
        assert r == (40.0 if verb == "position" else 0.0)
        assert note(bench)


def test_torque_off_takes_the_current_off_at_the_moment() -> None:
    bench = make("mechaduino", "torque_off")
    armed_ns = bench.axis("d").do("torque", effort_count=15.0)["effective_at_ns"]
    before = to_ns(bench, armed_ns + AFTER_NS - 1)
    assert (before.loop_on, max(before.vref1, before.vref2) > 0) == (1, True)
    state = to_ns(bench, armed_ns + AFTER_NS)
    assert (state.loop_on, state.vref1, state.vref2) == (0, 0, 0)
    assert note(bench) == "no set-point for 12.3457 ms: torque_off (1 times)"


def test_a_sac_stops_at_the_moment() -> None:
    for policy in ("hold", "torque_off"):
        bench = make("sac", policy, after_ms=800.000001)
        armed_ns = bench.axis("d").do("velocity", velocity_rpm=60)["effective_at_ns"]
        assert to_ns(bench, armed_ns + 800_000_000).motion_state != 0
        state = to_ns(bench, armed_ns + 800_000_001)
        assert state.motion_state == 0
        assert note(bench) == f"no set-point for 800 ms: {policy} (1 times)"
        assert to_ns(bench, armed_ns + 2_000_000_000).pulses == state.pulses


def test_a_sac_slows_down_with_its_own_ramp() -> None:
    bench = make("sac", "decelerate", after_ms=800)
    armed_ns = bench.axis("d").do("velocity", velocity_rpm=200)["effective_at_ns"]
    before = to_ns(bench, armed_ns + 799_999_999)
    after = to_ns(bench, armed_ns + 800_000_000 + 50 * NS_PER_MS)
    assert before.motion_state in (1, 2)
    assert after.motion_state == 3
    typed = make("sac", after_ms=3_000_000)
    typed.axis("d").do("velocity", velocity_rpm=200)
    typed.run(800)
    typed.axis("d").do("stop")  # as by hand
    for each in (bench, typed):
        each.run(5000)
    assert bench.axis("d").snapshot().pulses == typed.axis("d").snapshot().pulses > before.pulses


def test_each_set_point_waits_anew_for_the_next() -> None:
    bench = make("mechaduino")
    axis = bench.axis("d")
    for _ in range(20):
        armed_ns = axis.do("velocity", velocity_rpm=30.0)["effective_at_ns"]
        assert to_ns(bench, armed_ns + AFTER_NS - 1).mode == ord("v")
    assert to_ns(bench, armed_ns + AFTER_NS).mode == ord("x")
    assert note(bench)
    axis.do("velocity", velocity_rpm=30.0)
    assert note(bench) is None
    bench.run(AFTER_MS)
    assert note(bench) == "no set-point for 12.3457 ms: hold (2 times)"


def test_a_set_point_of_the_very_moment_is_too_late_and_holds_from_then() -> None:
    bench = make("mechaduino")
    armed_ns = bench.axis("d").do("velocity", velocity_rpm=30.0)["effective_at_ns"]
    to_ns(bench, armed_ns + AFTER_NS)
    bench.axis("d").do("velocity", velocity_rpm=20.0)
    assert (bench.axis("d").snapshot().r, note(bench)) == (20.0, None)


def test_one_that_was_refused_waits_for_nothing_and_changes_no_waiting() -> None:
    bench = make("mechaduino")
    axis = bench.axis("d")
    armed_ns = axis.do("velocity", velocity_rpm=30.0)["effective_at_ns"]
    bench.run(5)
    with pytest.raises(Exception, match="write -3000 to 3000"):
        axis.do("velocity", velocity_rpm=1e9)
    assert to_ns(bench, armed_ns + AFTER_NS).mode == ord("x")
    axis.do("disable")
    with pytest.raises(Exception, match="loop is off"):
        axis.do("velocity", velocity_rpm=30.0)
    bench.run(1000)
    assert note(bench) is None


@pytest.mark.parametrize(
    ("verb", "parameters"),
    [
        ("move_abs", {"position_deg": 3600.0}),
        ("move_rel", {"angle_deg": 3600.0}),
        ("stop", {"how": "prejudice"}),
        ("mode", {"mode": "torque"}),
        ("enable", {}),
        ("disable", {}),
    ],
)
def test_other_motions_end_the_waiting(verb: str, parameters: dict[str, Any]) -> None:
    bench = make("mechaduino", "torque_off")
    bench.axis("d").do("velocity", velocity_rpm=30.0)
    bench.run(5)
    bench.axis("d").do(verb, **parameters)
    bench.run(200)
    assert note(bench) is None
    assert bench.axis("d").snapshot().loop_on == (verb != "disable")


@pytest.mark.parametrize(
    ("verb", "parameters"), [("move_rel", {"angle_deg": 36.0}), ("stop", {}), ("run", {"position": 1})]
)
def test_other_motions_of_a_sac_end_the_waiting(verb: str, parameters: dict[str, Any]) -> None:
    bench = make("sac", after_ms=300)
    bench.axis("d").do("velocity", velocity_rpm=30)
    bench.run(100)
    bench.axis("d").do(verb, **parameters)
    bench.run(1000)
    assert note(bench) is None


def test_gains_and_pulses_neither_begin_nor_end_it() -> None:
    bench = make("mechaduino")
    axis = bench.axis("d")
    axis.do("gains", pKp=14.0)
    bench.run(100)
    assert note(bench) is None
    armed_ns = axis.do("velocity", velocity_rpm=30.0)["effective_at_ns"]
    bench.run(5)
    axis.do("gains", pKp=15.0)
    assert to_ns(bench, armed_ns + AFTER_NS - 1).mode == ord("v")
    assert to_ns(bench, armed_ns + AFTER_NS).mode == ord("x")


def test_a_reset_ends_it() -> None:
    bench = make("mechaduino")
    bench.axis("d").do("velocity", velocity_rpm=30.0)
    bench.run(5)
    bench.device("d").reset()
    bench.run(1000)
    assert note(bench) is None


def test_what_was_never_begun_never_fires() -> None:
    bench = make("mechaduino", "torque_off")
    bench.axis("d").do("move_abs", position_deg=720.0)
    bench.port("d").write(b"vr30\n")
    bench.run(10_000)
    assert note(bench) is None
    assert bench.axis("d").snapshot().loop_on == 1


@pytest.mark.parametrize("typed", [b"c", b"j", b"q", b"k", b"r"])
def test_it_is_as_exact_while_the_firmware_is_busy(typed: bytes) -> None:
    # c and j are in delays for seconds; k and r wait for what is typed next.
    bench, quiet = make("mechaduino", "torque_off"), make("mechaduino", "torque_off")
    armed_ns = bench.axis("d").do("torque", effort_count=15.0)["effective_at_ns"]
    for each in (bench, quiet):
        each.run(3)
        each.port("d").write(typed)
    assert to_ns(bench, armed_ns + AFTER_NS - 1).loop_on == 1
    assert to_ns(bench, armed_ns + AFTER_NS).loop_on == 0
    for each in (bench, quiet):
        each.run(9000)
    if typed == b"c":
        return  # what it prints depends on how the shaft turns
    times = [[at_ns for at_ns, _ in each.port("d").read_timed()] for each in (bench, quiet)]
    assert times[0] == times[1]  # what the main program does, and when, is the same


def test_on_a_slow_line_the_time_out_changes_no_byte() -> None:
    def run(has_time_out: bool) -> list[tuple[int, bytes]]:
        device: dict[str, Any] = {"profile": "sac", "port": "memory"}
        if has_time_out:
            device["setpoints"] = {"timeout_ms": 100.0, "policy": "hold"}
        bench = Bench({"bench": "t", "devices": {"d": device}})
        bench.run(1500)
        bench.axis("d").do("velocity", velocity_rpm=30)
        bench.run(98)
        for byte in b"cc\r":
            bench.port("d").write(bytes([byte]))
            bench.run(0.27)
        bench.run(3000)
        return list(bench.port("d").timeline)

    assert run(True) == run(False)


def test_two_on_one_wire_wait_each_for_their_own() -> None:
    device: dict[str, Any] = {"profile": "mechaduino", "port": "memory", "flash": {"table": "identity"}}
    devices = {
        "d": device | {"setpoints": {"timeout_ms": AFTER_MS, "policy": "hold"}},
        "e": device | {"setpoints": {"timeout_ms": 20.5, "policy": "torque_off"}},
        "s": {"profile": "sac", "port": "memory"},
    }
    wires = [{"from": "s.clk", "to": "d.step"}, {"from": "s.dir", "to": "e.dir"}]
    bench = Bench({"bench": "t", "devices": devices, "wires": wires})
    bench.run(4500)
    for name in "de":
        bench.axis(name).do("enable")
    bench.run(300)
    armed_ns = [bench.axis(name).do("velocity", velocity_rpm=30.0)["effective_at_ns"] for name in "de"]
    assert armed_ns[0] == armed_ns[1]
    assert to_ns(bench, armed_ns[0] + AFTER_NS - 1).mode == ord("v")
    assert to_ns(bench, armed_ns[0] + AFTER_NS).mode == ord("x")
    to_ns(bench, armed_ns[0] + 20_500_000 - 1)
    assert bench.axis("e").snapshot().loop_on == 1
    to_ns(bench, armed_ns[0] + 20_500_000)
    assert bench.axis("e").snapshot().loop_on == 0


def test_a_speed_that_was_typed_meanwhile_does_not_stop_the_board() -> None:
    bench = make("mechaduino", "decelerate", after_ms=300, acceleration_rpm_per_s=0.01)
    bench.axis("d").do("velocity", velocity_rpm=30.0)
    bench.port("d").write(b"r1999999999\n")
    bench.run(1000)
    assert bench.device("d").failed is None
    assert bench.axis("d").snapshot().r == 0.0
    assert note(bench)
