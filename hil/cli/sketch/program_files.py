"""Programs that commands are given as files, and the symbols of the one that runs."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.exit_codes import Exit
from hil.sketch.chip_program import MOST_FILE_BYTES, ChipProgram, read_program
from hil.sketch.elf_file import Symbol
from hil.sketch.program_error import ProgramError

Elf = Annotated[
    Path | None,
    typer.Option(
        "--elf",
        help="ELF file of the program, for its symbols, if it was loaded without. [default: one of the same"
        " bytes, here or in a folder build]",
        metavar="FILE",
    ),
]
_BUILT = ("*.elf", "build/*.elf", "*/build/*.elf", ".pio/build/*/*.elf")
"""Places, from the current folder on, in which builds leave ELF files; the last are PlatformIO's."""


def content_of(file: Path) -> bytes:
    """Read a program's file, or say why it cannot be read and end the command."""
    try:
        return _content(file)
    except OSError as error:
        raise fail(f"hil: {file}: {error.strerror}", Exit.MISTAKE) from None


def _content(file: Path) -> bytes:
    from hil.host.regular_file import read_regular

    return read_regular(file, MOST_FILE_BYTES)


def program_of(file: Path) -> ChipProgram:
    """Read a program, or say what is wrong with it and end the command."""
    try:
        return read_program(str(file), content_of(file))
    except ProgramError as error:
        raise fail(str(error), Exit.MISTAKE) from None


def loadable(file: Path) -> bytes:
    """Read a program's file to be loaded: of a hex file the ELF file beside it, if that is the same program,
    with its symbols."""
    content = content_of(file)
    try:
        elf = _content(file.with_suffix(".elf"))
        program, built = read_program(file.name, content), read_program(file.name, elf)
    except (OSError, ProgramError):
        return content  # the daemon says what is wrong with it
    return elf if (program.flash, program.eeprom) == (built.flash, built.eeprom) else content


def symbols_of(chip: Mapping[str, Any], elf: Path | None) -> list[Symbol]:
    """Symbols of the program in a chip (answer of `processor`): those it was loaded with, or of an ELF file.
    Empty: nobody knows any. Ends the command if the file that is named is of another program."""
    if elf is None:
        known = [Symbol(*row) for row in chip["symbols"]]
        return known or _built_symbols(chip)
    program = program_of(elf)
    if not _runs(chip, program):
        runs = chip["program"] or "another program"
        raise fail(f"hil: {elf}: {chip['device']} runs another program: {runs}", Exit.FAILED)
    return list(program.symbols)


def _runs(chip: Mapping[str, Any], program: ChipProgram) -> bool:
    """True if the flash begins with a program: a tool leaves what a longer one before it had behind it."""
    return bytes.fromhex(chip["flash"]).startswith(program.flash)


def _built_symbols(chip: Mapping[str, Any]) -> list[Symbol]:
    """Symbols of the ELF file of this program that a build has left near the current folder."""
    for elf in (path for pattern in _BUILT for path in sorted(Path().glob(pattern))):
        try:
            program = read_program(elf.name, _content(elf))
        except (OSError, ProgramError):
            continue
        if _runs(chip, program):
            return list(program.symbols)
    return []


def need_symbols(chip: Mapping[str, Any], elf: Path | None) -> list[Symbol]:
    """The same, or say that there are none and end the command."""
    if symbols := symbols_of(chip, elf):
        return symbols
    name = chip["device"]
    if elf:
        raise fail(f"hil: {elf} has no symbols: it was stripped; build it again", Exit.FAILED)
    raise fail(
        f"hil: the names of functions in {name} are not known, and no .elf here or in build is of its"
        " program: name it with --elf",
        Exit.FAILED,
    )
