"""Real CANopen drives as axes: here each is the twin of another daemon, on its CAN bus, reached through an
adapter (slcan) or over a channel of python-can (udp_multicast); both are configured as a user does it."""

import json
import os
import re
import subprocess
import sys
from typing import Any

import pytest
from e2e_support import Place, Server, free_port, until

from hil.net.control_client import ControlError

RULES = {"velocity_rpm": 60.0, "acceleration_rpm_per_s": 600.0, "jerk_rpm_per_s2": 1e5}
M1 = {"profile": "mechaduino", "flash": {"table": "identity"}}
DRIVE = {"profile": "canopen_drive"}
NODES = {"d8": 5, "d9": 6}


class CanPair:
    """A daemon with the twins d8 and d9 as nodes 5 and 6 of its bus, and one to which they are the real
    drives x and y, beside its own twin m1. ``over``: slcan, at TCP or at a pseudo-terminal, or
    udp_multicast; ``master``: the drives watch the daemon; ``twins``: their devices."""

    def __init__(
        self, place: Place, over: str, master: str = "", twins: tuple[dict[str, Any], ...] = (DRIVE, DRIVE)
    ) -> None:
        self.place, self.master = place, master
        port = free_port()
        bus: dict[str, Any] = {"bit_rate": 1_000_000, "nodes": NODES}
        far: dict[str, Any] = {
            "bench": "far",
            "devices": dict(zip(NODES, twins, strict=True)),
            "can": {"can0": bus},
        }
        self.at = f"can+slcan://127.0.0.1:{port}?bitrate=1000000"
        self.where = f"socket://127.0.0.1:{port}"
        if over == "slcan_pty":
            bus["taps"] = {"adapter": {}}
            path = str(place.runtime / "far" / "can0.adapter")
            self.at, self.where = f"can+slcan://{path}?bitrate=1000000", path
        elif over == "slcan":
            bus["taps"] = {"adapter": {"port": {"kind": "tcp", "listen": port}}}
        else:
            group = f"239.74.{os.getpid() % 250}.{port % 250}"
            channel = {"interface": "udp_multicast", "channel": group, "port": port}
            far["bridges"] = {"can": {"channels": {"can0": channel}}}
            self.at = f"can+udp_multicast://{group}:{port}"
            self.where = f"{group}:{port}"
        self.far_text = json.dumps(far)
        self.far = self.serve_far()
        self.devices: dict[str, Any] = {
            "m1": M1,
            **{name: self.real(NODES[twin]) for name, twin in (("x", "d8"), ("y", "d9"))},
        }
        self.near = place.serve(self.configure(), bench="r")
        self.near.ready("m1")
        until(lambda: self.is_there("x") and self.is_there("y"), "the drives")

    def serve_far(self) -> Server:
        return self.place.serve(self.far_text, bench="far").ready("d8", boot_ns=300_000_000)

    def real(self, node: int) -> dict[str, Any]:
        query = "&" if "?" in self.at else "?"
        at = f"{self.at}{query}node={node}{self.master}"
        # Three periods without a SYNC are a loss to the twin: on a busy computer its daemon hears them late.
        # Its answers take longer there, too.
        return DRIVE | {"at": at, "setpoint_rate_Hz": 4, "line_delay_ms": 800}

    def configure(self) -> str:
        """Write the near bench's configuration, and return it."""
        text = json.dumps({"bench": "r", "devices": self.devices})
        self.place.write(text, "r.yaml")
        return text

    def is_there(self, name: str) -> bool:
        return bool(self.near.status(name)["drive"]["state"] == "there")

    def do(self, device: str, verb: str, **parameters: Any) -> Any:
        return self.near.ask("do", device=device, name=verb, parameters=parameters)

    def enabled(self) -> "CanPair":
        for device in ("m1", "x", "y"):
            self.do(device, "enable")
        return self

    def submit(self, name: str, *steps: dict[str, Any], axes: tuple[str, ...] = ("m1", "x", "y")) -> None:
        text = json.dumps({"run": name, "axes": dict.fromkeys(axes, RULES), "steps": list(steps)})
        answer = self.near.ask("run", text=text, file="r.yaml", check=False)
        assert "problems" not in answer, answer

    def progress(self, name: str) -> dict[str, Any]:
        (found,) = self.near.ask("runs", name=name)
        assert isinstance(found, dict)
        return found

    def ended(self, name: str) -> dict[str, Any]:
        until(lambda: self.progress(name)["state"] not in ("queued", "running"), f"the end of {name}")
        return self.progress(name)

    def far_deg(self, twin: str) -> float:
        return float(self.far.status(twin)["snapshot"]["yw"])


@pytest.fixture
def pair(place: Place, request: pytest.FixtureRequest) -> CanPair:
    return CanPair(place, request.param)


def over(*ways: str) -> pytest.MarkDecorator:
    """Run a test with drives that are reached in each of these ways."""
    return pytest.mark.parametrize("pair", ways, indirect=True)


@pytest.mark.thorough
@over("slcan", "slcan_pty", "udp_multicast")
def test_drives_move_by_verbs_and_in_a_run_beside_a_twin(pair: CanPair) -> None:
    place = pair.place
    assert "its loop is off; enable it first" in place.cli("axis", "x", "move-abs", "90", "-b", "r", code=1)
    place.cli("axis", "x", "enable", "-b", "r")
    assert "set_point: 90" in place.cli("axis", "x", "move-abs", "90", "velocity_rpm=120", "-b", "r")
    until(lambda: abs(pair.far_deg("d8") - 90) < 0.5, "90 deg")
    pair.enabled()
    pair.submit(
        "a",
        {"move": {"m1": 90.0, "x": 45.0, "y": 30.0}},
        {"line": {"m1": 0.0, "x": 180.0, "y": 90.0}},
        {"move_by": {"x": -90.0, "y": -60.0}},
    )
    done = pair.ended("a")
    assert done["state"] == "done", done["why"]
    assert (pair.far_deg("d8"), pair.far_deg("d9")) == (
        pytest.approx(90, abs=0.5),
        pytest.approx(30, abs=0.5),
    )
    assert done["axes"]["x"]["commanded_deg"] == 90.0
    assert done["axes"]["x"]["error_max_deg"] < 45
    row = pair.near.status("x")
    assert (row["hardware"], row["note"]) == ("real", None)
    assert row["snapshot"]["age_ms"] < 5000
    assert row["drive"]["identity"]["vendor"]
    rows = {each["name"] for each in pair.near.ask("registers", device="x")["rows"]}
    assert {"position", "statusword", "emergencies", "move_abs.position_deg"} <= rows
    assert "x: there, read" in place.cli("status", "-b", "r")


@pytest.mark.thorough
@over("slcan", "udp_multicast")
def test_a_run_fails_when_its_drive_is_lost_and_nothing_is_sent_afterwards(pair: CanPair) -> None:
    pair.enabled()
    pair.submit("a", {"move": {"m1": 7200.0, "x": 7200.0}}, axes=("m1", "x"))
    until(lambda: pair.far_deg("d8") > 40, "some way")
    pair.far.kill()
    failed = pair.ended("a")
    assert failed["state"] == "failed"
    # The silence is noticed by the run or by the link, whichever looks first.
    why = rf"x stopped: the drive at {re.escape(pair.where)}, node 5 (is lost: |has told nothing for )"
    assert re.search(why, failed["why"]), failed["why"]
    assert failed["axes"]["m1"]["at_end"] == "stands"
    assert any(problem["about"] == "x" for problem in pair.near.ask("health")["problems"])
    pair.far = pair.serve_far()
    until(lambda: pair.is_there("x"), "the drive")
    assert pair.near.status("x")["drive"]["reconnects"] == 1
    snapshot = pair.far.status("d8")["snapshot"]
    assert (snapshot["loop_on"], snapshot["following"]) == (0, 0)


@pytest.mark.thorough
@over("slcan_pty")
def test_faults_and_stops_at_the_drive_fail_the_run_and_are_told(pair: CanPair) -> None:
    pair.enabled()
    pair.submit("a", {"move": {"m1": 3600.0, "x": 3600.0}}, axes=("m1", "x"))
    until(lambda: pair.far_deg("d8") > 40, "some way")
    pair.far.ask("set", device="d8", field="errfl", value=1)
    failed = pair.ended("a")
    assert failed["state"] == "failed"
    assert "the drive has fault 7305h (encoder)" in failed["why"]
    until(lambda: "7305h" in (pair.near.status("x")["note"] or ""), "the emergency")
    pair.do("x", "clear_fault")
    pair.do("x", "enable")
    pair.submit("b", {"move_by": {"y": 3600.0}}, axes=("y",))
    until(lambda: pair.far_deg("d9") > 40, "some way")
    assert "a run has this drive" in pair.place.cli("axis", "y", "move-abs", "0", "-b", "r", code=1)
    pair.do("y", "stop")
    failed = pair.ended("b")
    assert (failed["state"], "somebody gave it the verb stop" in failed["why"]) == ("failed", True)
    assert pair.far.status("d9")["snapshot"]["loop_on"] == 1


@pytest.mark.thorough
@over("slcan")
def test_a_reload_exchanges_the_drive_that_changed_and_not_the_other(pair: CanPair) -> None:
    pair.enabled()
    old = pair.near.status("y")["drive"]["polls"]
    pair.devices["x"] |= {"poll_interval_ms": 40}
    pair.configure()
    done = pair.near.ask("reload")
    assert (done["restarted"], done["kept"]) == (["x"], ["m1", "y"])
    until(lambda: pair.is_there("x"), "the drive")
    assert pair.near.status("y")["drive"]["polls"] >= old
    with pytest.raises(ControlError, match="cannot be set"):
        pair.near.ask("set", device="x", field="pKp", value=1.0)
    del pair.devices["y"]
    pair.configure()
    assert pair.near.ask("reload")["removed"] == ["y"]


@pytest.mark.thorough
def test_a_drive_finds_its_origin_by_itself(place: Place) -> None:
    pair = CanPair(place, "udp_multicast").enabled()
    pair.do("x", "move_abs", position_deg=45.0)
    until(lambda: abs(pair.far_deg("d8") - 45) < 0.5, "45 deg")
    pair.place.cli("axis", "x", "home", "method=37", "-b", "r")
    until(lambda: abs(pair.near.status("x")["snapshot"]["position_deg"]) < 0.5, "the origin")
    until(lambda: pair.near.status("x")["snapshot"]["mode"] == 1, "its own hold")
    pair.do("x", "move_abs", position_deg=10.0)
    until(lambda: abs(pair.far_deg("d8") - 55) < 0.5, "10 deg from there")
    with pytest.raises(ControlError, match=r"home: it answered a write to 6098h:00 with abort"):
        pair.do("x", "home", method=17)


@pytest.mark.thorough
def test_a_stepper_makes_ramps_of_its_own_and_a_servo_keeps_to_the_path(place: Place) -> None:
    pair = CanPair(place, "udp_multicast", twins=(M1, {"profile": "sac"})).enabled()
    pair.submit("a", {"move": {"x": 90.0, "y": 30.0}}, {"move_by": {"x": -45.0, "y": 60.0}}, axes=("x", "y"))
    done = pair.ended("a")
    assert done["state"] == "done", done["why"]
    assert pair.far_deg("d8") == pytest.approx(45, abs=0.5)
    assert pair.far.status("d9")["snapshot"]["position_deg"] == pytest.approx(90, abs=2)
    with pytest.raises(AssertionError, match="y makes ramps of its own, and keeps to no line"):
        pair.submit("b", {"line": {"x": 0.0, "y": 0.0}}, axes=("x", "y"))


@pytest.mark.thorough
def test_drives_stop_by_themselves_when_their_master_is_killed(place: Place) -> None:
    pair = CanPair(place, "udp_multicast", master="&master=127").enabled()
    pair.submit("a", {"move": {"x": 36000.0, "y": 36000.0}}, axes=("x", "y"))
    until(lambda: pair.far_deg("d8") > 100, "some way")
    pair.near.kill()
    until(lambda: not pair.far.status("d8")["snapshot"]["loop_on"], "its stop")
    here_deg = pair.far_deg("d8")
    assert here_deg < 10_000
    until(lambda: abs(pair.far.status("d8")["snapshot"]["velocity_rpm"]) < 1, "its stand")


@pytest.mark.thorough
def test_a_node_that_is_bus_off_is_lost_and_comes_back(place: Place) -> None:
    pair = CanPair(place, "udp_multicast").enabled()
    pair.far.ask("inject", fault="bus_off", target="d8.canopen", parameters={})
    until(lambda: not pair.is_there("x"), "its loss")
    until(lambda: pair.is_there("x"), "its return")
    with pytest.raises(ControlError, match=r"fault 8140h \(back from bus-off\); clear it first"):
        pair.do("x", "enable")
    pair.do("x", "clear_fault")
    pair.do("x", "enable")
    pair.do("x", "move_abs", position_deg=20.0)
    until(lambda: abs(pair.far_deg("d8") - 20) < 0.5, "20 deg")


def test_who_has_no_drive_does_not_import_python_can() -> None:
    program = (
        "import sys, hil.daemon, hil.live.devices.drive_device, hil.operations.make_desk\n"
        "print([name for name in sys.modules if name.partition('.')[0] in ('can', 'msgpack')])"
    )
    assert subprocess.check_output([sys.executable, "-c", program], text=True) == "[]\n"
