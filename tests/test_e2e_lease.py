"""A bench that somebody has: other users, ports, a restart, a replay; over the control socket and zenoh."""

import json
import os
import pwd
import re
import socket
import subprocess
import sys
from typing import Any

import pytest
from e2e_support import AS_STRANGER, Place, config, free_port, needs_stranger, until

from hil.client import ClientError, CommandError, connect_sync
from hil.net.control_client import ControlError
from hil.operations.control_socket import peer_name

ASK = """
import json, socket, sys
control = socket.socket(socket.AF_UNIX)
control.connect(sys.argv[1])
file = control.makefile("rwb")
file.write(sys.argv[2].encode() + b"\\n")
file.flush()
print(file.readline().decode())
"""
ME = pwd.getpwuid(os.getuid()).pw_name


def lease_line(place: Place, *words: str, code: int = 0) -> str:
    return place.cli("lease", *words, "--runtime-dir", str(place.runtime), code=code)


def test_a_lease_from_the_command_line(place: Place) -> None:
    log = place.folder / "inputs.log"
    server = place.serve(config(), "--log", str(log)).ready()
    assert lease_line(place) == "nobody has a lease; everybody may command\n"
    assert "write a number and s, min, h or d" in lease_line(
        place, "take", "--why", "x", "--for", "2y", code=2
    )
    assert "either --for or" in lease_line(
        place, "take", "--why", "x", "--for", "1h", "--until", "9:00", code=2
    )
    past = lease_line(place, "take", "--why", "x", "--until", "2020-01-01 09:00", code=2)
    assert "the lease's end is past" in past
    taken = lease_line(place, "take", "--for", "1h30min", "--why", "press tests")
    assert re.match(rf"{ME} until [-0-9]+ [0-9:]+ \(1 h 30 min more\): press tests\n", taken)
    assert "closed to commands: ports, modbus, can, web, zenoh" in taken
    place.cli("axis", "m1", "enable")  # the holder's own
    with server.client() as client:
        client.write(b"pqr")
        until(lambda: server.ask("lease")["lease"]["undelivered"] == {"m1": 3}, "bytes that are counted")
    assert f"lease: {ME} until" in place.cli("status")
    assert "bytes that were not delivered: m1 3" in place.cli("status")
    server.stop()
    assert place.cli("replay", str(log)).startswith("identical: ")  # refused bytes are no inputs
    server = place.serve(config()).ready()
    assert server.ask("lease")["lease"]["user"] == ME
    assert lease_line(place, "renew", "--for", "5min").startswith(f"{ME} until")
    assert lease_line(place, "give") == "given back\n"
    with server.client() as client:
        client.ask(b"p")
    with pytest.raises(ControlError, match="there is no lease to give back"):
        server.ask("give_lease")


@needs_stranger
def test_another_user_of_the_computer_may_look_stop_and_break(place: Place) -> None:
    server = place.serve(config()).ready()
    server.ask("take_lease", why="press tests", for_s=60)
    for folder in (place.folder, *server.control.parents):
        if folder.stat().st_uid == os.getuid() and folder != folder.parent:
            folder.chmod(folder.stat().st_mode | 0o011)
    server.control.chmod(0o666)

    def ask(verb: str, **given: Any) -> Any:
        command = [
            *AS_STRANGER,
            sys.executable,
            "-c",
            ASK,
            str(server.control),
            json.dumps({"verb": verb} | given),
        ]
        return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)

    refused = ask("do", device="m1", name="enable", parameters={})
    assert refused["code"] == "leased"
    assert f"{ME} has this bench until" in refused["error"]
    assert ask("health")["ok"]
    assert ask("halt")["ok"]
    assert ask("do", device="m1", name="stop", parameters={})["ok"]
    assert ask("give_lease")["code"] == "leased"
    assert ask("break_lease") == {"ok": True, "result": {"lease": None}}
    assert ask("do", device="m1", name="enable", parameters={})["ok"]
    assert f"broke the lease of {ME}: press tests" in server.output


def test_users_over_zenoh(place: Place) -> None:
    port, folder = free_port(), place.folder / "site"
    users = ("--user", "otto:operator", "--user", "anna:admin", "--user", "vera:viewer")
    where = ("--bench", "t", "--host", "127.0.0.1", "--port", str(port))
    place.cli("zenoh", "keys", str(folder), *where, *users)
    head = "bench: t\ndevices:\n  m1: {profile: mechaduino, flash: {table: identity}}\n"
    server = place.serve(head + (folder / "bridge.yaml").read_text()).ready()
    configs = {who: folder / "clients" / who / "zenoh.json" for who in ("otto", "anna", "vera")}
    with connect_sync("t", config=configs["otto"]) as client:
        taken = client.lease("press tests", for_s=60)
        assert (taken["user"], taken["why"]) == ("otto", "press tests")
        client.axis("m1").enable()
    with pytest.raises(ControlError) as caught:
        server.ask("do", device="m1", name="enable", parameters={})
    assert caught.value.code == "leased"
    with connect_sync("t", config=configs["anna"]) as client:
        with pytest.raises(CommandError, match="otto has this bench until"):
            client.axis("m1").enable()
        client.axis("m1").stop()
        assert client.leased()["user"] == "otto"
        client.break_lease()
        assert client.leased() is None
        client.axis("m1").enable()
    with connect_sync("t", config=configs["vera"]) as client, pytest.raises(ClientError):
        client.lease("looking", for_s=60)


def test_the_user_at_a_socket_is_the_processs() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        assert peer_name(ours) == ME
