"""Real tools at the port of a Uno in real time: avrdude uploads, and is cut, disturbed and refused."""

import subprocess
from pathlib import Path
from random import Random
from shutil import which

import pytest
from e2e_support import Place, Server, config, reload, until

from hil.sketch.chip_program import flash_program
from hil.sketch.intel_hex import write_hex

pytestmark = pytest.mark.skipif(
    which("avrdude") is None, reason="avrdude is not installed: apt install avrdude"
)

IDLE = b"\xff\xcf"
"""RJMP to itself."""
UNO = {"u1": {"profile": "uno", "flash": {}}}
NO_PROGRAM = "runs hil's own sketch: there is no program in the flash"


def program(size: int, seed: int = 1) -> bytes:
    return IDLE + Random(seed).randbytes(size - len(IDLE))


def hex_file(place: Place, flash: bytes) -> Path:
    file = place.folder / "x.hex"
    file.write_bytes(write_hex([(0, flash)]))
    return file


def runs(flash: bytes) -> str:
    return f"runs {flash_program('what was uploaded', flash).title}"


def note(server: Server) -> str:
    return str(server.status("u1")["note"])


def avrdude(server: Server, *arguments: str, baud: int = 115200) -> "subprocess.Popen[str]":
    address = server.ask("list")["devices"][0]["address"]
    line = ("-q", "-p", "atmega328p", "-c", "arduino", "-D", "-P", address, "-b", str(baud))
    to_pipe = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    return subprocess.Popen(["avrdude", *line, *arguments], text=True, **to_pipe)


def done(server: Server, *arguments: str, code: int = 0) -> str:
    with avrdude(server, *arguments) as tool:
        said, _ = tool.communicate(timeout=100)
    assert tool.returncode == code, said
    return said


@pytest.mark.parametrize(
    "speed", [1, *(pytest.param(each, marks=pytest.mark.thorough) for each in (0.5, 10))]
)
def test_an_upload_is_verified_at_any_speed_and_outlives_the_daemon(place: Place, speed: float) -> None:
    server, flash = place.serve(config(speed=speed, devices=UNO)), program(2000)
    assert note(server) == NO_PROGRAM
    assert "2000 bytes of flash verified" in done(server, f"-Uflash:w:{hex_file(place, flash)}:i")
    server.kill()
    server = place.serve(config(speed=speed, devices=UNO))
    until(lambda: note(server) == runs(flash), "the program")
    fuses = done(server, *(f"-U{name}:r:-:h" for name in ("lfuse", "hfuse", "efuse", "lock", "signature")))
    assert [line for line in fuses.splitlines() if line[:2] == "0x"] == [
        *("0xff", "0xde", "0xfd", "0xf", "0x1e,0x95,0xf")
    ]
    server.stop()


@pytest.mark.thorough
def test_an_upload_that_is_killed_leaves_other_pages(place: Place) -> None:
    server, old, new = place.serve(config(speed=1, devices=UNO)), program(8192), program(8192, 2)
    done(server, f"-Uflash:w:{hex_file(place, old)}:i", "-V")
    with avrdude(server, f"-Uflash:w:{hex_file(place, new)}:i") as tool:
        until(lambda: server.status("u1")["rx_bytes"] > 12_000, "a part of it")
        tool.kill()
    until(lambda: note(server) not in (runs(old), "runs the bootloader"), "the end of the window")
    back = place.folder / "back.bin"
    done(server, f"-Uflash:r:{back}:r")
    flash = back.read_bytes()[:8192]
    written = next(page for page in range(64) if flash[page * 128 :] == old[page * 128 :])
    assert 0 < written < 64
    assert flash[: written * 128] == new[: written * 128]
    server.stop()


def test_what_cannot_be_uploaded_is_said(place: Place) -> None:
    server, flash = place.serve(config(speed=1, devices=UNO)), program(300)
    done(server, f"-Uflash:w:{hex_file(place, flash)}:i")
    done(server, f"-Ueeprom:w:{hex_file(place, b'ab')}:i", code=1)
    assert "a tool wanted the EEPROM" in note(server)
    done(server, "-Ulfuse:w:0x62:m", code=1)
    assert "a tool wanted to write fuses" in note(server)
    with avrdude(server, f"-Uflash:w:{hex_file(place, program(300, 2))}:i", baud=57600) as tool:
        until(lambda: server.status("u1")["rx_bytes"] > 700, "bytes at a wrong speed")
        tool.kill()
    until(lambda: runs(flash) in note(server), "the sketch")
    server.stop()


def test_a_file_that_changes_under_the_bench_is_noted_until_a_reload_takes_it(place: Place) -> None:
    old, new = program(300), program(300, 2)
    file = hex_file(place, old)
    devices = {"u1": UNO["u1"] | {"firmware": file.name}}
    server = place.serve(config(speed=1, devices=devices))
    title, changed = flash_program(file.name, old).title, flash_program(file.name, new).title
    until(lambda: note(server) == f"runs {title}", "the program")
    file.touch()
    assert note(server) == f"runs {title}"
    hex_file(place, new)
    assert note(server) == f"runs {title}; x.hex has changed; `hil reload` takes it"
    file.write_bytes(b":00")
    assert "x.hex has changed, and cannot be used: " in note(server)
    file.unlink()
    assert "x.hex cannot be read any more (No such file or directory)" in note(server)
    assert "x.hex cannot be read: No such file" in str(server.ask("reload")["problems"])
    hex_file(place, new)
    assert reload(place, server, devices, speed=1)["restarted"] == ["u1"]
    until(lambda: note(server) == f"runs {changed}", "the other program")
    done(server, f"-Uflash:w:{hex_file(place, old)}:i")
    assert note(server).endswith("x.hex has changed; `hil reload` takes it")
    hex_file(place, new)
    until(lambda: note(server) == runs(old), "what was uploaded")
    assert reload(place, server, devices, speed=1)["kept"] == ["u1"]
    assert note(server) == runs(old)
    server.stop()
