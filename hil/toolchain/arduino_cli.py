"""Build of a sketch by arduino-cli, where it is what is installed.

Source: "arduino-cli compile" of its documentation, and the sentences that it prints at the end.
"""

import os
import re
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from hil.toolchain.build_failed import BuildFailed
from hil.toolchain.run_program import run_program
from hil.toolchain.sketch_sources import SketchSources

BOARD = "arduino:avr:uno"
_FLASH = re.compile(r"Sketch uses (\d+) bytes")
_SRAM = re.compile(r"Global variables use (\d+) bytes")


class ByArduinoCli(NamedTuple):
    """Result of its build: files, sizes in bytes, and what the compiler has said."""

    hex: Path
    elf: Path
    flash_bytes: int
    sram_bytes: int
    said: str


def build_by_arduino_cli(
    program: str, sketch: SketchSources, output: Path, libraries: Sequence[Path], env: Mapping[str, str]
) -> ByArduinoCli:
    """Build a sketch. ``program``: arduino-cli's path.

    Raises:
        BuildFailed: in its own words.
    """
    given = [word for each in libraries for word in ("--libraries", str(each))]
    output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".sketch-", dir=output) as folder:
        words = [program, "compile", "-b", BOARD, "--output-dir", folder, *given, str(sketch.folder)]
        done = run_program(words, env)
        if done.returncode:
            raise BuildFailed(done.stderr.rstrip() or done.stdout.rstrip())
        files = [_in_place(Path(folder), output, sketch.name, ending) for ending in ("hex", "elf")]
    sizes = _number(_FLASH, done.stdout), _number(_SRAM, done.stdout)
    return ByArduinoCli(files[0], files[1], *sizes, done.stderr)


def _in_place(folder: Path, output: Path, name: str, ending: str) -> Path:
    made, place = folder / f"{name}.ino.{ending}", output / f"{name}.{ending}"
    try:
        os.replace(made, place)
    except FileNotFoundError:
        raise BuildFailed(f"arduino-cli made no {made.name}, and said no error") from None
    return place


def _number(pattern: re.Pattern[str], text: str) -> int:
    found = pattern.search(text)
    return int(found[1]) if found else 0
