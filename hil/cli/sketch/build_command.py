"""``hil sketch build``."""

import os
from pathlib import Path
from typing import Annotated

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.progress_bars import bar


def build(
    folder: Annotated[
        Path,
        typer.Argument(
            help="Folder of a sketch, with an .ino of its name, or of a plain program."
            " [default: the current one]",
            show_default=False,
        ),
    ] = Path(),
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="Folder of the .hex and the .elf. [default: build in the sketch's]",
            metavar="FOLDER",
        ),
    ] = None,
    libraries: Annotated[
        list[Path] | None,
        typer.Option(
            "--libraries",
            help="Folder of libraries, beside `libraries` in the sketch's folder and next to it; may be"
            " repeated.",
            metavar="FOLDER",
        ),
    ] = None,
    lto: Annotated[
        bool,
        typer.Option(
            "--lto", help="As the Arduino IDE: smaller, and functions that are dissolved have no names."
        ),
    ] = False,
    warnings: Annotated[
        bool, typer.Option("--warnings", help="Show what the compiler warns of in the sketch.")
    ] = False,
) -> CommandAnswer:
    """Build a sketch for an Arduino Uno: NAME.hex and NAME.elf.

    With the compiler and the Arduino core that are installed (Debian's gcc-avr, avr-libc, arduino-core-avr),
    or by arduino-cli. The core is compiled once and kept in the cache. A folder without an .ino is a plain
    program in C, C++ or assembler, without the core. Errors are the compiler's, with the sketch's own lines;
    exits with 2 then, and with 1 if something is not installed.

    Example: hil sketch build sketches/blink
    """
    from hil.toolchain.build_failed import BuildFailed, NoToolchain
    from hil.toolchain.sketch_build import FLASH_BYTES, SRAM_BYTES, BuildOptions, build_sketch

    try:
        with bar(f"{folder.resolve().name} is built"):
            built = build_sketch(folder, BuildOptions(output, libraries or (), lto, warnings), os.environ)
    except NoToolchain as error:
        raise fail(f"hil: {error}", Exit.FAILED) from None
    except BuildFailed as error:
        raise fail(str(error), Exit.MISTAKE) from None
    answer = {
        "hex": str(built.hex),
        "elf": str(built.elf),
        "flash_bytes": built.flash_bytes,
        "sram_bytes": built.sram_bytes,
        "said": built.said,
    }
    sizes = [
        f"{what}: {used:,} of {room:,} bytes ({100 * used / room:.0f} %)"
        for what, used, room in (
            ("flash", built.flash_bytes, FLASH_BYTES),
            ("SRAM", built.sram_bytes, SRAM_BYTES),
        )
    ]
    said = [built.said.rstrip()] if built.said else []
    return CommandAnswer(answer, "\n".join([*said, str(built.hex), *sizes]))
