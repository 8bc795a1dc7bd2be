"""A reload: what changed changes, the rest goes on untouched, and with a problem nothing happens."""

import errno
import json
import os
import re
import select
import signal
import socket
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from e2e_support import Client, Devices, Place, Server, config, folder, listed, refused, reload, until

from hil.recorded.recorded_fields import parse_fields
from hil.recorded.recorded_run import open_recorded
from hil.recorded.sampled import sampled

TCP: dict[str, Any] = {"port": {"kind": "tcp", "listen": 0}}
SAC: dict[str, Any] = {"profile": "sac", "flash": {}}


def has_hung_up(client: Client) -> bool:
    """True if the other end is gone: an end of file, or EIO of a terminal."""
    if not select.select([client.fd], [], [], 0)[0]:
        return False
    try:
        return os.read(client.fd, 4096) == b""
    except OSError as error:
        return error.errno == errno.EIO


def fds(server: Server) -> int:
    return len(list(Path(f"/proc/{server.pid}/fd").iterdir()))


def test_devices_that_did_not_change_go_on(place: Place) -> None:
    old = {"m1": {}, "m2": {}, "m3": TCP, "s1": SAC}
    server = place.serve(config(devices=old)).ready()
    names = folder(place)
    with server.client("m1") as m1, server.client("m2") as m2, server.client("m3") as m3:
        assert m1.ask(b"p").startswith(b"stepNumber: 0 ")
        m1.write(b"s")
        assert m1.ask(b"p").startswith(b"stepNumber: 1 ")
        connects = server.status("m1")["connects"]
        new: Devices = {"m0": {}, "m1": {}, "m2": {"axis": {"start_deg": 90.0}}, "s1": SAC}
        done = reload(place, server, new)
        assert done == {"kept": ["m1", "s1"], "restarted": ["m2"], "added": ["m0"], "removed": ["m3"]}
        since_ns = server.ask("status")["sim_ns"]
        # The same terminal, client and board.
        assert folder(place)["m1"] == names["m1"]
        assert m1.ask(b"p").startswith(b"stepNumber: 1 ")
        assert (server.status("m1")["clients"], server.status("m1")["connects"]) == (1, connects)
        # Another board behind the same terminal.
        assert folder(place)["m2"] == names["m2"]
        m2.read_until(b"step response")
        server.ready(since_ns=since_ns)
        m2.quiet(0.2)
        assert m2.ask(b"p").startswith(b"stepNumber: 0 ")
        assert server.status("m2")["snapshot"]["position_deg"] == pytest.approx(90, abs=5)
        until(lambda: has_hung_up(m3), "the hang-up")
    assert [row["device"] for row in server.ask("list")["devices"]] == ["m0", "m1", "m2", "s1"]
    with server.client("m0") as m0:
        assert m0.ask(b"p").startswith(b"stepNumber: 0 ")
    server.stop()


def test_a_removed_terminal_is_gone_and_can_come_back(place: Place) -> None:
    server = place.serve(config(devices={"m1": {}, "m2": {}}))
    with server.client("m2") as m2:
        assert reload(place, server, {"m1": {}}) == {"kept": ["m1"], "removed": ["m2"]}
        until(lambda: has_hung_up(m2), "the hang-up")
        assert "m2" not in folder(place)
        assert reload(place, server, {"m1": {}, "m2": {}}) == {"kept": ["m1"], "added": ["m2"]}
    server.ready(since_ns=server.ask("status")["sim_ns"])
    with server.client("m2") as m2:
        assert m2.ask(b"p").startswith(b"stepNumber: 0 ")
    server.stop()


def test_another_port(place: Place) -> None:
    server = place.serve(config(devices={"m1": {}, "m2": TCP}))
    with server.client("m1") as m1, server.client("m2") as m2:
        done = reload(place, server, {"m1": TCP, "m2": {}})
        assert done == {"restarted": ["m1", "m2"]}
        until(lambda: has_hung_up(m1) and has_hung_up(m2), "the hang-ups")
    assert sorted(folder(place)) == ["control.sock", "m2"]
    server.ready(since_ns=server.ask("status")["sim_ns"])
    for device in ("m1", "m2"):
        with server.client(device) as client:
            assert client.ask(b"p").startswith(b"stepNumber: 0 ")
    server.stop()


def test_with_problems_nothing_changes_and_all_are_told(place: Place) -> None:
    server = place.serve(config(devices={"m1": {}, "m2": {}}))
    before = listed(server), folder(place)
    path = place.folder / "t.yaml"
    path.write_text(
        "bench: t\nspede: 3\ndevices:\n  m1: {profile: waltz}\n  m9: {profile: mechaduino, baud: 1}\n"
    )
    said = place.cli("reload", "--runtime-dir", str(place.runtime), code=2)
    assert [line.partition(": ")[0] for line in said.splitlines() if ".yaml:" in line] == [
        f"{path}:2:1",
        f"{path}:4:17",
        f"{path}:5:35",
    ]
    assert (listed(server), folder(place)) == before
    server.process.send_signal(signal.SIGHUP) if not has_terminal() else None
    path.write_bytes(b"\xff\xfe")
    assert "not UTF-8" in place.cli("reload", "--runtime-dir", str(place.runtime), code=2)
    path.unlink()
    for make, trouble in (
        (lambda: None, "No such file"),
        (path.mkdir, "Is a directory"),
        (lambda: path.symlink_to(path.name), "symbolic links"),
        (lambda: os.mkfifo(path), "it is a FIFO, not a regular file"),
    ):
        make()
        assert trouble in place.cli("reload", "--runtime-dir", str(place.runtime), code=2)
        if not path.is_fifo():  # a command that is typed may wait for a pipe, a running bench may not
            assert trouble in place.cli("check", str(path), code=2)
        if path.is_dir():
            path.rmdir()
        else:
            path.unlink(missing_ok=True)
    assert (listed(server), folder(place)) == before
    assert f"{path}:5:35" in server.stop()


def has_terminal() -> bool:
    """True if the tests were started from a terminal, which SIGHUP is about then."""
    try:
        os.close(os.open("/dev/tty", os.O_RDWR))
    except OSError:
        return False
    return True


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("key", "value"),
    [("speed", 2.0), ("rate_hz", 500), ("seed", 3), ("cpu", 0), ("bench", "u"), ("state_dir", "/var/x")],
)
def test_what_only_a_restart_can_do(place: Place, key: str, value: object) -> None:
    server = place.serve(config(devices={"m1": {}}))
    said = refused(place, server, {"m1": {}, "m2": {}}, **{key: value})
    assert said.startswith(f"{key}: ")
    assert said.endswith(": only a restart of the daemon does this")
    server.stop()


def test_joined_devices_need_a_restart_and_others_beside_them_do_not(place: Place) -> None:
    wires = [{"from": "s1.clk", "to": "m1.step"}]
    joined: Devices = {"s1": SAC, "m1": {}}
    server = place.serve(config(devices=joined, wires=wires))
    said = refused(place, server, joined | {"m1": {"axis": {"start_deg": 3.0}}}, wires=wires)
    assert said.startswith("m1, which is joined to others: axis.start_deg: unset -> 3.0: only a restart")
    assert "wires: " in refused(place, server, joined)
    done = reload(place, server, joined | {"m2": {}}, wires=wires)
    assert done == {"kept": ["s1", "m1"], "added": ["m2"]}
    server.stop()


def test_a_run_with_reloads_replays_identically(place: Place) -> None:
    """One board starts again, one is new, one goes and comes back, one goes on all the time."""
    log, steady = place.folder / "run.hil.gz", {"profile": "sac", "flash": {}}
    server = place.serve(config(devices={"m1": {}, "s1": steady}), "--log", str(log)).ready()

    def later(**devices: Any) -> None:
        with server.client("s1") as client:  # answers while the others are exchanged
            client.write(b"vd\r")
            reload(place, server, {"s1": steady} | devices)
            client.read_until(b"SAC>")
        now_ns = server.ask("status")["sim_ns"]
        for name in devices:
            server.ready(name, since_ns=now_ns)

    with server.client("m1") as client:
        client.ask(b"p")
    later(m1={"axis": {"start_deg": 30.0}}, m2={"baud": 57600})
    with server.client("m1") as m1, server.client("m2") as m2:
        m1.ask(b"yr20\n", b"20.00\r\n")
        m2.ask(b"p")
    server.ask("inject", fault="byte_flip", target="m2", parameters={"rate": 1e-9})
    later(m2={"baud": 57600})
    with server.client("m2") as client:
        client.ask(b"p")
    later(m1={}, m2={"baud": 57600})
    with server.client("m1") as client:
        client.ask(b"p")
    assert server.ask("status")["recording"]["problem"] is None
    server.stop()
    said = place.cli("replay", str(log))
    assert re.fullmatch(r"identical: \d+ inputs, \d+ bytes in \d+ pieces, \d+ states of axes\n", said)
    with closing(open_recorded(log)) as run:
        pieces: list[tuple[int, str, bytes]] = []
        run.listeners.append(lambda device, port, at_ns, data: pieces.append((at_ns, device.name, data)))
        (first, *_), there = run.log.reloads, []
        for chunk in sampled(run, parse_fields(run.runtime, ["m1.position_deg"]), 0, run.end_ns, 10**8):
            there += [row[0] for row in chunk.rows]
        for name in ("m1", "m2", "s1"):
            then = [(each.at_ns, each.data) for each in run.log.sent if each.device == name]
            assert [(at_ns, data) for at_ns, of, data in pieces if of == name][: len(then)] == then
        assert set(run.config.devices) == {"m1", "m2", "s1"}
        gone, back = (place.reload.at_ns for place in run.log.reloads[1:])
        assert [at_ns for at_ns in there if gone < at_ns < back] == []
        assert there[0] < first.reload.at_ns < gone < back < there[-1]
        assert len(there) == len(set(there))


def test_a_port_that_cannot_be_had_takes_the_others_back(place: Place) -> None:
    server = place.serve(config(devices={"m1": {}, "m2": {}}))
    open_fds = fds(server) + 1  # there may be a connection to the control socket
    with socket.create_server(("127.0.0.1", 0)) as taken:
        number = taken.getsockname()[1]
        new = {
            "m0": {},
            "m1": {"axis": {"start_deg": 1.0}},
            "m3": {"port": {"kind": "tcp", "listen": number}},
        }
        said = refused(place, server, new)
    assert f"devices.m3.port.listen: 127.0.0.1:{number} is in use" in said
    until(lambda: fds(server) <= open_fds, "the file descriptors")
    assert reload(place, server, new) == {"restarted": ["m1"], "added": ["m0", "m3"], "removed": ["m2"]}
    server.stop()


def test_a_refused_reload_leaves_the_names_of_the_ports(place: Place) -> None:
    mode = {"port": {"kind": "pty", "mode": "0600"}}
    server = place.serve(config(devices={"m1": {}, "m2": {}})).ready()
    with socket.create_server(("127.0.0.1", 0)) as taken:
        unusable = {"port": {"kind": "tcp", "listen": taken.getsockname()[1]}}
        assert "is in use by" in refused(place, server, {"m1": mode, "m2": {}, "m3": unusable})
        there = {"port": {"kind": "pty", "path": "m2"}}, {"port": {"kind": "pty", "path": "m1"}}
        assert "is in use by" in refused(place, server, {"m1": there[0], "m2": there[1], "m3": unusable})
    with server.client("m1") as m1:
        assert m1.ask(b"p").startswith(b"stepNumber: 0 ")
    before = folder(place)
    assert reload(place, server, {"m1": mode, "m2": {}}) == {"restarted": ["m1"], "kept": ["m2"]}
    assert before.keys() == folder(place).keys()
    assert before["m1"] != folder(place)["m1"]
    server.ready(since_ns=server.ask("status")["sim_ns"])
    with server.client("m1") as m1:
        assert m1.ask(b"p").startswith(b"stepNumber: 0 ")
    assert reload(place, server, {"m2": {}}) == {"removed": ["m1"], "kept": ["m2"]}
    assert sorted(folder(place)) == ["control.sock", "m2"]
    server.stop()


def test_a_number_that_a_port_of_the_bench_has_is_told_as_such(place: Place) -> None:
    server = place.serve(config(devices={"m1": TCP, "m2": {}}))
    number = int(server.status("m1")["address"].rpartition(":")[2])

    def at(kind: str) -> Devices:
        return {"port": {"kind": kind, "listen": number}}

    said = refused(place, server, {"m1": at("rfc2217"), "m2": {}})
    assert f"devices.m1.port.listen: 127.0.0.1:{number} is in use by m1 itself, " in said
    said = refused(place, server, {"m2": at("tcp")})
    assert f"127.0.0.1:{number} is in use by m1, " in said
    assert said.endswith("choose another port, or restart the daemon")
    assert reload(place, server, {"m2": {}}) == {"kept": ["m2"], "removed": ["m1"]}
    assert reload(place, server, {"m2": at("tcp")}) == {"restarted": ["m2"]}
    server.stop()


def test_more_than_the_core_has_room_for(place: Place) -> None:
    server = place.serve(config(devices={"m1": {}}))
    assert "8 boards begin, and the core has room for 7" in refused(
        place, server, {f"m{n}": {} for n in range(1, 10)}
    )
    new = {f"m{n}": {} for n in range(1, 9)}
    assert len(reload(place, server, new)["added"]) == 7
    server.stop()


def test_a_table_that_cannot_be_read(place: Place) -> None:
    server = place.serve(config(devices={"m1": {}}))
    said = refused(place, server, {"m1": {}, "m2": {"flash": {"table": "./none.txt"}}})
    assert said.startswith("devices.m2.flash.table: ")
    server.stop()


def test_faults_of_the_configuration_come_and_go_with_their_device(place: Place) -> None:
    jam = {"fault": "shaft_jam", "target": "m1"}
    noise = {"fault": "byte_drop", "target": "m2", "rate": 0.5}
    server = place.serve(config(devices={"m1": {}, "m2": {}, "m3": {}}, faults=[jam]))
    server.ask("inject", fault="shaft_jam", target="m3", parameters={})
    done = reload(place, server, {"m1": {}, "m2": {}, "m3": {}}, faults=[noise])
    assert done == {"kept": ["m3"], "restarted": ["m1", "m2"]}
    assert sorted((row["kind"], row["target"]) for row in server.ask("faults")) == [
        ("byte_drop", "m2"),
        ("shaft_jam", "m3"),
    ]
    load = {"fault": "shaft_load", "target": "m1", "torque_Nm": 99}
    place.write(config(devices={"m1": {}, "m2": {}, "m3": {}}, faults=[load]), "t.yaml")
    before = listed(server), server.ask("faults")
    said = str(server.ask("reload")["problems"])
    assert "faults.0.torque_Nm" in said
    assert "10 times what this motor holds" in said
    assert (listed(server), server.ask("faults")) == before
    server.stop()


def test_watches_and_captures_of_what_goes_on(place: Place) -> None:
    server = place.serve(config(devices={"m1": {}, "m2": {}, "m3": {}})).ready()
    watches = {
        name: server.ask("watch", device=name, signals=["yw"], interval_ns=10_000_000)["watch"]
        for name in ("m1", "m2", "m3")
    }
    done = reload(place, server, {"m1": {}, "m2": {"axis": {"start_deg": 1.0}}})
    assert done == {"kept": ["m1"], "restarted": ["m2"], "removed": ["m3"]}
    for name in ("m1", "m2"):
        server.ask("samples", watch=watches[name])
        until(lambda watch=watches[name]: server.ask("samples", watch=watch)["rows"], f"samples of {name}")
    until(lambda: not server.ask("samples", watch=watches["m3"])["rows"], "the end of the one that has gone")
    for watch in watches.values():
        server.ask("unwatch", watch=watch)
    server.stop()


def test_real_boards(place: Place) -> None:
    place.serve(config(bench="far", speed=5, devices={"s1": SAC, "s2": SAC}), bench="far")
    at = {name: str(place.runtime / "far" / name) for name in ("s1", "s2")}
    server = place.serve(config(devices={"m1": {}}))
    real = {"profile": "sac", "at": at["s1"]}

    def write(devices: dict[str, Any]) -> dict[str, Any]:
        place.write(json.dumps({"bench": "t", "speed": 20, "devices": devices}), "t.yaml")
        return {word: names for word, names in server.ask("reload").items() if names}

    m1 = {"profile": "mechaduino", "flash": {"table": "identity"}}
    assert write({"m1": m1, "r1": real}) == {"kept": ["m1"], "added": ["r1"]}
    with server.client("r1") as r1:
        assert r1.ask(b"\r", b"SAC>").endswith(b"SAC>")
        assert write({"m1": m1, "r1": real | {"at": at["s2"]}}) == {"kept": ["m1"], "restarted": ["r1"]}
        until(lambda: server.status("r1")["board"]["connects"], "the other board")
        assert r1.ask(b"\r", b"SAC>").endswith(b"SAC>")
        assert write({"m1": m1, "r1": m1}) == {"kept": ["m1"], "restarted": ["r1"]}
        until(lambda: has_hung_up(r1), "the hang-up")
    assert write({"m1": m1, "r1": real}) == {"kept": ["m1"], "restarted": ["r1"]}
    with server.client("r1") as r1:
        assert r1.ask(b"\r", b"SAC>").endswith(b"SAC>")
    assert write({"m1": m1}) == {"kept": ["m1"], "removed": ["r1"]}
    server.stop()


@pytest.mark.thorough
def test_many_reloads_leave_nothing_behind(place: Place) -> None:
    one: Devices = {"m1": {}, "m2": {}}
    other: Devices = {"m1": {}, "m2": {"axis": {"start_deg": 1.0}}, "m3": TCP, "m4": {}}
    server = place.serve(config(devices=one)).ready()
    with server.client("m1") as m1:
        reload(place, server, other)
        reload(place, server, one)
        before = fds(server) + 1
        for _ in range(40):
            assert reload(place, server, other)["kept"] == ["m1"]
            assert m1.ask(b"p").startswith(b"stepNumber: 0 ")
            assert reload(place, server, one)["kept"] == ["m1"]
        until(lambda: fds(server) <= before, "the file descriptors")  # of connections to the control socket
    server.stop()


def test_a_stop_in_the_middle(place: Place) -> None:
    server = place.serve(config(devices={"m1": {}}))
    place.write(config(devices={f"m{n}": {} for n in range(1, 9)}), "t.yaml")
    with socket.socket(socket.AF_UNIX) as asking:
        asking.connect(str(server.control))
        asking.sendall(b'{"verb": "reload"}\n')
        server.stop()
    assert not place.runtime.exists()


def test_a_device_that_is_in_a_run_is_left_to_it(place: Place) -> None:
    old: Devices = {"m1": {}, "m2": {}}
    server = place.serve(config(speed=1, devices=old)).ready()
    server.ask("do", device="m1", name="enable", parameters={})
    limits = {"velocity_rpm": 10.0, "acceleration_rpm_per_s": 1000.0, "jerk_rpm_per_s2": 1e5}
    run = {"run": "slow", "axes": {"m1": limits}, "steps": [{"move": {"m1": 3600}}]}  # a minute
    server.ask("run", text=json.dumps(run), file="", check=False)
    said = refused(place, server, {"m2": {}}, speed=1)
    assert said == "m1 is in run slow: wait for its end, or cancel it"
    done = reload(place, server, {"m1": {}, "m3": {}}, speed=1)
    assert done == {"kept": ["m1"], "added": ["m3"], "removed": ["m2"]}
    (progress,) = server.ask("runs", name="slow")
    assert progress["state"] == "running"
    server.ask("cancel_run", name="slow", how="prejudice")
    until(lambda: server.ask("runs", name="slow")[0]["state"] != "running", "the end")
    assert reload(place, server, {"m3": {}}, speed=1) == {"kept": ["m3"], "removed": ["m1"]}
    server.stop()
