"""Whole programs on simulated time, each in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from hil.testing.owned_time.tests.programs import PROGRAMS

BENCH = "bench: b\ndevices:\n  m1: {profile: mechaduino, flash: {table: identity}}\n"
HIL = (sys.executable, "-P", "-c", "import sys; sys.argv[0] = 'hil'; from hil.cli.entry import main; main()")
PATIENCE_S = 120


def run(
    folder: Path, text: str, *words: str, options: tuple[str, ...] = (), given: str = ""
) -> "subprocess.CompletedProcess[str]":
    (folder / "bench.yaml").write_text(BENCH)
    (folder / "program.py").write_text(text)
    command = [*HIL, "virtual", "bench.yaml", *options, "program.py", *words]
    return subprocess.run(
        command,
        cwd=folder,
        input=given,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1", "TZ": "UTC"},
    )


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_program_does_as_on_a_real_port(tmp_path: Path, name: str) -> None:
    text, prints = PROGRAMS[name]
    done = run(tmp_path, text)
    assert done.stdout.strip() == prints, done.stderr
    assert done.returncode == 0


def test_two_runs_are_the_same_to_the_byte(tmp_path: Path) -> None:
    text = """
import serial, threading, time
s = serial.Serial("m1", 115200, timeout=0.05); polls = []
def poll():
    while len(polls) < 60: s.write(b"p"); polls.append((time.perf_counter_ns(), s.readline()))
threads = [threading.Thread(target=poll) for _ in range(3)]
for each in threads: each.start()
looks = 0
while any(each.is_alive() for each in threads): looks += time.time() > 0
print(looks, polls)
"""
    first, second = run(tmp_path, text), run(tmp_path, text)
    assert first.stdout == second.stdout
    assert len(first.stdout) > 1000, first.stderr


def test_a_path_is_mapped_to_a_port(tmp_path: Path) -> None:
    text = "import serial, sys; print(serial.Serial(sys.argv[1]).name, sys.argv[1:])"
    done = run(tmp_path, text, "/dev/ttyUSB0", "-x", options=("--map", "/dev/ttyUSB0=m1"))
    assert done.stdout == "/dev/ttyUSB0 ['/dev/ttyUSB0', '-x']\n"


def test_ports_are_listed_and_opened_by_a_url(tmp_path: Path) -> None:
    text = """
import serial
from serial.tools import list_ports
for port in list_ports.comports(): print(port.device, f"{port.vid:04x}:{port.pid:04x}", port.serial_number)
print([each.device for each in list_ports.grep("ttyUSB")])
serial.protocol_handler_packages.append("hil.testing.serial_ports")
for url in ("hil://m1", "hil://b/m1"):
    with serial.serial_for_url(url, timeout=1) as port:
        port.reset_input_buffer(); port.write(b"p"); print(port.readline()[:4], type(port) is serial.Serial)
try: serial.serial_for_url("hil://m7")
except serial.SerialException as error: print(str(error)[:39])
"""
    done = run(tmp_path, text, options=("--map", "/dev/ttyUSB0=m1"))
    assert done.stdout.splitlines() == [
        "/dev/ttyUSB0 2341:804d b.m1",
        "['/dev/ttyUSB0']",
        *["b'step' True"] * 2,
        "there is no port hil://m7: there are m1",
    ], done.stderr


def test_a_wait_without_end_names_each_thread(tmp_path: Path) -> None:
    text = """
import serial, threading
s = serial.Serial("m1"); s.reset_input_buffer(); lock = threading.Lock(); lock.acquire()
threading.Thread(target=lock.acquire, name="second").start()
s.read(1)
"""
    done = run(tmp_path, text)
    assert done.returncode == 1
    said = done.stderr.splitlines()[-3:]
    assert said[0].endswith("every thread waits, and nothing will end it:")
    assert said[1:] == [
        "  MainThread waits for read at m1 at program.py:5",
        "  second waits for a lock that MainThread has",
    ]


def test_a_thread_that_never_waits_is_named_and_left_beside(tmp_path: Path) -> None:
    text = """
import threading, time
seen = []
threading.Thread(target=lambda: (time.sleep(0.1), seen.append(1))).start()
while not seen: pass
print("seen")
"""
    done = run(tmp_path, text)
    assert done.stdout == "seen\n"
    assert done.stderr == (
        "hil: MainThread has not waited for 0.5 s at program.py:5: the others go on beside it, at the"
        " wall's pace; another run may differ\n"
    )


def test_input_waits_at_the_keyboard(tmp_path: Path) -> None:
    assert run(tmp_path, 'print(input("name? "))', given="bob\n").stdout == "name? bob\n"


@pytest.mark.parametrize(
    ("text", "code", "said"),
    [
        ("raise SystemExit(3)", 3, ""),
        (
            "raise KeyboardInterrupt",
            -2,
            'program.py", line 1, in <module>\n    raise KeyboardInterrupt\n',
        ),
        ("1 / 0", 1, 'Traceback (most recent call last):\n  File "program.py", line 1, in <module>'),
        (
            "import os\nos.fork()",
            1,
            "RuntimeError: hil virtual: a process of multiprocessing, or a forked one",
        ),
        (
            "import multiprocessing\nmultiprocessing.Process(target=print).start()",
            1,
            "use threads, or a child by subprocess, which has the wall's time",
        ),
        ("import threading\nthreading.Thread(target=lambda: 1 / 0).start()", 0, "ZeroDivisionError"),
        ("def f(:", 1, "SyntaxError"),
        ("import serial; serial.Serial('/dev/x')", 1, "there are m1; or give --map /dev/x=m1"),
    ],
)
def test_ends_of_programs(tmp_path: Path, text: str, code: int, said: str) -> None:
    done = run(tmp_path, text)
    assert said in done.stderr
    assert done.returncode == code


@pytest.mark.parametrize(
    ("options", "program", "said"),
    [
        (("--map", "/dev/ttyUSB0"), "program.py", "is no path and port; write them as in /dev/ttyUSB0=m1"),
        (("--map", "x=m7"), "program.py", "there is no port 'm7'; there are m1"),
        (("--date", "soon"), "program.py", "--date soon: write it as 2026-01-31T12:00:00, or now"),
        ((), "nothing.py", "nothing.py: there is no such program"),
        ((), "/bin/true", "/bin/true is no Python program"),
        (("-m",), "nosuchmod", "hil: there is no module 'nosuchmod'; write one that python -m finds from"),
    ],
)
def test_mistakes_are_told_before_the_program_begins(
    tmp_path: Path, options: tuple[str, ...], program: str, said: str
) -> None:
    (tmp_path / "bench.yaml").write_text(BENCH)
    (tmp_path / "program.py").write_text("print('begun')")
    command = [*HIL, "virtual", "bench.yaml", *options, program]
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE_S, check=False
    )
    assert said in done.stderr
    assert done.returncode == 2
    assert done.stdout == ""


def test_a_configuration_with_mistakes_is_told(tmp_path: Path) -> None:
    (tmp_path / "bench.yaml").write_text("bench: b\ndevices: {m1: {profile: mechaduinu}}\n")
    (tmp_path / "program.py").write_text("print('begun')")
    command = [*HIL, "virtual", "bench.yaml", "program.py"]
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE_S, check=False
    )
    assert "bench.yaml:2:25" in done.stderr
    assert done.returncode == 2
