"""Runs with real boards among their axes: here they are twins of another daemon, behind their ports."""

import json
from pathlib import Path
from typing import Any

import pytest
from e2e_support import Place, config, until

RULES = {"velocity_rpm": 120.0, "acceleration_rpm_per_s": 1200.0, "jerk_rpm_per_s2": 1e5}


def real(profile: str, at: Path, **keys: float) -> dict[str, Any]:
    """Real board of a configuration. Beside other work it is as slow as one behind a network."""
    return {"profile": profile, "at": str(at), "line_delay_ms": 3000} | keys


def traffic(row: dict[str, Any]) -> dict[str, Any]:
    """Counters of a port's bytes and clients in a row of ``status``."""
    return {
        key: value for key, value in row.items() if key.endswith("_bytes") or key in ("clients", "connects")
    }


class Pair:
    """A daemon whose twins m8 and s8 stand for real boards, and one whose m2 and s2 they are, beside its
    own twin m1."""

    def __init__(self, place: Place) -> None:
        self.place = place
        self.far = place.serve(config(speed=1, devices={"m8": {}, "s8": {"profile": "sac", "flash": {}}}))
        devices = {
            "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
            "m2": real("mechaduino", place.runtime / "t" / "m8", setpoint_rate_Hz=40),
            "s2": real("sac", place.runtime / "t" / "s8"),
        }
        self.near = place.serve(json.dumps({"bench": "r", "devices": devices}), bench="r")
        self.far.ready("m8")
        self.near.ready("m1")

    def taken(self) -> "Pair":
        self.do("m1", "enable")
        self.do("m2", "enable")
        self.do("s2", "reset")
        return self

    def do(self, device: str, verb: str, **parameters: Any) -> Any:
        return self.near.ask("do", device=device, name=verb, parameters=parameters)

    def submit(self, name: str, *steps: dict[str, Any], **top: Any) -> Any:
        axes = {axis: RULES for axis in ("m1", "m2", "s2")}
        text = json.dumps({"run": name, "axes": axes, "steps": list(steps)} | top)
        return self.near.ask("run", text=text, file="r.yaml", check=False)

    def state(self, name: str) -> dict[str, Any]:
        (progress,) = self.near.ask("runs", name=name)
        assert isinstance(progress, dict)
        return progress

    def ended(self, name: str) -> dict[str, Any]:
        until(lambda: self.state(name)["state"] not in ("queued", "running"), f"the end of {name}")
        return self.state(name)

    def under_way(self, *axes: str) -> None:
        """Submit a long run, ``a``, of these axes, and wait until the far twins have come some way."""
        taken = self.submit("a", {"move": dict.fromkeys(axes, 7200.0)}, axes=dict.fromkeys(axes, RULES))
        assert "problems" not in taken, taken
        self.come_some_way()

    def turn(self, device: str) -> None:
        """Let a twin turn."""
        self.do(device, "velocity", velocity_rpm=60)
        until(lambda: self.near.status(device)["snapshot"]["velocity_rpm"] > 30, "its turning")

    def come_some_way(self) -> None:
        def shown() -> bool:
            state = self.state("a")
            assert state["state"] in ("queued", "running"), self.why(state)
            return self.shaft("s8")["pulses"] > 20 and self.shaft("m8")["yw"] > 40

        until(shown, "some way")

    def perform(self, name: str, *steps: dict[str, Any], **top: Any) -> dict[str, Any]:
        answer = self.submit(name, *steps, **top)
        assert "problems" not in answer, answer
        return self.ended(name)

    def why(self, state: dict[str, Any]) -> str:
        """Reason of a run's end, the health of both daemons, and the traffic at both ends of the lines."""
        said = [str(state["why"])]
        for server, names in ((self.near, ("m2", "s2")), (self.far, ("m8", "s8"))):
            said.append(str(server.ask("status")["health"]))
            said += (f"{name}: {traffic(server.status(name))}" for name in names)
        return "; ".join(said)

    def shaft(self, device: str) -> dict[str, Any]:
        """State of the far twin, which no terminal tells."""
        snapshot: dict[str, Any] = self.far.status(device)["snapshot"]
        return snapshot


@pytest.fixture
def pair(place: Place) -> Pair:
    return Pair(place)


def test_real_boards_move_beside_a_twin(pair: Pair) -> None:
    pair.taken()
    done = pair.perform(
        "a",
        {"move": {"m1": 0.0, "m2": 0.0}},
        {"move": {"m1": 90.0, "m2": 90.0, "s2": 90.0}},
        {"line": {"m1": 180.0, "m2": 45.0}},
        {"spline": [{"m1": 90.0, "m2": 10.0}, {"m1": 0.0, "m2": 30.5}]},
        {"move_by": {"s2": -45.0}},
    )
    assert done["state"] == "done", pair.why(done)
    assert done["step"] == done["steps"] == 5
    assert pair.shaft("m8")["r"] == pytest.approx(30.5, abs=0.001)
    assert pair.shaft("m8")["yw"] == pytest.approx(30.5, abs=0.2)
    assert pair.shaft("s8")["commanded_deg"] == pytest.approx(45.0)
    for axis, commanded_deg in (("m2", 30.5), ("s2", 45.0)):
        report = done["axes"][axis]
        assert report["commanded_deg"] == pytest.approx(commanded_deg)
        assert (report["position_deg"], report["error_max_deg"], report["error_rms_deg"]) == (None,) * 3
    assert done["axes"]["m1"]["error_max_deg"] < 5
    # The count goes on: where the second run finds the boards is where the first one left them.
    done = pair.perform("b", {"move": {"s2": 0.0, "m2": 0.0}})
    assert done["state"] == "done", pair.why(done)
    assert pair.shaft("s8")["commanded_deg"] == pytest.approx(0.0)
    text = pair.place.write(
        json.dumps({"run": "c", "axes": {"s2": {}}, "steps": [{"move": {"s2": 9}}]}), "c.yaml"
    )
    said = pair.place.cli("run", str(text), "--bench", "r", "--runtime-dir", str(pair.place.runtime))
    assert "set-point 9.00 deg (its terminal tells no position), planned 9.00" in said


@pytest.mark.thorough
def test_what_cannot_be_is_found_before_anything_moves(pair: Pair) -> None:
    problems = pair.submit("a", {"move": {"m1": 1.0}})["problems"]
    assert "axes.m2: what this real board does is not known (`hil axis m2 enable` first)" in problems
    assert "axes.s2: what this real board does is not known (`hil axis s2 reset` first)" in problems
    pair.taken()
    steps = (
        {"line": {"s2": 1.0}},
        {"wait_until": {"axis": "m2", "field": "yw", "above": 1.0}},
        {"pins": {"s2.sync": 1}},
    )
    problems = pair.submit("a", *steps)["problems"]
    for said in (
        "steps.0.line.s2: s2 makes ramps of its own, and keeps to no line or spline",
        "steps.1.wait_until.field: m2 has no 'yw' (there are none)",
        "steps.2.pins.'s2.sync': s2 has no input 'sync' (there are none)",
    ):
        assert said in problems
    problems = pair.submit("a", {"move": {"m2": 1.0}}, axes={"m2": {"following_error_deg": 5.0}})["problems"]
    assert "axes.m2.following_error_deg: m2 is a real board, whose terminal tells no position" in problems
    with pair.near.client("s2") as terminal:
        terminal.ask(b"vd\r", b"0\t0\r\nSAC>")
    problems = pair.submit("a", {"move": {"s2": 1.0}})["problems"]
    assert "axes.s2: what this real board does is not known" in problems
    assert "axes.m2" not in problems
    pair.far.stop()
    until(lambda: "is away" in pair.submit("a", {"move": {"m2": 1.0}})["problems"], "the loss")


@pytest.mark.thorough
def test_what_programs_type_waits_for_the_runs_end(pair: Pair) -> None:
    pair.taken()
    pair.submit("a", {"move": {"m2": 300.0, "s2": 300.0}})
    until(lambda: pair.shaft("s8")["motion_state"], "its motion")
    with pair.near.client("s2") as terminal:
        terminal.write(b"vd\r")
        for verb in ("reset", "type"):
            parameters = {"text": "x"} if verb == "type" else {}
            answer = pair.place.cli(
                "axis",
                "s2",
                verb,
                *parameters.values(),
                "--bench",
                "r",
                "--runtime-dir",
                str(pair.place.runtime),
                code=1,
            )
            assert "s2: a run has this board" in answer
        assert pair.ended("a")["state"] == "done"
        terminal.read_until(b"vd\r\n0\t0\r\nSAC>")


@pytest.mark.thorough
@pytest.mark.parametrize("how", ["grace", "prejudice"])
def test_a_run_that_is_cancelled_stops_them(pair: Pair, how: str) -> None:
    pair.taken()
    pair.under_way("m1", "m2", "s2")
    pair.near.ask("cancel_run", name="a", how=how)
    done = pair.ended("a")
    assert (done["state"], done["axes"]["s2"]["commanded_deg"]) == ("cancelled", None)
    assert pair.shaft("s8")["motion_state"] == 0
    stopped_deg = done["axes"]["m2"]["commanded_deg"]
    assert 40 < stopped_deg < 3000, done
    assert pair.shaft("m8")["r"] == pytest.approx(stopped_deg, abs=0.001)
    assert pair.perform("b", {"move": {"m2": 0.0}}, axes={"m2": RULES})["state"] == "done"
    assert "`hil axis s2 reset` first" in pair.submit("c", {"move": {"s2": 0.0}})["problems"]


@pytest.mark.thorough
def test_a_board_that_goes_away_fails_the_run_and_stops_the_others(pair: Pair) -> None:
    pair.taken()
    pair.under_way("m1", "m2", "s2")
    before_ns = pair.near.ask("status")["sim_ns"]
    pair.far.kill()
    done = pair.ended("a")
    assert done["state"] == "failed"
    assert done["why"].split()[0] in ("m2", "s2")
    assert "is away" in done["why"]
    assert done["ended_at_ns"] - before_ns < 4_000_000_000  # a ramp of 0.1 s, and asking beside other work
    assert done["axes"]["m1"]["position_deg"] < 3000
    assert pair.near.status("m1")["snapshot"]["following"] == 0


@pytest.mark.thorough
def test_a_board_that_falls_silent_fails_the_run(pair: Pair) -> None:
    """The line stays, and nothing comes any more: as of a board without power behind an adapter."""
    pair.taken()
    pair.under_way("m1", "m2", "s2")
    before_ns = pair.near.ask("status")["sim_ns"]
    pair.near.ask("inject", fault="byte_drop", target="m2", parameters={"rate": 1, "towards": "client"})
    done = pair.ended("a")
    assert (done["state"], done["axes"]["m2"]["commanded_deg"]) == ("failed", None)
    assert done["why"].startswith('m2 stopped: "r')
    assert "was not answered" in done["why"]
    assert done["ended_at_ns"] - before_ns < 9_000_000_000  # 3.5 s for an answer, and 0.1 s of a ramp
    assert pair.near.status("m1")["snapshot"]["following"] == 0
    assert pair.shaft("s8")["motion_state"] == 0


@pytest.mark.thorough
def test_a_twins_fault_stops_real_boards(pair: Pair) -> None:
    pair.taken()
    axes = {"m1": RULES | {"following_error_deg": 10.0}, "m2": RULES, "s2": RULES}
    pair.submit("a", {"move": dict.fromkeys(axes, 7200.0)}, axes=axes)
    pair.come_some_way()
    pair.near.ask("inject", fault="shaft_jam", target="m1", parameters={})
    done = pair.ended("a")
    assert (done["state"], done["why"].split()[0]) == ("failed", "m1"), pair.why(done)
    assert pair.shaft("s8")["motion_state"] == 0
    assert pair.shaft("m8")["r"] == pytest.approx(done["axes"]["m2"]["commanded_deg"], abs=0.001)
    assert pair.shaft("m8")["r"] < 3000


@pytest.mark.thorough
def test_the_daemons_end_stops_them(pair: Pair) -> None:
    pair.taken()
    pair.under_way("m2", "s2")
    pair.near.stop()
    until(lambda: pair.shaft("s8")["motion_state"] == 0, "its stand")
    assert pair.shaft("s8")["commanded_deg"] < 7200
    r = pair.shaft("m8")["r"]
    assert 40 < r < 3000


def test_stop_all_stops_real_boards_that_move_by_themselves(pair: Pair) -> None:
    pair.taken()
    stands = pair.near.ask("halt", how="grace")
    assert stands == {"stopped": [], "runs": [], "refused": {}}  # each is where it was told to be
    pair.turn("m1")
    pair.near.ask("send", device="m2", data=b"vr60\n".hex())
    pair.near.ask("send", device="s2", data=b"m20000v60ad\r".hex())
    until(lambda: pair.shaft("s8")["pulses"] > 20 and pair.shaft("m8")["yw"] > 40, "some way")
    answer = pair.near.ask("halt", how="grace")
    assert (sorted(answer["stopped"]), answer["runs"]) == (["m1", "s2"], [])
    assert "`hil axis m2 disable` takes its current off" in answer["refused"]["m2"]
    assert pair.shaft("s8")["motion_state"] == 0
    assert pair.shaft("s8")["pulses"] < 20000
    assert "m2" in pair.near.ask("halt", how="prejudice")["stopped"]
    until(lambda: abs(pair.shaft("m8")["velocity_rpm"]) < 1, "its stand")


@pytest.mark.thorough
def test_stop_all_ends_a_run_with_real_boards(pair: Pair) -> None:
    pair.taken()
    pair.under_way("m1", "m2", "s2")
    answer = pair.near.ask("halt", how="grace")
    assert (sorted(answer["stopped"]), answer["runs"], answer["refused"]) == (["m1", "m2", "s2"], ["a"], {})
    assert pair.ended("a")["state"] == "cancelled"
    assert pair.shaft("s8")["motion_state"] == 0
    assert 40 < pair.shaft("m8")["r"] < 3000


@pytest.mark.thorough
def test_stop_all_says_which_board_has_not_confirmed_it_and_stops_the_others(pair: Pair) -> None:
    pair.taken()
    pair.turn("m1")
    pair.near.ask("send", device="s2", data=b"m20000v60ad\r".hex())
    until(lambda: pair.shaft("s8")["pulses"] > 20, "some way")
    pair.near.ask("inject", fault="byte_drop", target="s2", parameters={"rate": 1, "towards": "client"})
    answer = pair.near.ask("halt", how="grace")
    assert answer["stopped"] == ["m1"]
    assert list(answer["refused"]) == ["s2"]
    until(lambda: pair.shaft("s8")["motion_state"] == 0, "its stand: it heard, and was not heard")
