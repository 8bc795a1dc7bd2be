"""A reload and the boards' memories: each goes with its device's name, and with its kind of board."""

import os
import socket
import time
from typing import Any

import pytest
from e2e_support import Client, Place, Server, config, folder, refused, reload, until

SAC: dict[str, Any] = {"profile": "sac", "flash": {}}
SAC_START_NS = 1_200_000_000


def kept_acceleration(server: Server, client: Client) -> bytes:
    """Acceleration among the settings that a SAC has in its memory. A byte while it starts would restore the
    factory's."""
    now_ns = server.ask("status")["sim_ns"]
    server.ready(since_ns=now_ns, boot_ns=SAC_START_NS)
    client.quiet(0.1)
    text = client.ask(b"$C\r", b"SAC>")
    client.ask(b"x\r", b"SAC>")
    return text.partition(b"d acc\t\t")[2][:4]


def test_memories_go_with_the_names(place: Place) -> None:
    """A SAC's settings: kept through a restart of the device, a removal, and a kill."""
    server = place.serve(config(speed=5, devices={"m1": {}, "s1": SAC}))
    changed = SAC | {"axis": {"start_deg": 5.0}}
    with server.client("s1") as s1:
        s1.read_until(b"SAC>")
        s1.ask(b"$Cd3.5\r", b"SAC>")
        assert reload(place, server, {"m1": {}, "s1": changed}, speed=5)["restarted"] == ["s1"]
        s1.read_until(b"SAC>")
        assert kept_acceleration(server, s1) == b"3.50"
    assert reload(place, server, {"m1": {}}, speed=5)["removed"] == ["s1"]
    assert reload(place, server, {"m1": {}, "s1": SAC}, speed=5)["added"] == ["s1"]
    with server.client("s1") as s1:
        assert kept_acceleration(server, s1) == b"3.50"
        s1.ask(b"$Cd2.5\r", b"SAC>")
    names = sorted(folder(place))
    server.kill()
    assert sorted(folder(place)) == names  # left behind, and nobody's
    server = place.serve(config(speed=5, devices={"m1": {}, "s1": SAC}))
    assert sorted(folder(place)) == names
    with server.client("s1") as s1:
        assert kept_acceleration(server, s1) == b"2.50"
    server.stop()


def memory_files(place: Place) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (place.state / "t").iterdir() if path.is_file()}


def test_a_refused_reload_leaves_the_memories_where_they_are(place: Place) -> None:
    server = place.serve(config(speed=5, devices={"b1": SAC}))
    with server.client("b1") as b1, socket.create_server(("127.0.0.1", 0)) as taken:
        b1.ask(b"\r", b"SAC>")  # its first words may have been said before anybody listened
        b1.ask(b"$Cd3.5\r", b"SAC>")
        before = memory_files(place)
        assert list(before) == ["b1.nvm"]
        unusable = {"port": {"kind": "tcp", "listen": taken.getsockname()[1]}}
        assert "is in use by" in refused(place, server, {"b1": {}, "m2": unusable}, speed=5)
        assert memory_files(place) == before
    server.kill()
    server = place.serve(config(speed=5, devices={"b1": SAC}))
    with server.client("b1") as b1:
        assert kept_acceleration(server, b1) == b"3.50"
    server.stop()


def test_the_memory_of_another_kind_of_board_is_kept_aside_and_the_note_of_it_ends(place: Place) -> None:
    server = place.serve(config(speed=5, devices={"b1": SAC}))
    with server.client("b1") as b1:
        b1.read_until(b"SAC>")
        b1.ask(b"$Cd3.5\r", b"SAC>")
        of_sac = memory_files(place)["b1.nvm"]
        reload(place, server, {"b1": {}}, speed=5)
        assert memory_files(place) == {"b1.nvm.damaged-1": of_sac}
        assert server.status("b1")["note"].startswith(
            "b1.nvm: it belongs to a 'sac', not to a 'mechaduino'; it"
        )
        reload(place, server, {"b1": SAC}, speed=5)
        assert memory_files(place) == {"b1.nvm.damaged-1": of_sac}
        assert server.status("b1")["note"] is None
    server.stop()


SLOW = """
import sys, time
from pathlib import Path
from hil.cli.framework.command_group import app
from hil.live.store import StoreCalls

fsync = StoreCalls.fsync

def slow(fd):
    while Path(sys.argv[-1], "slow").exists():
        time.sleep(0.01)
    fsync(fd)

StoreCalls.fsync = staticmethod(slow)
app(["serve", sys.argv[1], "--runtime-dir", sys.argv[2], "--state-dir", sys.argv[3]])
"""


@pytest.mark.thorough
def test_another_kind_of_board_waits_for_the_last_commit_of_the_old_one(place: Place) -> None:
    path = place.write(config(speed=5, devices={"b1": SAC}), "t.yaml")
    arguments = str(path), str(place.runtime), str(place.state), str(place.folder)
    server = place.script(SLOW, *arguments).started()
    with server.client("b1") as b1, socket.socket(socket.AF_UNIX) as asking:
        b1.ask(b"\r", b"SAC>")  # its first words may have been said before anybody listened
        b1.ask(b"$Cd3.5\r", b"SAC>")
        before = memory_files(place)["b1.nvm"]
        (place.folder / "slow").touch()
        b1.write(b"$Cd2.5\r")
        until(lambda: "b1.nvm.new" in memory_files(place), "the commit's beginning")
        place.write(config(speed=5, devices={"b1": {}}), "t.yaml")
        asking.connect(str(server.control))
        asking.sendall(b'{"verb": "reload"}\n')
        time.sleep(0.5)  # a reload without a commit takes less
        assert memory_files(place)["b1.nvm"] == before
        (place.folder / "slow").unlink()
        assert b'"restarted":["b1"]' in asking.recv(65536).replace(b" ", b"")
    after = memory_files(place)
    assert list(after) == ["b1.nvm.damaged-1"]
    assert after["b1.nvm.damaged-1"] != before
    os.rename(place.state / "t" / "b1.nvm.damaged-1", place.state / "t" / "b1.nvm")
    server.kill()
    server = place.serve(config(speed=5, devices={"b1": SAC}))
    with server.client("b1") as b1:
        assert kept_acceleration(server, b1) == b"2.50"
    server.stop()


def test_another_kind_of_board(place: Place) -> None:
    server = place.serve(config(speed=5, devices={"b1": {}}))
    with server.client("b1") as b1:
        assert reload(place, server, {"b1": SAC | {"network": "pty"}}, speed=5) == {"restarted": ["b1"]}
        b1.read_until(b"SAC>")
        assert sorted(folder(place)) == ["b1", "b1.network", "control.sock"]
        assert reload(place, server, {"b1": {}}, speed=5) == {"restarted": ["b1"]}
        b1.read_until(b"step response")
    assert sorted(folder(place)) == ["b1", "control.sock"]
    server.stop()
