"""Starting where something is in the way, and ending without leaving anything behind."""

import os
import re
import signal
import socket
import subprocess
import threading
from contextlib import suppress
from pathlib import Path

import pytest
from e2e_support import (
    AS_STRANGER,
    HIL,
    PATIENCE_S,
    STRANGER_UID,
    Place,
    config,
    needs_stranger,
    until,
)

TCP = {"port": {"kind": "tcp", "listen": 0}}


def processes_of(group: int) -> list[int]:
    """Living processes of a process group."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue  # it has ended meanwhile
        if int(fields[2]) == group and fields[0] != "Z":
            found.append(int(stat.parent.name))
    return found


def nothing_left(place: Place, bench: str = "t") -> bool:
    return not (place.runtime / bench).exists()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_leaves_nothing_behind(place: Place, number: int) -> None:
    server = place.serve(
        config(devices={"m1": {}, "m2": TCP}), "--log", str(place.folder / "log"), process_group=0
    )
    address = server.ask("list")["devices"][1]["address"].removeprefix("socket://")
    host, tcp_port = address.split(":")
    with server.client("m1") as reader, server.client("m2"):
        assert sorted(path.name for path in (place.runtime / "t").iterdir()) == ["control.sock", "m1"]
        reader.write(b"q")
        assert "Aborted" not in server.stop(number)
    assert not place.runtime.exists()
    assert processes_of(server.pid) == []
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection((host, int(tcp_port)))
    with socket.create_server((host, int(tcp_port))):
        pass


def test_hangup_is_ignored_under_nohup(place: Place) -> None:
    server = place.serve(config(), prefix=["nohup"])
    server.process.send_signal(signal.SIGHUP)
    assert server.ask("list")["bench"] == "t"
    server.stop()


@pytest.mark.parametrize("number", [pytest.param(signal.SIGINT, marks=pytest.mark.thorough), signal.SIGTERM])
def test_a_signal_while_it_starts_leaves_nothing_behind(place: Place, number: int) -> None:
    for _ in range(3):
        server = place.launch(config(devices={f"m{i}": {} for i in range(20)}))
        until(server.control.exists, "the control socket")
        server.process.send_signal(number)
        assert server.process.wait(PATIENCE_S) == 0, server.output
        assert "Traceback" not in server.output
        assert nothing_left(place)


def test_stopped_by_a_request(place: Place) -> None:
    server = place.serve(config())
    server.ask("stop")
    assert server.process.wait(PATIENCE_S) == 0
    assert nothing_left(place)


def test_the_same_bench_twice_is_refused(place: Place) -> None:
    first = place.serve(config())
    said = place.launch(config()).refused()
    assert f"bench t is running already, as process {first.pid}" in said
    # One that is stopped still owns its ports.
    first.process.send_signal(signal.SIGSTOP)
    said = place.launch(config()).refused()
    assert f"bench t is running already, as process {first.pid}" in said
    first.process.send_signal(signal.SIGCONT)
    assert first.ready().client().ask(b"p")
    first.stop()


def test_two_daemons_may_not_share_memories(place: Place) -> None:
    place.serve(config())
    path = place.write(config(), "t.yaml")
    other = ["--runtime-dir", str(place.folder / "other"), "--state-dir", str(place.state)]
    done = subprocess.run(
        [HIL, "serve", str(path), *other], capture_output=True, timeout=PATIENCE_S, check=False
    )
    assert done.returncode == 2
    assert f"state directory {place.state / 't'}" in done.stderr.decode()
    assert not (place.folder / "other").exists()


def test_of_many_starts_at_once_one_wins(place: Place) -> None:
    servers = [place.launch(config()) for _ in range(4)]
    until(lambda: sum(s.process.poll() is None for s in servers) == 1, "three refusals")
    (winner,) = [s for s in servers if s.process.poll() is None]
    winner.started()
    assert winner.ask("list")["pid"] == winner.pid
    for loser in servers:
        if loser is not winner:
            assert re.search(r"is running already|another daemon has it", loser.refused())
    winner.stop()
    assert nothing_left(place)


def test_what_a_killed_daemon_left_is_replaced(place: Place) -> None:
    first = place.serve(config(devices={"m1": {}, "m2": {}}))
    first.kill()
    assert first.control.is_socket()
    assert (place.runtime / "t" / "m1").is_symlink()
    second = place.serve(config(devices={"m1": {}, "m2": {}})).ready()
    for device in ("m1", "m2"):
        with second.client(device) as client:
            assert client.ask(b"p").startswith(b"stepNumber: 0 ")
    second.stop()
    assert nothing_left(place)


def test_a_stale_symlink_to_a_strangers_terminal_is_replaced(place: Place) -> None:
    master, slave = os.openpty()
    (place.runtime / "t").mkdir(parents=True, mode=0o700)
    (place.runtime / "t" / "m1").symlink_to(os.ttyname(slave))
    server = place.serve(config()).ready()
    assert (place.runtime / "t" / "m1").readlink() != Path(os.ttyname(slave))
    with server.client() as client:
        client.ask(b"p")
    server.stop()
    os.close(master)
    os.close(slave)


@pytest.mark.parametrize("kind", ["file", "directory", "fifo"])
def test_a_name_that_is_taken_is_refused(place: Place, kind: str) -> None:
    taken = place.runtime / "t" / "m1"
    taken.parent.mkdir(parents=True, mode=0o700)
    {
        "file": lambda: taken.write_text("precious"),
        "directory": taken.mkdir,
        "fifo": lambda: os.mkfifo(taken),
    }[kind]()
    said = place.launch(config(devices={"m1": {}, "m2": TCP})).refused()
    assert f"pty port of m1: {taken} is a " in said
    assert "remove it or choose another path:" in said
    assert taken.exists()
    assert [path.name for path in taken.parent.iterdir()] == ["m1"]


def test_all_ports_that_cannot_be_opened_are_named(place: Place) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        number = taken.getsockname()[1]
        busy = {"port": {"kind": "tcp", "listen": number}}
        nowhere = {"port": {"kind": "tcp", "listen": "192.0.2.1"}}
        strange = {"port": {"kind": "pty", "group": "no-such-group"}}
        said = place.launch(config(devices={"m1": busy, "m2": nowhere, "m3": strange, "m4": {}})).refused()
    assert f"devices.m1.port.listen: 127.0.0.1:{number} is in use by " in said
    assert "devices.m2.port.listen: 192.0.2.1:0 is no address of this computer" in said
    assert "devices.m3.port: pty port of m3: there is no group 'no-such-group'" in said
    assert "m4" not in said
    assert nothing_left(place)


def test_modes_of_what_is_made(place: Place) -> None:
    old = os.umask(0o022)
    try:
        server = place.serve(config(devices={"m1": {}, "m2": {"port": {"kind": "pty", "mode": "0600"}}}))
    finally:
        os.umask(old)
    assert server.control.stat().st_mode & 0o777 == 0o660
    assert place.runtime.stat().st_mode & 0o777 == 0o700
    assert (place.runtime / "t").stat().st_mode & 0o777 == 0o755  # a group may come to its ports
    assert (place.runtime / "t" / "m1").stat().st_mode & 0o777 == 0o660
    assert (place.runtime / "t" / "m2").stat().st_mode & 0o777 == 0o600
    with server.client() as client:
        client.ask(b"c", b"Flash memory!\r\n")
    (memory,) = (place.state / "t").glob("*.nvm")
    (recording,) = (place.state / "t" / "recordings").iterdir()
    assert recording.stat().st_mode & 0o777 == 0o600
    assert recording.parent.stat().st_mode & 0o777 == 0o700
    assert memory.stat().st_mode & 0o777 == 0o600


@needs_stranger
def test_directories_without_permission(place: Place) -> None:
    path = place.write(config())
    for option, name in (("--runtime-dir", "runtime"), ("--state-dir", "state")):
        mine = place.folder / f"{name}-mine"
        mine.mkdir(mode=0o700)
        os.chown(mine, STRANGER_UID, STRANGER_UID)
        roots = place.folder / f"{name}-roots"
        roots.mkdir(mode=0o755)
        other = {"--runtime-dir": "--state-dir", "--state-dir": "--runtime-dir"}[option]
        done = subprocess.run(
            [*AS_STRANGER, HIL, "serve", str(path), option, str(roots), other, str(mine)],
            capture_output=True,
            timeout=PATIENCE_S,
            check=False,
        )
        said = done.stderr.decode()
        assert done.returncode == 2, said
        assert "Traceback" not in said
        assert said.startswith(f"hil: {name} directory {roots}")
        assert f"choose another with {option}" in said
        assert list(roots.iterdir()) == []


@needs_stranger
def test_a_port_in_a_directory_without_permission(place: Place) -> None:
    for folder in (place.runtime, place.state):
        folder.mkdir(mode=0o700)
        os.chown(folder, STRANGER_UID, STRANGER_UID)
    roots = place.folder / "roots"
    roots.mkdir(mode=0o755)
    port = {"port": {"kind": "pty", "path": str(roots / "m1")}}
    said = place.launch(config(devices={"m1": port}), prefix=AS_STRANGER).refused()
    assert f"no permission to write in {roots}" in said
    assert nothing_left(place)


def test_unusable_cpu(place: Place) -> None:
    said = place.launch(config(cpu=1023)).refused()
    assert re.search(r"cpu: 1023 is not one that this process may use \(\d", said)
    assert nothing_left(place)


def test_table_files_that_cannot_be_used(place: Place) -> None:
    (place.folder / "short.txt").write_text("1, 2, 3")
    (place.folder / "words.txt").write_text("one two")
    tables = {"m1": "./none.txt", "m2": "./short.txt", "m3": "./words.txt"}
    text = config(devices={name: {"flash": {"table": table}} for name, table in tables.items()})
    said = place.launch(text).refused()
    for where in (said, place.cli("check", str(place.folder / "t.yaml"), code=2)):
        assert "devices.m1.flash.table: " in where
        assert "none.txt: No such file" in where
        assert "short.txt: 3 angles instead of 16,384" in where
        assert "words.txt: neither numbers nor" in where
    assert nothing_left(place)


def test_log_that_cannot_be_written(place: Place) -> None:
    said = place.launch(config(), "--log", str(place.folder / "none" / "log")).refused()
    assert f"log {place.folder}/none/log: there is no folder" in said
    assert nothing_left(place)


def test_too_long_a_runtime_directory(place: Place) -> None:
    path = place.write(config())
    deep = place.folder / ("x" * 100)
    options = ["--runtime-dir", str(deep), "--state-dir", str(place.state)]
    done = subprocess.run(
        [HIL, "serve", str(path), *options], capture_output=True, timeout=PATIENCE_S, check=False
    )
    assert done.returncode == 2
    assert b"path too long" in done.stderr
    assert b"choose another --runtime-dir" in done.stderr
    assert not deep.exists()


WRONG_REQUESTS = rb"""
{}
[]
7
null
%
{"verb":"nonsense"}
{"verb":[]}
{"verb":"reset"}
{"verb":"reset","device":[]}
{"verb":"reset","device":{"a":1}}
{"verb":"pin","device":"m1","pin":[],"level":1}
{"verb":"pin","device":"m1","pin":"D0","level":"1"}
{"verb":"set","device":"m1","field":"errfl","value":null}
{"verb":"set","device":"m1","field":"load_torque_Nm","value":1e400}
{"verb":"set","device":"m1","field":"load_torque_Nm","value":"x"}
""".replace(b"%", b"\xff").splitlines(keepends=True)


def test_requests_that_are_wrong(place: Place) -> None:
    """Nothing that is written to the control socket disturbs the daemon."""
    server = place.serve(config())
    for request in WRONG_REQUESTS:
        with socket.socket(socket.AF_UNIX) as client:
            client.settimeout(PATIENCE_S)
            client.connect(str(server.control))
            client.sendall(request)
            answer = client.makefile().readline()
        assert answer.startswith('{"ok": false, "error": "'), (request, answer)
    with socket.socket(socket.AF_UNIX) as client:  # longer than any request
        client.connect(str(server.control))
        client.settimeout(PATIENCE_S)
        writer = threading.Thread(target=_send_all, args=(client, b"x" * 20_000_000 + b"\n{}\n"))
        writer.start()
        answers = client.makefile()
        assert "longer than 12582912 bytes" in answers.readline()
        assert answers.readline().startswith('{"ok": false'), "the connection goes on"
        writer.join(PATIENCE_S)
        assert not writer.is_alive()
    with server.ready().client() as client:
        client.ask(b"p")
    assert "Traceback" not in server.stop()


def _send_all(client: socket.socket, data: bytes) -> None:
    with suppress(OSError):  # the daemon hangs up
        client.sendall(data)


def test_a_folder_that_somebody_made_stays(place: Place) -> None:
    place.runtime.mkdir()
    place.serve(config()).stop()
    assert list(place.runtime.iterdir()) == []


def test_a_configuration_may_come_through_a_pipe(place: Place) -> None:
    reader, writer = os.pipe()
    os.write(writer, config().encode())
    os.close(writer)
    command = [HIL, "check", f"/dev/fd/{reader}"]
    done = subprocess.run(command, pass_fds=[reader], capture_output=True, text=True, timeout=PATIENCE_S)
    os.close(reader)
    assert done.returncode == 0, done.stderr


def test_what_is_no_file_is_not_waited_for(place: Place) -> None:
    path = place.folder / "t.yaml"
    memory = place.state / "t" / "m1.nvm"
    memory.parent.mkdir(parents=True)
    os.mkfifo(memory)
    path.write_text(config())
    said = place.hil("serve", str(path), *place.folders(), code=2)
    assert f"{memory} cannot be read: it is a FIFO, not a regular file" in said
    doctor = place.hil("doctor", "--state-dir", str(place.state), code=1)
    assert re.search(r"memory t/m1 +it is a FIFO, not a regular file", doctor)
    memory.unlink()
    os.mkfifo(place.folder / "table")
    path.write_text(config(devices={"m1": {"flash": {"table": "./table"}}}))
    assert "table: it is a FIFO" in place.hil("check", str(path), code=2)
