"""Trust of commands: folders of another user, two benches of one name, and answers that are none."""

import json
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from random import Random
from typing import Any

import pytest
from e2e_support import AS_STRANGER, HIL, PATIENCE_S, STRANGER_UID, TERMINAL, Place, config, needs_stranger
from typer.testing import CliRunner

from hil.cli.framework.command_group import app
from hil.net import control_client as client
from hil.net.answers import FORMS, misfit
from hil.net.control_client import BenchEnded, BenchLate, ControlError, ask
from hil.net.socket_owner import others_sockets

SAC = {"profile": "sac", "flash": {}}
RUN = '{"run": "r", "axes": {"m1": {}}, "steps": [{"dwell_s": 0.1}]}'
ASKING = (
    ("list",), ("status",), ("status", "--json"), ("monitor", "m1"), ("reset", "m1"),
    ("pin", "m1", "D0", "1"), ("set", "m1", "errfl", "0"), ("plot", "m1", "--seconds", "0.01"),
    ("step", "m1", "1", "--seconds", "0.01"), ("pulses", "m1", "--steps", "1"), ("axis", "m1"),
    ("axis", "m1", "state"), ("run", "{folder}/run.yaml"), ("list", "--joined"), ("reload",),
    ("fault", "list"), ("fault", "clear"), ("fault", "inject", "noise", "m1"), ("capture", "m1", "-w", "-"),
    ("capture", "m1", "-c", "1"),
    ("sac", "save", "{folder}/q.txt"),
)  # fmt: skip
"""Commands that ask a bench."""
LISTENS = """
import socket, sys
listener = socket.socket(socket.AF_UNIX)
listener.bind(sys.argv[1])
listener.listen(9)
print("on", flush=True)
while True:
    connection, _ = listener.accept()
    print(connection.recv(99), flush=True)
    connection.close()
"""


@contextmanager
def answering(path: Path, answer: Callable[[dict[str, Any]], bytes]) -> Iterator[None]:
    """A control socket whose answers are made by a function; it hangs up after each."""
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(str(path))
    listener.listen(64)

    def serve() -> None:
        while True:
            try:
                connection, _ = listener.accept()
            except OSError:
                return
            with connection, suppress(OSError), connection.makefile("rwb") as file:
                if line := file.readline():
                    file.write(answer(json.loads(line)))

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    try:
        yield
    finally:
        listener.shutdown(socket.SHUT_RDWR)
        listener.close()
        thread.join(PATIENCE_S)
        path.unlink()


def as_user(place: Place, *command: str) -> subprocess.CompletedProcess[str]:
    """Run ``hil`` without XDG_RUNTIME_DIR, with a folder of the place for temporary files."""
    env = {name: value for name, value in os.environ.items() if name != "XDG_RUNTIME_DIR"} | TERMINAL
    env["TMPDIR"] = str(place.folder / "tmp")
    return subprocess.run([HIL, *command], env=env, capture_output=True, text=True, timeout=PATIENCE_S)


@pytest.mark.thorough
@needs_stranger
def test_a_folder_that_another_user_has_made_is_not_believed(place: Place) -> None:
    """The other user listens there, and gets no word of what a command has to say."""
    heard: list[Any] = []
    (place.folder / "tmp").mkdir()
    (place.folder / "tmp").chmod(0o1777)
    base = place.folder / "tmp" / f"hil-{os.getuid()}"
    (base / "t").mkdir(parents=True)
    place.write(RUN, "run.yaml")

    def answer(request: dict[str, Any]) -> bytes:
        heard.append(request)
        return b'{"ok": true, "result": {}}\n'

    with answering(base / "t" / "control.sock", answer):
        for path in (base, base / "t", base / "t" / "control.sock"):
            os.chown(path, STRANGER_UID, STRANGER_UID)
        for command in ASKING:
            words = [word.format(folder=place.folder) for word in command]
            done = as_user(place, *words)
            assert done.returncode == 1, (words, done)
            assert f"{base} belongs to another user, nobody (65534)" in done.stdout + done.stderr
            assert "--runtime-dir" in done.stdout + done.stderr
        place.write(config())
        done = as_user(place, "serve", str(place.folder / "bench.yaml"), "--state-dir", str(place.state))
        assert (done.returncode, "another user" in done.stderr) == (2, True), done
        assert as_user(place, "_names", "benches", "status").stdout == ""
        assert as_user(place, "_names", "devices", "reset").stdout == ""
        assert f"{base} belongs to another user" in as_user(place, "doctor", "--json").stdout
        # Who names the folder means its owner; but then only its owner, or root, may listen there.
        named = as_user(place, "list", "--runtime-dir", str(base))
        assert (named.returncode, "cannot be understood" in named.stderr) == (1, True), named
    assert {request["verb"] for request in heard} <= {"list"}


@needs_stranger
def test_a_stranger_who_listens_in_ones_own_folder_is_not_asked(place: Place) -> None:
    place.runtime.mkdir(parents=True)
    (place.runtime / "t").mkdir()
    path = place.runtime / "t" / "control.sock"
    (place.runtime / "t").chmod(0o777)
    listening = subprocess.Popen(
        [*AS_STRANGER, sys.executable, "-c", LISTENS, str(path)], stdout=subprocess.PIPE
    )
    assert listening.stdout
    assert listening.stdout.readline() == b"on\n"
    (place.runtime / "t").chmod(0o755)
    with pytest.raises(ControlError, match="user 65534 listens there, who has no business"):
        ask(path, "list")
    listening.kill()
    assert b"verb" not in listening.communicate(timeout=PATIENCE_S)[0]


@needs_stranger
def test_a_bench_of_another_user_says_whose_it_is_and_what_helps(place: Place) -> None:
    """A control socket without rights for others, then folders without: no command says that nothing runs."""
    place.serve(config())
    place.write(RUN, "run.yaml")
    for folder in (place.folder, place.runtime, place.runtime / "t"):
        folder.chmod(0o755)

    def refused(*words: str) -> str:
        command = [*AS_STRANGER, HIL, *words, "--runtime-dir", str(place.runtime)]
        done = subprocess.run(command, env=os.environ | TERMINAL, capture_output=True, text=True, timeout=60)
        assert (done.returncode, "Traceback" in done.stderr) == (1, False), done
        return done.stdout + done.stderr

    asking = [[word.format(folder=place.folder) for word in each] for each in ASKING[:4]]
    for command in (*asking, ["list", "--json"], ["run", str(place.folder / "run.yaml")]):
        said = refused(*command)
        assert "bench t of root (0) refuses you: " in said, (command, said)
        assert f"{place.runtime}/t/control.sock: Permission denied; ask as root, with `sudo`" in said
    assert "its control socket refuses you" in refused("doctor", "--json")
    for closed in (place.runtime / "t", place.runtime):
        closed.chmod(0o700)
        for command in ("list", "status"):
            said = refused(command)
            assert f"{closed} of root (0) is closed to you: ask as root" in said
    os.chown(place.runtime / "t" / "control.sock", -1, 20)
    for folder in (place.runtime, place.runtime / "t"):
        folder.chmod(0o755)
    assert "or join its group: as root `usermod -aG dialout USER`, then log in again" in refused("status")


def test_a_bench_that_hangs_beside_one_that_answers_is_said(place: Place) -> None:
    place.serve(config())
    (place.runtime / "f").mkdir()
    with answering(place.runtime / "f" / "control.sock", lambda _: b""):
        said = place.hil("list", code=1)
        assert "hil: what listens at" in said
        assert "gives no answer: it hung up" in said
        assert "m1" in said
        alone = place.hil("list", "--json", "-b", "f", code=1)
        assert "it hung up" in json.loads(alone)["error"]["message"]
    assert "m1" in place.hil("list", "-b", "t")


def test_each_silence_has_its_name(place: Place) -> None:
    (place.runtime / "t").mkdir(parents=True)
    path = place.runtime / "t" / "control.sock"
    with pytest.raises(BenchEnded, match="the bench has ended, or was never there"):
        ask(path, "list")
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(path))
        listener.listen(1)
        with pytest.raises(BenchLate, match=r"bench t of .* within 0.1 s: .* `hil doctor` says more"):
            ask(path, "list", timeout_s=0.1)
    with pytest.raises(BenchEnded, match=f"its bench was killed; .*`rm -r {path.parent}`"):
        ask(path, "list")
    assert "one was killed that had" in place.hil("status", code=1)
    nowhere = place.runtime / "x"
    said = place.hil("--runtime-dir", str(nowhere), "list")
    assert said.startswith(f"No bench is running here: there is no folder {nowhere}; `hil --runtime-dir")


def test_a_bench_elsewhere_is_said_where_nobody_named_a_folder(place: Place) -> None:
    place.serve(config())
    (place.folder / "empty").mkdir()
    env = os.environ | TERMINAL | {"XDG_RUNTIME_DIR": str(place.folder / "empty")}
    done = subprocess.run([HIL, "-b", "t", "status"], env=env, capture_output=True, text=True, timeout=60)
    if "no bench is running here" in done.stderr:  # else a service runs on this computer
        assert "elsewhere there is" in done.stderr
    assert [each for each in others_sockets() if each == place.runtime / "t" / "control.sock"]


def test_two_benches_of_one_name_are_told_apart(place: Place) -> None:
    first = place.serve(config("t"))
    place.state.joinpath("x").mkdir(parents=True)
    path = place.write(config("t", devices={"m5": {}}), "inner.yaml")
    where = ("--runtime-dir", str(place.runtime / "x"), "--state-dir", str(place.state / "x"))
    second = subprocess.Popen([HIL, "serve", str(path), *where], stdout=subprocess.PIPE)
    try:
        assert second.stdout
        while b"Ctrl-C ends" not in second.stdout.readline():
            assert second.poll() is None
        folders = [place.runtime / "t", place.runtime / "x" / "t"]
        for said in ((), ("-b", "t")):
            ones = (
                ["reset", "m1"],
                ["monitor", "m1"],
                ["axis", "m1"],
            )  # of one bench alone, if none is named
            for command in (["status"], *(ones if said else ())):
                text = place.cli(*command, *said, code=2)
                for folder, pid in zip(folders, (first.pid, second.pid), strict=True):
                    assert f"--bench {folder}: {folder}, of " in text
                    assert f"process {pid}, since 20" in text
        text = place.cli("axis", "m5", "-b", str(folders[1]))
        assert "move-abs" in text
        assert "no device 'm5'" in place.cli("axis", "m5", "-b", str(folders[0]), code=2)
        base = ("--runtime-dir", str(place.runtime))
        assert place.hil("_names", "devices", "reset", *base) == ""
        assert place.hil("_names", "devices", "reset", "-b", str(folders[1]), *base) == "m5\tmechaduino\n"
        offered = [
            line.split("\t")[0] for line in place.hil("_names", "benches", "reset", *base).splitlines()
        ]
        assert offered == [str(folder) for folder in folders]
    finally:
        second.terminate()
        second.communicate(timeout=PATIENCE_S)


ODD = (
    b"", b"\n", b"x\n", b"[]\n", b"null\n", b"{}\n", b'{"ok": 1}\n', b'{"ok": true}\n', b'{"ok": false}\n',
    b'{"ok": false, "error": 7}\n', b'{"ok": true, "result": null}\n', b'{"ok": true, "result": []}\n',
    b'{"ok": true, "result": [[]]}\n', b'{"ok": true, "result": {}}\n', b'{"ok": true, "result": [{}]}\n',
    b'{"ok": true, "result": "x"}\n', b'{"ok": true, "result": NaN}\n', b"\xff\xfe\n", b"[" * 100_000 + b"\n",
    b'{"ok": true, "result": ' + b"[" * 100_000 + b"]" * 100_000 + b"}\n",
    b'{"ok": true, "result": ' + b"9" * 5000 + b"}\n", b'{"ok": true',
)  # fmt: skip


def outcome(place: Place, command: tuple[str, ...], where: tuple[str, ...]) -> str:
    """Exit code and output of a command, which must end without a traceback."""
    words = [word.format(folder=place.folder) for word in command]
    done = CliRunner().invoke(app, [*words, *where], env=TERMINAL, input="")
    assert done.exception is None or isinstance(done.exception, SystemExit), (words, done.exc_info)
    assert "Traceback" not in done.output
    return f"{done.exit_code} {done.output}"


def test_any_bytes_as_an_answer_are_a_sentence(place: Place) -> None:
    (place.runtime / "t").mkdir(parents=True)
    place.write(RUN, "run.yaml")
    where = ("--runtime-dir", str(place.runtime))
    for odd in ODD:
        with answering(place.runtime / "t" / "control.sock", lambda _, odd=odd: odd):
            for command in ASKING:
                said = outcome(place, command, where)
                if b'"result": ' not in odd[:60]:
                    assert said.startswith("1 hil: "), (odd[:60], command, said)


def test_an_answer_that_never_ends_ends(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(client, "ANSWER_BYTES", 1 << 20)
    (place.runtime / "t").mkdir(parents=True)
    path = place.runtime / "t" / "control.sock"
    with answering(path, lambda _: b"x" * (3 << 20)), pytest.raises(ControlError, match="longer than 1 MB"):
        ask(path, "list")
    ended = threading.Event()

    def trickle(_: dict[str, Any]) -> bytes:
        ended.wait(PATIENCE_S)
        return b"\n"

    with answering(path, trickle):
        begun_s = time.monotonic()
        with pytest.raises(ControlError, match=r"within 0\.3 s"):
            ask(path, "list", timeout_s=0.3)
        assert 0.2 < time.monotonic() - begun_s < PATIENCE_S
        ended.set()


def mutated(value: Any, random: Random) -> Any:
    """Copy of a value with one thing in it replaced by something else."""
    odd = (
        None,
        True,
        -1,
        10**400,
        2.5,
        float("nan"),
        float("inf"),
        "",
        "[/x]",
        "\x1b[2J\0",
        [],
        {},
        [[]],
        {"": 0},
    )
    if not isinstance(value, list | dict) or not value or random.random() < 0.1:
        return random.choice(odd)
    changed = value.copy()
    key = random.choice(list(value) if isinstance(value, dict) else range(len(value)))
    if random.random() < 0.15:
        del changed[key]
    else:
        changed[key] = mutated(value[key], random)
    return changed


def test_mutated_answers_of_a_real_bench_are_a_sentence_or_shown(place: Place) -> None:
    segments = {"bus0": {"stations": ["s1"], "taps": {"a": {}}}}
    server = place.serve(config(devices={"m1": {}, "s1": SAC}, segments=segments)).ready()
    place.write(RUN, "run.yaml")
    server.ask("inject", fault="shaft_jam", target="m1", parameters={})
    random, fake = Random(22), place.runtime / "f"
    fake.mkdir()

    def answer(request: dict[str, Any]) -> bytes:
        verb = request.pop("verb")
        try:
            result = {} if verb == "capture" else ask(server.control, verb, **request)
        except ControlError as error:
            result = str(error)
        if verb in FORMS and verb != "capture":
            assert isinstance(result, str) or not misfit(verb, result), (verb, misfit(verb, result))
        if random.random() < 0.5:
            result = mutated(result, random)
        return json.dumps({"ok": True, "result": result}, default=str).encode() + b"\n"

    quick = [
        command
        for command in ASKING
        if command[0] not in ("plot", "step", "monitor", "sac", "list", "reload")
    ]
    with answering(fake / "control.sock", answer):
        for _ in range(25):
            for command in quick:
                outcome(place, command, ("--runtime-dir", str(fake)))
    assert server.process.poll() is None
