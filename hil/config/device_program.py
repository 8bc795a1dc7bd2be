"""Programs for a board's processor that a configuration names: ``firmware`` and ``bootloader``."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import PlainSerializer, PlainValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from hil.config.catalogue import ProfileInfo
from hil.config.document import Document, Finding, KeyPath
from hil.config.explain import shown
from hil.config.port_model import is_path
from hil.sketch.chip import BOOT_START, FLASH, boot_section
from hil.vocab.problem import Problem

if TYPE_CHECKING:
    from hil.sketch.chip_program import ChipProgram

AUTO_RESET = "auto_reset"
FIRMWARE, BOOTLOADER = PROGRAM_KEYS = ("firmware", "bootloader")


@dataclass(frozen=True)
class ProgramFile:
    """Program of a file. ``key``: the configuration's; ``given``: its path as that has it; ``boot_start``:
    first byte of the boot section; ``digest``: SHA-256 of the flash; ``packed``: as a board's memory keeps
    the program."""

    key: str
    given: str
    path: Path
    boot_start: int
    digest: str
    packed: bytes

    def __str__(self) -> str:
        return self.given

    def digest_of(self, content: bytes) -> str:
        """Digest of another content of the file. Raises ProgramError: it cannot be used."""
        return read_for(self.key, self.path, content, self.boot_start).digest


def read_for(key: str, path: Path, content: bytes, boot_start: int) -> "ChipProgram":
    """Read a program for a key of a configuration. Raises ProgramError: it cannot be used."""
    from hil.sketch.chip_program import as_bootloader, before_boot, read_program

    program = read_program(str(path), content)
    fitted = as_bootloader(program) if key == BOOTLOADER else before_boot(program, boot_start)
    return replace(fitted, name=path.name)


def _read(value: Any) -> ProgramFile | None:
    if value is not None and not isinstance(value, ProgramFile):
        raise PydanticCustomError("path", "this is not a path", {"remedy": "write the path, or null"})
    return value


ProgramKey = Annotated[
    ProgramFile | None,
    PlainValidator(_read),
    PlainSerializer(lambda file: file and str(file)),
    WithJsonSchema({"anyOf": [{"type": "string"}, {"type": "null"}]}),
]
"""Key of a program: text in a configuration, ``ProgramFile`` when it was checked."""


_SOURCES = (".ino", ".pde", ".c", ".cpp", ".py")


class ProgramCheck:
    """Check of the programs of one device. ``findings``: mistakes in the configuration; ``problems``: in the
    files."""

    def __init__(
        self,
        path: KeyPath,
        raw: Mapping[str, Any],
        document: Document,
        profile: ProfileInfo,
        read_bytes: Callable[[Path], bytes] | None,
    ) -> None:
        self._path, self._raw, self._profile, self._read_bytes = path, raw, profile, read_bytes
        self._folder = Path(document.file).parent
        self.findings: list[Finding] = []
        self.problems: list[Problem] = []

    def read(self) -> dict[str, ProgramFile | None]:
        """Read the files of the keys that are given; None: it cannot be used."""
        given = {key: self._raw[key] for key in PROGRAM_KEYS if self._raw.get(key) is not None}
        files: dict[str, ProgramFile | None] = dict.fromkeys(given)
        if self._profile.processor is None:
            wrong = dict.fromkeys(given, "runs a user's program")
            if self._raw.get(AUTO_RESET) is False:
                wrong[AUTO_RESET] = "its port resets"
            for key, what in wrong.items():
                message = f"a {self._profile.name} has no processor that {what}"
                self._add(key, message, "leave this key out", at_key=True)
            return files
        has_bootloader = self._profile.processor.bootloader_baud is not None
        boot_start = BOOT_START if has_bootloader else FLASH.size
        if boot := self._file(BOOTLOADER, given, boot_start):
            files[BOOTLOADER] = boot
            boot_start = boot.boot_start
        if program := self._file(FIRMWARE, given, boot_start):
            files[FIRMWARE] = program
        return files

    def _file(self, key: str, given: Mapping[str, Any], boot_start: int) -> ProgramFile | None:
        """File of a key; None: there is none, or it cannot be used."""
        if (text := given.get(key)) is None:
            return None
        if not is_path(text):
            remedy = "write the path, as in build/blink.ino.hex"
            self._add(key, f"a file's path is wanted here, not {shown(text)}", remedy)
            return None
        if text.lower().endswith(_SOURCES):
            remedy = "compile it (`hil sketch build`), and write the .hex file that comes out"
            self._add(key, f"{text} is a source, and a compiled program is meant", remedy)
            return None
        from hil.sketch.chip_program import packed
        from hil.sketch.program_error import ProgramError

        assert self._read_bytes is not None, "this catalogue reads no files"
        path = self._folder / text
        try:
            program = self._with_symbols(path, read_for(key, path, self._read_bytes(path), boot_start))
        except ProgramError as error:
            self.problems.append(error.problem)
            self._add(key, f"{text} cannot be used", "mend what is said of it below")
            return None
        except OSError as error:
            remedy = "build it, or write where it is, from this file on"
            self._add(key, f"{path} cannot be read: {error.strerror}", remedy)
            return None
        if key == BOOTLOADER:
            boot_start = boot_section(program.start).start
        return ProgramFile(key, text, path.absolute(), boot_start, program.digest, packed(program))

    def _with_symbols(self, path: Path, program: "ChipProgram") -> "ChipProgram":
        """Add the symbols of the ELF file that lies beside a hex file, if that is of the same build."""
        from hil.sketch.chip_program import with_symbols

        assert self._read_bytes is not None
        if program.symbols:
            return program
        try:
            return with_symbols(program, self._read_bytes(path.with_suffix(".elf")))
        except OSError:
            return program

    def _add(self, key: str, message: str, remedy: str, *, at_key: bool = False) -> None:
        self.findings.append(Finding((*self._path, key), message, remedy, at_key))
