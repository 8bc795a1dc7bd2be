"""A board outside hil with two axes and three serial interfaces, one on a wire, one without axes, and two
without serial interfaces: served, used at all doors, reloaded, and their logs replayed."""

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
from e2e_support import HIL, PATIENCE_S, Client, Place, Server, config, free_port, reload, until
from plain_zenoh import Plain

from hil.net.control_client import ControlError

BOARDS = str(Path(__file__).with_name("boards"))
ARM: dict[str, Any] = {"profile": "arm", "flash": {}, "ports": {"logger": "pty"}}
PINGER: dict[str, Any] = {"profile": "pinger", "flash": {}}
DEVICES = {"arm": ARM, "p1": PINGER}
WIRE = {"bus0": {"stations": ["arm.bus"], "taps": {"m": {"port": "pty"}}}}
RUN = {"run": "r", "axes": {"arm": {}, "arm.elbow": {}}, "steps": [{"line": {"arm": 30, "arm.elbow": 90}}]}


def bench(devices: dict[str, Any] = DEVICES, **top: Any) -> str:
    return config(devices=devices, **({"speed": 2, "profile_path": [BOARDS]} | top))


def addresses(server: Server) -> dict[str, str]:
    rows = server.ask("list")
    found = {row["device"]: row["address"] for row in rows["devices"]}
    for row in rows["devices"]:
        found |= {name: port["address"] for name, port in row["ports"].items()}
    return found | {row["tap"]: row["port"] for row in rows["taps"]}


def test_every_part_at_every_door(place: Place) -> None:
    log = place.folder / "run.log"
    server = place.serve(bench(segments=WIRE), "--log", str(log))
    at = addresses(server)
    assert list(at) == ["arm", "p1", "arm.logger", "bus0.m"]
    with Client(at["arm"]) as console, Client(at["arm.logger"]) as logger, Client(at["p1"]) as ping:
        assert console.ask(b"e").startswith((b"elbow 39", b"elbow 4"))
        assert logger.read_until(b"\r\n") == b"1: e\r\n"
        assert ping.ask(b"?", b"ping") == b"ping"
        with Client(at["bus0.m"]) as wire:
            assert wire.ask(b"#", b";") == b"=1;"
        captured = place.folder / "c.pcapng"
        command = [HIL, "capture", "arm", "arm.logger", "bus0", "-w", str(captured)]
        capture = subprocess.Popen([*command, "--runtime-dir", str(place.runtime)])
        until(lambda: captured.exists() and captured.stat().st_size, "the capture's header")
        server.ask("type", device="arm.logger", text="x")
        console.ask(b"s")
        assert logger.read_until(b"\r\n") == b"2: s\r\n"
        until(lambda: b"2: s" in captured.read_bytes(), "the logger's bytes")
        capture.terminate()
        assert capture.wait(PATIENCE_S) == 0
        assert "position: " in place.cli("axis", "arm.elbow")
        assert "its set-point is 47.00 deg" in place.cli("axis", "arm.elbow", "position", "47")
        place.cli("set", "arm.elbow", "load_torque_Nm", "0.01")
        place.cli("pin", "arm.elbow", "D3", "1")
        assert server.ask("state", device="arm.elbow")["load_torque_Nm"] == 0.01
        assert server.ask("state", device="arm")["load_torque_Nm"] == 0
        done = server.ask("run", text=json.dumps(RUN))
        until(lambda: server.ask("runs", name=done["run"])[0]["state"] == "done", "the run")
        jam = server.ask("inject", target="arm.elbow", fault="shaft_jam", parameters={})["number"]
        slip = server.ask("inject", target="arm", fault="encoder_slip", parameters={"counts": 3})["number"]
        drop = server.ask("inject", target="arm.logger", fault="byte_drop", parameters={"rate": 1})["number"]
        for number in (jam, slip, drop):
            server.ask("clear", number=number)
        status = server.status("arm")
        assert status["snapshot"]["position_deg"] == pytest.approx(30, abs=2)
        assert status["snapshots"]["arm.elbow"]["position_deg"] == pytest.approx(90, abs=2)
        assert server.status("p1")["snapshot"] is None
    text = place.cli("status")
    assert "arm.elbow" in text
    assert "arm.logger" in place.cli("list")
    for device, why in (("p1", "has no axis"), ("arm.wrist", "no device"), ("arm.logger", "no device")):
        with pytest.raises(ControlError, match=why):
            server.ask("state", device=device)
    with pytest.raises(ControlError, match="no device"):
        server.ask("reset", device="arm.elbow")
    server.ask("reset", device="arm")
    assert "Traceback" not in server.stop()
    assert '"device":"arm.elbow","input":"follow"' in log.read_text()
    assert "identical" in place.cli("replay", str(log))


def test_zenoh_keys_and_a_reload(place: Place) -> None:
    port = free_port()
    bridges = {"zenoh": {"listen": [f"tcp/127.0.0.1:{port}"], "state_hz": 50}}
    server = place.serve(bench(bridges=bridges))
    plain = Plain(port)
    try:
        tokens = {str(r.ok.key_expr) for r in plain.session.liveliness().get("hil/t/@live/axis/*") if r.ok}
        assert tokens == {f"hil/t/@live/axis/{name}" for name in ("arm", "arm.elbow", "p1")}
        heard, _ = plain.listen("axis/arm.elbow/state")
        port_bytes, _ = plain.listen("port/arm.logger/tx")
        until(lambda: heard, "states")
        assert plain.one("axis/arm.elbow/cmd/position", '{"position_deg":50}')["set_point"] == 50
        assert plain.one("axis/arm.elbow/param/pKp", "12.0")["pKp"] == 12
        assert plain.one("axis/arm/param/pKp")["pKp"] == 15
        verbs = {each["verb"] for each in plain.one("verbs/arm.elbow")["verbs"]}
        assert verbs == {"position", "stop", "pin", "zero"}
        number = plain.one("axis/arm.elbow/fault", '{"fault":"shaft_jam"}')["number"]
        assert [fault["target"] for fault in server.ask("faults")] == ["arm.elbow"]
        assert plain.one("axis/arm/fault", f'{{"clear":{number}}}')["cleared"] == [number]
        assert plain.get("axis/p1/state") == []
        until(lambda: server.ask("type", device="arm", text="s") and port_bytes, "the logger's bytes")
        with Client(addresses(server)["arm.logger"]) as logger:
            new = {"arm": ARM | {"axes": {"elbow": {"axis": {"start_deg": 10}}}}, "p1": PINGER}
            done = reload(place, server, new, speed=2, profile_path=[BOARDS], bridges=bridges)
            assert done == {"kept": ["p1"], "restarted": ["arm"]}
            server.ask("type", device="arm", text="e")
            assert logger.read_until(b"1: e\r\n")
        assert server.ask("state", device="arm.elbow")["position_deg"] < 20
        count = len(heard)
        until(lambda: len(heard) > count + 5, "states of the new axis")
        others = {"arm": ARM | {"ports": {"logger": "pty", "bus": "pty"}}}
        done = reload(place, server, others, speed=2, profile_path=[BOARDS], bridges=bridges)
        assert done == {"restarted": ["arm"], "removed": ["p1"]}
        assert list(addresses(server)) == ["arm", "arm.logger", "arm.bus"]
        with Client(addresses(server)["arm.bus"]) as bus:
            assert bus.ask(b"#", b";") == b"=0;"
    finally:
        plain.session.close()  # type: ignore[no-untyped-call]
    assert "Traceback" not in server.stop()


MUTE: dict[str, Any] = {
    name: {"profile": profile, "flash": {}, "port": None}
    for name, profile in (("d1", "drive"), ("b1", "brick"))
}


def test_boards_without_serial_interfaces_at_every_door(place: Place) -> None:
    log = place.folder / "run.log"
    port = free_port()
    bridges = {
        "zenoh": {"listen": [f"tcp/127.0.0.1:{port}"], "state_hz": 50},
        "metrics": {"listen": "127.0.0.1:0"},
    }
    server = place.serve(bench(MUTE | {"p1": PINGER}, bridges=bridges), "--log", str(log))
    listed = {line.split()[0]: line.split()[1:] for line in place.cli("list").splitlines()[1:]}
    assert (listed["d1"], listed["b1"]) == (["drive", "1", "none"], ["brick", "1", "none"])
    assert "d1: 1 starts" in place.cli("status")
    assert "position: set the angle" in place.cli("axis", "d1")
    assert "its set-point is 60.00 deg" in place.cli("axis", "d1", "position", "60")
    place.cli("pin", "d1", "D3", "1")
    place.cli("reset", "b1")
    (place.folder / "r.yaml").write_text("run: r\naxes: {d1: {}}\nsteps:\n  - move: {d1: 20}\n")
    done = place.cli("run", str(place.folder / "r.yaml"), "--runtime-dir", str(place.runtime))
    assert "r: done" in done
    for command, said in (
        (("monitor", "d1"), "d1, a drive, has no serial port; its axis is reached by `hil "),
        (("monitor", "b1"), "b1, a brick, has no serial port, nor an axis"),
        (("axis", "d1", "type", "x"), "d1 has no 'type'; there are position, stop, reset, pin"),
        (("pin", "b1", "D0", "1"), "b1, a brick, has no axis"),
        (("capture", "d1", "-w", "-"), "d1 has no serial port; ports and segments are p1"),
        (("fault", "inject", "byte_drop", "d1", "rate=1"), "byte_drop: d1 has no serial port; there are p1"),
    ):
        where = ("--runtime-dir", str(place.runtime)) * (command[0] in ("capture", "fault"))
        code = 2 if command[-2] == "type" or command[0] in ("capture", "fault") else 1
        assert said in place.cli(*command, *where, code=code)
    plain = Plain(port)
    try:
        tokens = {str(r.ok.key_expr) for r in plain.session.liveliness().get("hil/t/@live/axis/*") if r.ok}
        assert tokens == {f"hil/t/@live/axis/{name}" for name in ("d1", "b1", "p1")}
        heard, _ = plain.listen("axis/d1/state")
        until(lambda: heard, "states")
        assert plain.one("axis/d1/cmd/position", '{"position_deg":50}')["set_point"] == 50
        assert {each["verb"] for each in plain.one("verbs/b1")["verbs"]} == {"reset"}
        plain.one("axis/d1/fault", '{"fault":"shaft_jam"}')
    finally:
        plain.session.close()  # type: ignore[no-untyped-call]
    said = server.stop()
    assert "Traceback" not in said
    assert f"d1: drive, without a serial port; hil --runtime-dir {place.runtime} axis d1" in said
    assert "identical" in place.cli("replay", str(log))


def test_a_reload_adds_and_removes_boards_without_serial_interfaces(place: Place) -> None:
    server = place.serve(bench({"p1": PINGER}))
    top: dict[str, Any] = {"speed": 2, "profile_path": [BOARDS]}
    assert reload(place, server, {"p1": PINGER} | MUTE, **top) == {"kept": ["p1"], "added": ["d1", "b1"]}
    assert "its set-point is 60.00 deg" in place.cli("axis", "d1", "position", "60")
    assert reload(place, server, {"p1": PINGER}, **top) == {"kept": ["p1"], "removed": ["d1", "b1"]}
    place.write(bench({"d1": MUTE["d1"] | {"port": "pty"}}), "t.yaml")
    assert "devices.d1.port: a drive has no serial interface" in server.ask("reload")["problems"]
    assert "Traceback" not in server.stop()
