"""The library with modem lines in other programs, and programs into which it does not get."""

import os
import pty
import stat
import struct
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from hil.host import preload
from hil.host.preload import PreloadRefused, find_program, with_library

LINES = """
import sys, serial
port = serial.Serial(sys.argv[1], 115200)
read = lambda: [port.cts, port.dsr, port.cd, port.ri]
port.dtr, port.rts = False, True
port.send_break(0.001)
print(read())
again = serial.Serial(sys.argv[1], 115200, exclusive=False, dsrdtr=True, rtscts=True)
again.dtr = True
print(read())
"""
NO_LINES = """
import fcntl, os, sys, termios
for fd in (os.open("/dev/ptmx", os.O_RDWR), os.open("/dev/null", os.O_RDWR), os.pipe()[0]):
    try:
        fcntl.ioctl(fd, termios.TIOCMGET, bytes(4))
    except OSError as error:
        print(error.errno)
"""


def elf(machine: int = 62, *, kind: int = 3, wide: bool = True) -> bytes:
    """An ELF file's header, with one program header: by default of one that a loader starts, for x86-64."""
    head = b"\x7fELF" + bytes([2 if wide else 1, 1, 1]) + bytes(9) + struct.pack("<HH", 2, machine)
    if wide:
        head += struct.pack("<IQQQIHHH", 1, 0, 64, 0, 0, 64, 56, 1)
    else:
        head += struct.pack("<IIIIIHHH", 1, 0, 52, 0, 0, 52, 32, 1)
    return head.ljust(64 if wide else 52, b"\0") + struct.pack("<I", kind) + bytes(60)


@pytest.fixture
def port() -> Iterator[str]:
    master, slave = pty.openpty()
    yield os.ttyname(slave)
    os.close(slave)
    os.close(master)


def said(script: str, *arguments: str) -> list[str]:
    """Lines that a script prints with the library."""
    command = [sys.executable, "-c", script, *arguments]
    done = subprocess.run(command, env=with_library(os.environ), capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout.splitlines()


def program(folder: Path, data: bytes, mode: int = 0o755) -> str:
    path = folder / "program"
    path.write_bytes(data)
    path.chmod(mode)
    return str(path)


def test_pyserial_sets_and_reads_lines_of_an_open_port(port: str) -> None:
    on = "[True, True, True, False]"
    assert said(LINES, port) == [on, on]


def test_other_files_have_none() -> None:
    assert said(NO_LINES) == ["25", "25", "25"]


def test_what_is_loaded_already_stays_first() -> None:
    assert with_library({"LD_PRELOAD": "/a.so", "X": "1"}) == {
        "LD_PRELOAD": f"/a.so:{preload.LIBRARY}",
        "X": "1",
    }
    assert with_library({})["LD_PRELOAD"] == with_library({"LD_PRELOAD": ""})["LD_PRELOAD"]


@pytest.mark.parametrize("name", ["a b", "a:b"])
def test_a_folder_that_the_loader_cannot_name(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    library = tmp_path / name / "lines.so"
    monkeypatch.setattr(preload, "LIBRARY", library)
    with pytest.raises(PreloadRefused, match="install hil again"):
        with_library({})
    library.parent.mkdir()
    library.touch()
    with pytest.raises(PreloadRefused, match="blanks or colons"):
        with_library({})


def test_programs_are_found_as_a_shell_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = program(tmp_path, b"#!/bin/sh\n")
    env = {"PATH": str(tmp_path)}
    assert str(find_program("program", env)) == path == str(find_program(path, {}))
    monkeypatch.chdir(tmp_path)
    assert find_program("./program", {}).resolve() == Path(path)
    for name, why in (
        ("sh", "there is no program 'sh' in"),
        ("./sh", "./sh: No such file"),
        ("./", "may not start"),
    ):
        with pytest.raises(PreloadRefused, match=why):
            find_program(name, env)
    program(tmp_path, b"#!/bin/sh\n", 0o644)
    with pytest.raises(PreloadRefused, match="may not start"):
        find_program(path, {})


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (elf(), ""),
        (elf(kind=1), "linked statically"),
        (elf(183), "another kind of processor"),
        (elf(3, wide=False), "32 bits"),
        (elf(3, kind=1, wide=False), "linked statically"),
        (elf()[:40], ""),
        (b"", ""),
        (b"#!", ""),
        (b"#!/nowhere\n", ""),
    ],
)
def test_programs_into_which_it_does_not_get(
    tmp_path: Path, data: bytes, why: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    ours = tmp_path / "ours.so"
    ours.write_bytes(elf())
    monkeypatch.setattr(preload, "LIBRARY", ours)
    path = program(tmp_path, data)
    script = tmp_path / "script"
    script.write_text(f"#!{path} -x\n")
    script.chmod(0o755)
    for started in (path, str(script)):  # the kernel starts a script's interpreter
        if why:
            with pytest.raises(PreloadRefused, match=f"gets no modem lines: .*{why}"):
                find_program(started, {})
        else:
            assert str(find_program(started, {})) == started


@pytest.mark.parametrize(("bit", "whose"), [(stat.S_ISUID, "user"), (stat.S_ISGID, "group")])
def test_a_program_with_the_rights_of_another(
    tmp_path: Path, bit: int, whose: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = program(tmp_path, b"", 0o755 | bit)
    assert str(find_program(path, {})) == path  # one's own rights
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    monkeypatch.setattr(os, "getegid", lambda: os.getgid() + 1)
    with pytest.raises(PreloadRefused, match=f"another {whose}"):
        find_program(path, {})


def test_a_program_with_capabilities(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = program(tmp_path, b"")
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    monkeypatch.setattr(os, "listxattr", lambda path: ["security.capability"])
    with pytest.raises(PreloadRefused, match="capabilities"):
        find_program(path, {})
