"""Bootloader of a user's own: the chip itself answers a tool, and writes its flash."""

import subprocess
from collections.abc import Iterator
from pathlib import Path
from shutil import which

import pytest
from upload_tool import UploadTool

from hil.sketch.chip_program import SECTION, unpacked
from hil.testing import Bench

SOURCE = Path(__file__).with_name("small_bootloader.c")
BLINKER = """\
#include <avr/io.h>
int main(void) { DDRB = 32; TCCR1B = 3; for (;;) if (TCNT1 > 2500) { TCNT1 = 0; PINB = 32; } }
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if which("avr-gcc") is None:
        pytest.skip("avr-gcc is not installed: apt install gcc-avr avr-libc")
    folder = tmp_path_factory.mktemp("boot")
    (folder / "blinker.c").write_text(BLINKER)
    in_boot_section = ["-nostartfiles", "-Wl,--section-start=.text=0x7E00"]
    for source, name, options in ((SOURCE, "boot", in_boot_section), ("blinker.c", "blinker", [])):
        built = ["avr-gcc", "-mmcu=atmega328p", "-DF_CPU=16000000", "-Os", *options, "-o", f"{name}.elf"]
        subprocess.run([*built, source], cwd=folder, check=True)
        copied = ["avr-objcopy", "-O", "ihex", f"{name}.elf", f"{name}.hex"]
        subprocess.run(copied, cwd=folder, check=True)
    return folder


@pytest.fixture
def bench(folder: Path) -> Iterator[Bench]:
    file = folder / "bench.yaml"
    file.write_text("bench: t\ndevices:\n  u1: {profile: uno, bootloader: boot.hex}\n")
    with Bench(file) as made:
        yield made


def blinks(bench: Bench) -> bool:
    begun_ns = bench.now_ns
    bench.run(ms=100)
    return any(at_ns > begun_ns for at_ns, _ in bench.device("u1").pin("D13").edges())


def test_it_takes_an_upload_and_starts_the_sketch(bench: Bench, folder: Path) -> None:
    from hil.sketch.chip_program import read_program

    blinker = read_program("blinker.hex", (folder / "blinker.hex").read_bytes()).flash
    bench.run(ms=200)
    assert not blinks(bench)
    tool = UploadTool(bench.serial("u1", timeout=0.2))
    bench.run(ms=70)
    tool.sync()
    tool.write(blinker)
    assert tool.read(len(blinker)) == blinker
    assert tool.ask(b"u", 3) == b"\x1e\x95\x0f"
    tool.leave()
    bench.run(ms=200)
    assert blinks(bench)
    assert unpacked(bench.device("u1").nvm[SECTION]).flash == blinker
    assert bench.device("u1").notes["runs"].startswith("runs what was uploaded, ")
    assert "behind the bootloader boot.hex, " in bench.device("u1").notes["runs"]
    bench.device("u1").reset()
    bench.run(ms=200)
    assert blinks(bench)
    with Bench(folder / "bench.yaml", memories={"u1": dict(bench.device("u1").nvm)}) as again:
        again.run(ms=200)
        assert blinks(again)


def test_silence_starts_the_sketch(bench: Bench, folder: Path) -> None:
    file = folder / "with_program.yaml"
    file.write_text("bench: t\ndevices:\n  u1: {profile: uno, bootloader: boot.hex, firmware: blinker.hex}\n")
    with Bench(file) as made:
        made.run(ms=200)
        assert blinks(made)
        made.serial("u1").close()
        made.run(ms=400)
        assert not blinks(made)  # the bootloader waits
        made.run(ms=300)
        assert blinks(made)
