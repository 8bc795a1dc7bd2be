"""``hil with-lines``: what the program that it starts gets, and how it ends."""

import os
import pty
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from hil.host.preload import LIBRARY

HIL = [sys.executable, "-c", "from hil.cli.entry import main; main()", "with-lines"]


def ctrl_c_ends() -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # ignored if an & started the tests


def start(*words: str, **more: Any) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [*HIL, *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        stdin=subprocess.PIPE,
        text=True,
        **{"preexec_fn": ctrl_c_ends, **more},
    )


def ended(*words: str, **more: Any) -> tuple[int, str, str]:
    """Exit code, output and errors."""
    with start(*words, **more) as process:
        out, errors = process.communicate(timeout=60)
    return process.returncode, out, errors


def test_arguments_and_exit_code_are_the_programs() -> None:
    script = "import sys; print(sys.argv[1:]); sys.exit(7)"
    words = ["--json", "--help", "-h", "--bench", "a b", ""]
    assert ended(sys.executable, "-c", script, *words) == (7, f"{words}\n", "")


def test_signals_and_streams_are_the_programs() -> None:
    script = (
        "import os, signal\n"
        "signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})\n"
        "print(os.getpid(), *[int(s) for s in signal.sigpending()], flush=True)\n"
        "print(input(), flush=True)\n"
        "print(signal.sigwait({signal.SIGTERM}))\n"
    )
    with start(sys.executable, "-c", script) as process:
        assert process.stdin
        assert process.stdout
        assert process.stdout.readline() == f"{process.pid}\n"
        process.stdin.write("typed\n")
        process.stdin.flush()
        assert process.stdout.readline() == "typed\n"
        process.send_signal(signal.SIGTERM)
        assert process.stdout.read() == f"{signal.SIGTERM.value}\n"
    assert process.returncode == 0
    assert ended("sh", "-c", "kill -INT $$")[0] == -signal.SIGINT


def dispositions(status: str) -> set[int]:
    """Ignored signals of /proc/PID/status."""
    (mask,) = (int(line.split()[1], 16) for line in status.splitlines() if line.startswith("SigIgn"))
    return {number for number in range(1, 65) if mask >> (number - 1) & 1}


def test_what_is_ignored_is_what_the_shell_said() -> None:
    assert dispositions(ended("cat", "/proc/self/status")[1]) & {signal.SIGPIPE, signal.SIGINT} == set()

    def ignore() -> None:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # as a shell without job control does behind an &

    status = ended("cat", "/proc/self/status", preexec_fn=ignore)[1]
    assert dispositions(status) & {signal.SIGPIPE, signal.SIGINT} == {signal.SIGINT}


def test_nothing_but_the_library_is_new_to_the_program() -> None:
    env = {"PATH": os.environ["PATH"], "LD_PRELOAD": str(LIBRARY), "LC_ALL": "C"}
    shown = ended("env", env=env)[1].splitlines()
    assert set(shown) == {f"PATH={env['PATH']}", f"LD_PRELOAD={LIBRARY}:{LIBRARY}", "LC_ALL=C"}


def test_programs_that_it_starts_have_lines_too() -> None:
    master, slave = pty.openpty()
    script = "import fcntl, sys, termios; print(fcntl.ioctl(int(sys.argv[1]), termios.TIOCMGET, bytes(4)))"
    words = ("sh", "-c", '"$0" -c "$1" "$2"', sys.executable, script, str(slave))
    try:
        assert ended(*words, pass_fds=[slave]) == (0, f"{(0x166).to_bytes(4, 'little')}\n", "")
    finally:
        os.close(slave)
        os.close(master)


def test_a_pty_has_an_rs485_mode_and_a_latency() -> None:
    """As pyserial sets them: what was set is read back, and each pty has its own."""
    script = (
        "import fcntl, os, pty, struct, sys, termios\n"
        "GET_485, SET_485 = 0x542E, 0x542F\n"
        "a, b = pty.openpty()[1], pty.openpty()[1]\n"
        "mode = struct.pack('8I', 0b10111, 5, 7, *[0] * 5)\n"
        "fcntl.ioctl(a, SET_485, mode)\n"
        "print([struct.unpack('8I', fcntl.ioctl(each, GET_485, bytes(32)))[:3] for each in (a, b)])\n"
        "def latency(fd):\n"
        "    return struct.unpack_from('5i', fcntl.ioctl(fd, termios.TIOCGSERIAL, bytes(72)))[4]\n"
        "port = bytearray(72)\n"
        "struct.pack_into('i', port, 16, 0x2000)\n"
        "fcntl.ioctl(a, termios.TIOCSSERIAL, port)\n"
        "print(hex(latency(a)), hex(latency(b)))\n"
        "struct.pack_into('i', port, 16, 0x0030)\n"  # a divisor of its own
        "try: fcntl.ioctl(a, termios.TIOCSSERIAL, port)\n"
        "except OSError as error: print(error.strerror)\n"
        "try: fcntl.ioctl(os.open('/dev/null', os.O_RDWR), GET_485, bytes(32))\n"
        "except OSError as error: print(error.strerror)\n"
    )
    said = "[(23, 5, 7), (0, 0, 0)]\n0x2000 0x0\nInvalid argument\nInappropriate ioctl for device\n"
    assert ended(sys.executable, "-c", script) == (0, said, "")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "PROGRAM is missing"),
        (
            ["no-such-program", "--json"],
            "hil: there is no program 'no-such-program' in $PATH; install it, or write its whole path\n",
        ),
        (["./bad"], "hil: bad: Exec format error\n"),
        (["./empty", "x"], "hil: ./empty: you may not start it\n"),
    ],
)
def test_a_program_that_cannot_be_started(tmp_path: Path, words: list[str], said: str) -> None:
    (tmp_path / "empty").touch()
    (tmp_path / "bad").write_text("neither a script nor anything else\n")
    (tmp_path / "bad").chmod(0o755)
    env = os.environ | {"PYTHONPATH": os.getcwd()}
    code, out, errors = ended(*words, cwd=tmp_path, env=env)
    assert (code, out) == (2, "")
    assert said in errors
