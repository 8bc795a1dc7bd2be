"""Compiler for AVR and Arduino's core for it, where Debian's packages put them; and arduino-cli."""

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from hil.toolchain.build_failed import NoToolchain

CORE = Path("/usr/share/arduino/hardware/arduino/avr")
"""Folder of arduino-core-avr."""
COMPILER_PACKAGES = "gcc-avr avr-libc"
CORE_PACKAGE = "arduino-core-avr"
_OR = "or install arduino-cli, and `arduino-cli core install arduino:avr`"


class AvrTools(NamedTuple):
    """Programs, by their paths. ``core``: folder of Arduino's core, None where it is not installed."""

    gcc: str
    gxx: str
    ar: str
    objcopy: str
    size: str
    core: Path | None


def find_avr_tools(env: Mapping[str, str], core: Path = CORE) -> AvrTools:
    """Find the compiler.

    Raises:
        NoToolchain: it is not installed.
    """
    names = ("avr-gcc", "avr-g++", "avr-gcc-ar", "avr-objcopy", "avr-size")
    found = [shutil.which(name, path=env.get("PATH")) for name in names]
    if None in found:
        missing, packages = names[found.index(None)], f"{COMPILER_PACKAGES} {CORE_PACKAGE}"
        raise NoToolchain(f"{missing} is not installed: `apt install {packages}`, {_OR}")
    gcc, gxx, ar, objcopy, size = (each or "" for each in found)
    return AvrTools(gcc, gxx, ar, objcopy, size, core if (core / "cores").is_dir() else None)


def find_arduino_cli(env: Mapping[str, str]) -> str | None:
    return shutil.which("arduino-cli", path=env.get("PATH"))


def core_of(tools: AvrTools) -> Path:
    """Folder of Arduino's core.

    Raises:
        NoToolchain: it is not installed.
    """
    if tools.core is None:
        raise NoToolchain(f"Arduino's core for AVR is not installed: `apt install {CORE_PACKAGE}`, {_OR}")
    return tools.core
