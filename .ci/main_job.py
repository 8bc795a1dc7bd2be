"""The main job against an installed hil, outside the tree: calibrate, x, y, r 90, p, j over pyserial; pages
of the documentation, the dissector and the library of modem lines, which have to be where it looks for them;
a program in virtual time, which stands on what this version of Python has inside.

Usage: main_job.py HIL. Prints what it did; exits with an error where the board did otherwise.
"""

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import serial

SPEED = 20
CONFIG = f"bench: wheel\nspeed: {SPEED}\ndevices:\n  m1:\n    profile: mechaduino\n"

PROGRAM = """
import asyncio, datetime, queue, serial, signal, threading, time
port, lines, rung = serial.Serial("m1", 115200, timeout=0.5), queue.Queue(), []
port.reset_input_buffer()
def read():
    while not rung:
        if line := port.readline(): lines.put(line)
thread = threading.Thread(target=read)
thread.start()
signal.signal(signal.SIGALRM, lambda *_: rung.append(time.monotonic()))
signal.setitimer(signal.ITIMER_REAL, 3600)
async def ask():
    port.write(b"p")
    return await asyncio.wait_for(asyncio.to_thread(lines.get), 1)
print(len(asyncio.run(ask())) > 20, time.monotonic())
signal.pause()
thread.join()
print(len(rung), datetime.datetime.now().minute, threading.active_count(), time.monotonic())
"""


def ask(port: serial.Serial, sent: bytes, awaited: bytes, timeout_s: float = 60) -> bytes:
    """Send, and read until the awaited bytes have come."""
    port.write(sent)
    got, end = b"", time.monotonic() + timeout_s
    while awaited not in got:
        got += port.read(4096)
        if time.monotonic() > end:
            raise SystemExit(f"after {sent!r}: no {awaited!r} in {got[-200:]!r}")
    return got


def work(port: serial.Serial) -> None:
    """The main job at a board that has just been switched on."""
    print(ask(port, b"m", b"print main menu")[-26:])
    print(ask(port, b"c", b"Flash memory!")[-40:])
    print(ask(port, b"xy", b"New setpoint ")[-20:])
    print(ask(port, b"r90\n", b"90.00\r\n")[-20:])
    print(ask(port, b"p", b"encoder: ")[-40:])
    print(ask(port, b"yj", b"1...\r\n")[-12:], ask(port, b"", b"99982", 30).count(b"\n"), "lines")


def show_pages(hil: str) -> None:
    """Print first lines of pages."""
    for topic in ("runs", "reference"):
        page = subprocess.run([hil, "docs", topic], capture_output=True, text=True, check=True).stdout
        assert page.startswith("# "), page[:80]
        print(f"hil docs {topic}: {page.splitlines()[0]}")


def find_dissector(hil: str, home: Path, *dirs: str) -> None:
    """Start something in Wireshark's place: it gets the capture, and a dissector that is there."""
    stand_in = home / "wireshark"
    stand_in.write_text(
        '#!/bin/sh\nshift 3\ntest "$1" = -X && test -s "${2#lua_script:}" || exit 9\necho "$2"\n'
    )
    stand_in.chmod(0o755)
    env = os.environ | {"PATH": f"{home}:{os.environ['PATH']}"}
    command = [hil, "capture", "m1", "--wireshark", *dirs]
    done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done
    print(done.stdout.strip())


def read_lines(hil: str, path: Path) -> None:
    """Let a program read modem lines, for which it loads a library of hil's."""
    program = "import serial, sys; port = serial.Serial(sys.argv[1]); port.dtr = False; print(port.cts)"
    command = [hil, "with-lines", sys.executable, "-c", program, str(path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout) == (0, "True\n"), done


def pass_time(hil: str, home: Path) -> None:
    """Run a program of threads and timers for an hour of simulated time, twice."""
    (home / "program.py").write_text(PROGRAM)
    command = [hil, "virtual", "bench.yaml", "program.py"]
    said = [
        subprocess.run(command, cwd=home, capture_output=True, text=True, timeout=60, check=False)
        for _ in range(2)
    ]
    assert [each.returncode for each in said] == [0, 0], said
    assert said[0].stdout == said[1].stdout, said
    print(said[0].stdout.replace("\n", "; "))


def main(hil: str) -> None:
    show_pages(hil)
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        (home / "bench.yaml").write_text(CONFIG)
        pass_time(hil, home)
        dirs = ["--runtime-dir", str(home / "run"), "--state-dir", str(home / "state")]
        daemon = subprocess.Popen(
            [hil, "serve", "bench.yaml", *dirs], cwd=home, stdout=subprocess.PIPE, text=True
        )
        assert daemon.stdout
        print(daemon.stdout.readline().strip())
        path = home / "run" / "wheel" / "m1"
        with serial.Serial(str(path), 115200, timeout=0.1) as port:
            work(port)
        read_lines(hil, path)
        status = subprocess.run([hil, "status", "--json", *dirs[:2]], capture_output=True, check=True)
        print(status.stdout[:60])
        find_dissector(hil, home, *dirs[:2])
        daemon.send_signal(signal.SIGTERM)
        assert daemon.wait(10) == 0
        assert not path.parent.exists(), os.listdir(path.parent)
        print("main job from the wheel: ok")


if __name__ == "__main__":
    main(sys.argv[1])
