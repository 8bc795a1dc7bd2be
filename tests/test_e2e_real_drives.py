"""Real Modbus drives as axes: here each is the twin of another daemon, behind its Modbus door; both are
configured as a user does it."""

import json
import subprocess
import sys
from typing import Any

import pytest
from e2e_support import HIL, PATIENCE_S, Place, free_port, until
from pymodbus.client import ModbusTcpClient

from hil.net.control_client import ControlError

RULES = {"velocity_rpm": 60.0, "acceleration_rpm_per_s": 600.0, "jerk_rpm_per_s2": 1e5}
MAP: dict[str, Any] = {
    "modbus_map": 1,
    "position_deg": {"input": 0, "type": "i32", "scale": 0.01},
    "velocity_rpm": {"input": 2, "type": "i16", "scale": 0.1},
    "status": {name: {"input": 4, "bit": bit} for bit, name in enumerate(("enabled", "moving", "fault"))},
    "fault_code": {"input": 5},
    "set_point_deg": {"holding": 0, "type": "i32", "scale": 0.01},
    "set_velocity_rpm": {"holding": 2},
    "acceleration_rpm_per_s": {"holding": 3},
    "control": {
        name: {"holding": 4, "bit": bit}
        for bit, name in enumerate(("enable", "start", "stop", "reset", "follow"))
    },
    "parameters": {"pKp": {"holding": 10, "type": "f32"}},
}
M1 = {"profile": "mechaduino", "flash": {"table": "identity"}}


class Pair:
    """A daemon with the twins d8 and d9 behind its door, and one to which they are the real drives x, which
    follows set-points, and y, whose map has no bit for that; beside its own twin m1."""

    def __init__(self, place: Place) -> None:
        self.place, self.port = place, free_port()
        twins = {"d8": {"profile": "modbus_drive"}, "d9": {"profile": "modbus_drive"}}
        door = {"modbus": {"listen": f"127.0.0.1:{self.port}"}}
        self.far_text = json.dumps({"bench": "far", "devices": twins, "bridges": door})
        self.far = place.serve(self.far_text, bench="far")
        own_ramps = MAP | {"control": {name: MAP["control"][name] for name in ("enable", "start", "stop")}}
        self.devices = {
            "m1": M1,
            "x": {"profile": "modbus_drive", "at": self.at(1), "map": MAP},
            "y": {"profile": "modbus_drive", "at": self.at(2), "map": own_ramps},
        }
        self.near = place.serve(self.configure(), bench="r")
        self.far.ready("d8", boot_ns=300_000_000)
        self.near.ready("m1")
        until(lambda: self.is_there("x") and self.is_there("y"), "the drives")

    def configure(self) -> str:
        """Write the near bench's configuration, and return it."""
        door = {"modbus": {"listen": "127.0.0.1:0"}}
        text = json.dumps({"bench": "r", "devices": self.devices, "bridges": door})
        self.place.write(text, "r.yaml")
        return text

    def at(self, unit: int) -> str:
        return f"modbus+tcp://127.0.0.1:{self.port}?unit={unit}"

    def is_there(self, name: str) -> bool:
        return bool(self.near.status(name)["drive"]["state"] == "there")

    def do(self, device: str, verb: str, **parameters: Any) -> Any:
        return self.near.ask("do", device=device, name=verb, parameters=parameters)

    def state(self, device: str) -> dict[str, Any]:
        state: dict[str, Any] = self.near.ask("state", device=device)
        return state

    def enabled(self) -> "Pair":
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
def pair(place: Place) -> Pair:
    return Pair(place)


@pytest.mark.thorough
def test_drives_move_by_verbs_and_in_a_run_beside_a_twin(pair: Pair) -> None:
    place = pair.place
    refused = place.cli("axis", "x", "move-abs", "90", "--bench", "r", code=1)
    assert "its loop is off; enable it first" in refused
    place.cli("axis", "x", "enable", "--bench", "r")
    assert "set_point: 90" in place.cli("axis", "x", "move-abs", "90", "--bench", "r")
    until(lambda: abs(pair.far_deg("d8") - 90) < 0.5, "90 deg")
    pair.enabled()
    pair.submit(
        "a",
        {"move": {"m1": 90.0, "x": 45.0, "y": 30.0}},
        {"line": {"m1": 0.0, "x": 180.0}},
        {"move_by": {"x": -90.0, "y": -60.0}},
    )
    done = pair.ended("a")
    assert done["state"] == "done", done["why"]
    assert (pair.far_deg("d8"), pair.far_deg("d9")) == (
        pytest.approx(90, abs=0.5),
        pytest.approx(-30, abs=0.5),
    )
    assert done["axes"]["x"]["commanded_deg"] == 90.0
    assert done["axes"]["x"]["error_max_deg"] < 45
    assert done["axes"]["y"]["at_end"] == "stands"
    row = pair.near.status("x")
    assert (row["hardware"], row["note"], row["drive"]["reconnects"]) == ("real", None, 0)
    assert row["snapshot"]["age_ms"] < 5000
    assert "x: there, read" in place.cli("status", "--bench", "r")


@pytest.mark.thorough
def test_a_run_fails_when_its_drive_is_lost_and_nothing_is_sent_afterwards(pair: Pair) -> None:
    pair.enabled()
    pair.submit("a", {"move": {"m1": 7200.0, "x": 7200.0}}, axes=("m1", "x"))
    until(lambda: pair.far_deg("d8") > 40, "some way")
    pair.far.kill()
    failed = pair.ended("a")
    assert failed["state"] == "failed"
    assert f"x stopped: the drive at 127.0.0.1:{pair.port}, unit 1 is lost: " in failed["why"]
    assert failed["axes"]["m1"]["at_end"] == "stands"
    health = pair.near.ask("health")
    assert any(problem["about"] == "x" for problem in health["problems"])
    again = pair.place.serve(pair.far_text, bench="far").ready("d8", boot_ns=300_000_000)
    until(lambda: pair.is_there("x"), "the drive")
    assert pair.near.status("x")["drive"]["reconnects"] == 1
    with ModbusTcpClient("127.0.0.1", port=pair.port) as client:
        assert client.read_holding_registers(0, count=5, device_id=1).registers == [0, 0, 60, 600, 0]
    assert again.status("d8")["snapshot"]["loop_on"] == 0


@pytest.mark.thorough
def test_somebody_else_at_the_drive_fails_the_run(pair: Pair) -> None:
    pair.enabled()
    pair.submit("a", {"move": {"m1": 3600.0, "x": 3600.0}}, axes=("m1", "x"))
    until(lambda: pair.far_deg("d8") > 40, "some way")
    pair.far.ask("do", device="d8", name="disable", parameters={})
    failed = pair.ended("a")
    assert (failed["state"], "its loop is off" in failed["why"]) == ("failed", True)
    pair.do("x", "enable")
    pair.submit("b", {"move_by": {"y": 3600.0}}, axes=("y",))
    until(lambda: pair.far_deg("d9") > 40, "some way")
    assert "a run has this drive" in pair.place.cli("axis", "y", "move-abs", "0", "--bench", "r", code=1)
    pair.do("y", "stop")
    failed = pair.ended("b")
    assert (failed["state"], "somebody gave it the verb stop" in failed["why"]) == ("failed", True)


@pytest.mark.thorough
def test_doors_have_the_drive_and_refuse_what_it_has_not(pair: Pair) -> None:
    pair.enabled()
    state = pair.state("x")
    assert (state["enabled"], state["connected"], state["fault"]) == (1, 1, 0)
    assert pair.near.ask("set", device="x", field="pKp", value=9.5)["pKp"] == 9.5
    until(lambda: pair.far.status("d8")["snapshot"]["pKp"] == 9.5, "the gain")
    cases = (
        (("pin", "x", "enable", "0"), "x is a real drive: hil has its registers, not its pins"),
        (("plot", "x"), "x is a real drive: its polls are no samples"),
        (("set", "x", "vKp", "1"), "fields of x that can be set are pKp"),
    )
    for command, why in cases:
        done = subprocess.run(
            [HIL, *command, "-b", "r", "--runtime-dir", str(pair.place.runtime)],
            capture_output=True, text=True, timeout=PATIENCE_S, check=False,
        )  # fmt: skip
        assert done.returncode == (2 if command[0] == "set" else 1), (command, done)
        assert why in done.stderr
    with pytest.raises(ControlError, match="x is a real drive"):
        pair.near.ask("type", device="x", text="a")
    door = pair.near.ask("status")["bridges"]["modbus"]["listen"][0].rpartition(":")[2]
    rows = {row["name"]: row for row in pair.near.ask("registers", device="x")["rows"]}
    with ModbusTcpClient("127.0.0.1", port=int(door)) as client:
        assert not client.write_registers(
            rows["move_abs.position_deg"]["address"],
            client.convert_to_registers(20.0, client.DATATYPE.FLOAT32),
            device_id=2,
        ).isError()
        coil = next(r["address"] for r in pair.near.ask("registers", device="x")["rows"]
                    if (r["table"], r["name"]) == ("coils", "move_abs"))  # fmt: skip
        assert not client.write_coil(coil, True, device_id=2).isError()
        until(lambda: abs(pair.far_deg("d8") - 20) < 0.5, "20 deg")

        def told_deg() -> float:
            words = client.read_input_registers(rows["position"]["address"], count=2, device_id=2).registers
            return float(client.convert_from_registers(words, client.DATATYPE.INT32)) / 1000

        until(lambda: abs(told_deg() - 20) < 0.5, "20 deg at the door")


@pytest.mark.thorough
def test_a_reload_exchanges_the_drives_that_changed_and_no_others(pair: Pair) -> None:
    pair.enabled()
    old = pair.near.status("y")["drive"]["polls"]
    pair.devices["x"] |= {"poll_interval_ms": 50, "map": MAP | {"parameters": {}}}
    pair.configure()
    done = pair.near.ask("reload")
    assert (done["restarted"], done["kept"]) == (["x"], ["m1", "y"])
    until(lambda: pair.is_there("x"), "the drive")
    assert pair.near.status("y")["drive"]["polls"] >= old
    assert "pKp" not in pair.state("x")
    assert pair.far.status("d8")["snapshot"]["loop_on"] == 1  # it was only asked by another
    del pair.devices["y"]
    pair.configure()
    assert pair.near.ask("reload")["removed"] == ["y"]
    pair.submit("a", {"move": {"x": 3600.0}}, axes=("x",))
    until(lambda: pair.progress("a")["state"] == "running", "the run")
    pair.devices["x"] |= {"poll_interval_ms": 20}
    pair.configure()
    with pytest.raises(ControlError, match="x is in run a: wait for its end, or cancel it"):
        pair.near.ask("reload")
    pair.near.ask("cancel_run", name="a", how="grace")
    assert pair.ended("a")["state"] == "cancelled"


def test_who_has_no_drive_does_not_import_pymodbus() -> None:
    program = (
        "import sys, hil.daemon, hil.live.devices.drive_device, hil.operations.make_desk\n"
        "print([name for name in sys.modules if name.startswith('pymodbus')])"
    )
    assert subprocess.check_output([sys.executable, "-c", program], text=True) == "[]\n"
