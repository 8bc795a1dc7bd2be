"""Texts and files that no configuration should have: at serve, check and reload a problem, and no more."""

import json
import os
import socket
from pathlib import Path
from typing import Any

import pytest
from e2e_support import Place, Server, until

from hil.net.control_client import ask

NUL = {
    "path": {"port": {"kind": "pty", "path": "a\0b"}},
    "group": {"port": {"kind": "pty", "group": "a\0b"}},
    "listen": {"port": {"kind": "tcp", "listen": "a\0b"}},
    "table": {"flash": {"table": "./a\0b"}},
    "at": {"at": "/dev/tty\0"},
}
RELOADS = 20


def bench(name: str = "t", bridges: dict[str, Any] | None = None, **m2: Any) -> str:
    devices = {"m1": {"profile": "mechaduino"}, "m2": {"profile": "mechaduino"} | m2}
    return json.dumps({"bench": name, "devices": devices, "bridges": bridges or {}}, indent=1)


def fds(server: Server) -> int:
    return len(os.listdir(f"/proc/{server.pid}/fd"))


def test_a_nul_in_any_text_is_a_problem_of_the_configuration(place: Place) -> None:
    server = place.serve(bench())
    what = "holds the character NUL, which no name and no path can have (leave it out)"
    before = fds(server)
    for key, device in NUL.items():
        file = place.write(bench(**device), "nul.yaml")
        _, said, *_ = place.cli("check", str(file), code=2).splitlines()
        assert said.startswith(f"{file}:")
        assert said.split(":")[1].isdigit()
        assert key in said.partition(": ")[2].partition(": ")[0]
        assert said.endswith(what)
        assert what in place.cli("serve", str(file), *place.folders(), code=2)
        place.write(bench(**device), "t.yaml")
        for _ in range(RELOADS // len(NUL)):
            assert what in ask(server.control, "reload")["problems"]
    until(lambda: fds(server) <= before, "the end of the requests")  # the first count may have one too
    server.stop()


def strange(folder: Path) -> dict[str, tuple[str, str]]:
    """Tables, and what is said of each."""
    os.mkfifo(folder / "fifo")
    (folder / "empty").touch()
    (folder / "loop").symlink_to("loop")
    with (folder / "huge").open("wb") as file:
        file.truncate(5 << 30)
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(folder / "socket"))
    return {
        "./fifo": ("it is a FIFO, not a regular file", ""),
        "./socket": ("it is a socket, not a regular file", ""),
        "/dev/zero": ("it is a character device, not a regular file", ""),
        "./.": ("Is a directory", ""),
        "./loop": ("Too many levels of symbolic links", ""),
        "./huge": ("it has 5,368,709,120 bytes, and 1,048,576 are the most", ""),
        "./empty": ("0 angles instead of 16,384", ""),
        "/proc/kmsg": ("0 angles instead of 16,384", "Permission denied"),
        "/proc/self/environ": ("0 angles instead of 16,384", ""),
    }


def test_a_table_that_is_no_file_is_a_problem_of_the_configuration(place: Place) -> None:
    tables = strange(place.folder)
    server = place.serve(bench())
    before = fds(server)
    for table, whys in tables.items():
        file = place.write(bench("u", flash={"table": table}), "odd.yaml")
        refused = place.cli("serve", str(file), *place.folders(), code=2)
        place.write(bench(flash={"table": table}), "t.yaml")
        with pytest.raises(Exception, match=r"devices\.m2\.flash\.table") as refusal:
            ask(server.control, "reload")
        for said in (refused, str(refusal.value)):
            assert "devices.m2.flash.table: " in said
            assert any(why and why in said for why in whys), said
    until(lambda: fds(server) <= before, "the end of the requests")  # the first count may have one too
    server.stop()


def test_users_and_certificates_that_are_no_files_are_refused_at_once(place: Place) -> None:
    strange(place.folder)
    users = place.folder / "users"
    users.write_text("anna:admin:long-enough-for-a-secret\n")
    users.chmod(0o600)
    for name in ("fifo", "socket", "empty", "loop", "/dev/zero", "/proc/kmsg", "none", "."):
        path = str(place.folder / name)
        pem = {"ca": path, "certificate": path, "key": path}
        for options in ({"users": path}, {"users": str(users), "tls": pem, "listen": ["tls/127.0.0.1:0"]}):
            file = place.write(bench("u", {"zenoh": options}), "odd.yaml")
            assert path in place.cli("serve", str(file), *place.folders(), code=2)
