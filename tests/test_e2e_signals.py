"""Commands that go on until they are ended: by SIGINT and SIGTERM, also where a shell had them ignored."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress

import pytest
from e2e_support import HIL, PATIENCE_S, TERMINAL, Place, Server, config, until

from hil.runs import Progress
from hil.wire.pcapng import read

SAC = {"profile": "sac", "flash": {}}
FAR = '{"run": "far", "axes": {"m1": {}}, "steps": [{"move": {"m1": 72000}}]}'
IGNORING = (
    *(sys.executable, "-c"),
    "import os, signal, sys\n"
    "signal.signal(signal.SIGINT, signal.SIG_IGN)\nsignal.signal(signal.SIGTERM, signal.SIG_IGN)\n"
    "os.execv(sys.argv[1], sys.argv[1:])",
)
"""Starts a program as a shell without job control starts one in the background, and worse."""
LONG = {
    "capture": ("capture", "s1", "-w", "{folder}/out.pcapng"),
    "capture-pipe": ("capture", "s1", "-w", "-"),
    "plot": ("plot", "m1", "--seconds", "3600", "-o", "{folder}/out.csv"),
    "step": ("step", "m1", "90", "--seconds", "3600"),
    "drive": ("pulses", "m1", "--steps", "3600", "--rate", "1", "--plot"),
    "run": ("run", "{folder}/far.yaml"),
    "monitor": ("monitor", "m1"),
    "command": ("sac", "calibrate", "100", "--device", "s1"),
}
CODES = {"step": 130, "drive": 130, "run": 130, "command": 130}
"""Exit codes of commands that have not done what they were told; all others were told to go on until now."""


@pytest.fixture(scope="module")
def bench() -> Iterator[tuple[Place, Server]]:
    with Place() as place:
        server = place.serve(config(devices={"m1": {}, "s1": SAC})).ready()
        server.ask("do", device="m1", name="enable", parameters={})
        place.write(FAR, "far.yaml")
        yield place, server


def watches(server: Server) -> int:
    """Number of watches that have been opened up to now, this one included."""
    number = server.ask("watch", device="m1", signals=["r"], interval_ns=1_000_000_000)["watch"]
    server.ask("unwatch", watch=number)
    return int(number)


def wait_for_beginning(place: Place, server: Server, name: str, running: subprocess.Popen[bytes]) -> None:
    """Wait until a command does what it goes on with until it is ended."""
    file, before = place.folder / "out.pcapng", watches(server)
    match name:
        case "capture":
            until(lambda: file.exists() and file.stat().st_size, "the capture's beginning")
        case "plot" | "step" | "drive":
            counted = [before]

            def someone_watches() -> bool:
                counted.append(watches(server))
                return counted[-1] > counted[-2] + 1

            until(someone_watches, "the watch")
            from_ns = server.ask("status")["sim_ns"]
            until(lambda: server.ask("status")["sim_ns"] > from_ns + 10_000_000_000, "some samples")
        case "run":
            until(lambda: any(run["state"] == "running" for run in server.ask("runs", name="")), "the run")
        case "monitor" | "command":
            until(lambda: server.status("m1" if name == "monitor" else "s1")["clients"], "the client")
        case _:
            assert running.stdout
            assert running.stdout.read(1)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("name", LONG)
def test_a_command_that_goes_on_ends(bench: tuple[Place, Server], name: str, number: int) -> None:
    place, server = bench
    file = place.folder / "out.pcapng"
    file.unlink(missing_ok=True)
    words = [word.format(folder=place.folder) for word in LONG[name]]
    command = [*IGNORING, HIL, *words, "--runtime-dir", str(place.runtime)]
    streams = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    running = subprocess.Popen(command, **streams, env=os.environ | TERMINAL)
    wait_for_beginning(place, server, name, running)
    running.send_signal(number)
    said = running.communicate(timeout=PATIENCE_S)[0]
    assert running.returncode == CODES.get(name, 0), said
    assert b"Traceback" not in said
    if name == "capture":
        assert len(list(read(file.read_bytes()))) >= 0  # whole up to its end
    if name == "run":
        assert b": cancelled: it was cancelled with a controlled stop" in said
    if name == "drive":
        assert b" pulses m1 --stop` ends it" in said


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(
    ("command", "sign"),
    [
        (("arduino-discovery",), b"OK"),
        (("arduino-monitor",), b"OK"),
        (("zenoh", "router", "--listen", "tcp/127.0.0.1:0"), b"Ctrl-C ends it"),
        (("serve", "{folder}/bench.yaml"), b"Ctrl-C ends"),
    ],
)
def test_a_server_ends(place: Place, command: tuple[str, ...], sign: bytes, number: int) -> None:
    place.write(config())
    where = place.folders() if command[0] == "serve" else ()
    words = [word.format(folder=place.folder) for word in command]
    streams = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    running = subprocess.Popen([*IGNORING, HIL, *words, *where], **streams)
    assert running.stdin
    assert running.stdout
    if command[0].startswith("arduino"):
        running.stdin.write(b'HELLO 1 "a test"\n')
        running.stdin.flush()
    said = b""
    while sign not in said:
        line = running.stdout.readline()
        assert line, said
        said += line
    running.send_signal(number)
    rest = running.communicate(timeout=PATIENCE_S)[0]
    assert running.returncode == 0, rest
    assert b"Traceback" not in rest


def interrupted(
    number: int,
    at: str,
    last: str,
    results: Callable[[list[str]], object],
    words: Sequence[str],
    **files: str,
) -> tuple[int, list[str], bytes]:
    """Run a command: its exit code, verbs asked and output of a command that gets a signal after the bench
    has taken the verb ``at``, and before the command knows that it has. ``results``: the answer to the last
    of the verbs."""
    asked: list[str] = []
    with Place() as place, socket.socket(socket.AF_UNIX) as listener:
        folder = place.runtime / "t"
        folder.mkdir(parents=True)
        listener.bind(str(folder / "control.sock"))
        listener.listen()
        paths = {name: place.write(text, f"{name}.yaml") for name, text in files.items()}
        command = [HIL, *(word.format(**paths) for word in words), "--runtime-dir", str(place.runtime)]
        running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

        def serve() -> None:
            while asked[-1:] != [last]:
                client, _ = listener.accept()
                with client, suppress(OSError):  # who only looks whether somebody listens
                    if line := client.makefile("rb").readline():
                        asked.append(json.loads(line)["verb"])
                        if asked[-1] == at:
                            running.send_signal(number)
                        client.sendall(json.dumps({"ok": True, "result": results(asked)}).encode() + b"\n")

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        said = running.communicate(timeout=PATIENCE_S)[0]
        return running.returncode, asked, said


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_run_that_was_just_submitted_is_cancelled(number: int) -> None:
    def results(asked: list[str]) -> object:
        state = "cancelled" if "cancel_run" in asked else "running"
        progress = Progress("far", state=state).as_dict()
        return [progress] if asked[-1] == "runs" else progress

    code, asked, said = interrupted(number, "run", "runs", results, ("run", "{far}"), far=FAR)
    assert (code, asked) == (130, ["run", "cancel_run", "runs"]), said
    assert b"far: cancelled" in said


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(
    ("words", "verbs", "is_played"),
    [
        (("--steps", "3600", "--plot"), ["state", "watch", "drive", "unwatch"], True),
        (("--steps", "3600"), ["drive"], True),
        (("--stop", "--plot"), ["state", "watch", "drive", "unwatch"], False),
    ],
)
def test_a_train_that_was_just_taken_goes_on_and_the_command_says_so(
    words: tuple[str, ...], verbs: list[str], is_played: bool, number: int
) -> None:
    def results(asked: list[str]) -> object:
        return {
            "state": {"e": 0.0},
            "watch": {"watch": 1, "signals": ["r", "yw", "e"]},
            "drive": {"effective_at_ns": 0, "length_ns": 3_600_000_000},
            "unwatch": {},
        }[asked[-1]]

    code, asked, said = interrupted(number, "drive", verbs[-1], results, ("pulses", "m1", *words))
    assert (code, asked) == (130, verbs), said
    assert (b" pulses m1 --stop` ends it" in said) == is_played, said
