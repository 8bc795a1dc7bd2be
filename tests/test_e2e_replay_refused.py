"""`hil replay` of what is no log: a sentence and 2, at once."""

import json
import os
import signal
import socket
import subprocess
import time
from pathlib import Path

import pytest
from e2e_support import HIL, PATIENCE_S, TERMINAL, until
from typer.testing import CliRunner

from hil.cli.framework.command_group import app

DEVICE = {"profile": "mechaduino", "port": "memory", "flash": {"table": "identity"}}


def log_of(*lines: object, **header: object) -> str:
    first = {"format": "hil-inputs", "version": 2, "program": "hil test", "nvm": {}}
    config = {"bench": "b", "devices": {"m1": DEVICE}}
    return "".join(json.dumps(line) + "\n" for line in [first | {"config": config} | header, *lines])


def replay(path: Path | str, code: int) -> str:
    """Run ``hil replay``, and return its output."""
    done = CliRunner().invoke(app, ["replay", str(path)], env=TERMINAL)
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exc_info
    assert done.exit_code == code, done.output
    return done.output


def refused(path: Path | str) -> str:
    return replay(path, 2)


def test_what_is_no_file_is_refused_at_once(tmp_path: Path) -> None:
    fifo, sock = tmp_path / "fifo", tmp_path / "sock"
    os.mkfifo(fifo)
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(sock))
        for path, why in [
            (fifo, "it is a FIFO, not a regular file"),
            (sock, "it is a socket, not a regular file"),
            (Path("/dev/zero"), "it is a character device, not a regular file"),
            (tmp_path, "Is a directory; write a file in it"),
            (tmp_path / "none", "No such file or directory; write a path that is there"),
        ]:
            assert refused(path) == f"hil: {path}: {why}\n"


def test_what_is_no_log_is_refused_with_its_place(tmp_path: Path) -> None:
    path = tmp_path / "some.log"
    reset = {"at_ns": 5, "device": "m1", "input": "reset"}
    for text, why in [
        ("", "1: this is no recording: it has no whole line; `hil recordings` lists those"),
        ("hello\n", "1: this is no recording; `hil recordings` lists those that are there"),
        (log_of(format="x"), "1: this is no recording; `hil recordings` lists"),
        (log_of(reset) + "{broken\n", "3: this line is damaged: it is no JSON; take a log as `hil serve"),
        (log_of(version=4), "1: the log has version 4, of hil test; this program reads 1, 2 and 3; "),
        (
            log_of(reset, reset | {"at_ns": 2**63 - 1}),
            "3: at_ns: write a whole number from 0 to 46116860184273879",
        ),
        (
            log_of(reset, reset | {"at_ns": 4}),
            "3: time goes back: 4 ns, and m1 was at 5 ns already; replay it",
        ),
        (
            log_of(reset, reset | {"device": "m2"}),
            "3: there is no device 'm2'; there are m1; replay it with what",
        ),
        (
            log_of({**reset, "input": "do", "verb": "fly", "parameters": []}),
            "2: m1: a mechaduino has no verb 'fly'",
        ),
        (log_of(nvm={"m1": {"lookup": 5}}), "1: the content of a memory has to be base64; take a log as"),
    ]:
        path.write_text(text)
        said = refused(path)
        assert said.startswith(f"hil: {path}:{why}"), said
        assert said.count("\n") == 1
    path.write_text(log_of(config={"bench": "b", "devices": {"m1": {"profile": "toaster"}}}))
    assert refused(path).startswith(f"hil: {path}:1: the configuration of this log is refused:\n")


def test_a_line_without_end_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "huge.log"
    path.write_text(log_of())
    os.truncate(path, 8 << 30)  # a hole
    begun_s = time.monotonic()
    assert refused(path).startswith(
        f"hil: {path}:2: a line without end; take a log as `hil serve --log` wrote it; all from line 2 on,"
        " after 0 s, is left out; before it, identical: 0 inputs, "
    )
    assert time.monotonic() - begun_s < PATIENCE_S / 2


@pytest.mark.thorough
def test_ctrl_c_ends_a_replay_of_a_century(tmp_path: Path) -> None:
    """The loop is on, and the next input comes after 146 years."""
    path = tmp_path / "long.log"
    on = {"at_ns": 4_600_000_000, "device": "m1", "input": "do", "verb": "enable", "parameters": []}
    path.write_text(log_of(on, {"at_ns": 2**62, "device": "m1", "input": "reset"}))

    def cpu_s(process: subprocess.Popen[str]) -> float:
        fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    with subprocess.Popen([HIL, "replay", str(path)], stderr=subprocess.PIPE, text=True) as process:
        try:
            until(lambda: cpu_s(process) > 3, "its start")
            assert process.poll() is None
            process.send_signal(signal.SIGINT)
            assert process.wait(PATIENCE_S) != 0
        finally:
            process.kill()
        assert process.stderr
        assert "Traceback" not in process.stderr.read()


@pytest.mark.parametrize("at_ns", [5, 2**61])
def test_a_silent_log_is_identical_however_long(tmp_path: Path, at_ns: int) -> None:
    path = tmp_path / "short.log"
    pin = {"at_ns": at_ns, "device": "m1", "input": "pin", "pin": "D3", "level": 1}
    path.write_text(log_of(pin) + "{")  # cut: what the board said is missing
    assert replay(path, 0).startswith("identical: 1 inputs, ")
