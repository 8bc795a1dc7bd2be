"""Build of a sketch: ``build/NAME.hex`` and ``build/NAME.elf``.

Flags are those of the Arduino IDE for a Uno (platform.txt and boards.txt of the AVR core 1.8), but without
-flto, unless it is asked for: functions that it dissolves are not seen in a debugger or a profile.
"""

import os
import re
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

from hil.toolchain.arduino_cli import build_by_arduino_cli
from hil.toolchain.avr_tools import COMPILER_PACKAGES, AvrTools, core_of, find_arduino_cli, find_avr_tools
from hil.toolchain.build_failed import BuildFailed, NoToolchain
from hil.toolchain.ino_source import cpp_text, lines_of, preprocessed_lines, prototypes_of
from hil.toolchain.kept_objects import cache_folder, kept, key_of
from hil.toolchain.run_program import run_program
from hil.toolchain.sketch_sources import COMPILED, SketchSources, find_sketch

_SRAM_AT = 0x800100
"""Address of the first byte of SRAM, as the linker has it."""
FLASH_BYTES, SRAM_BYTES = 32_256, 2_048
"""Room of a Uno for a sketch, and for its variables. Source: upload.maximum_size and upload.maximum_data_size
of boards.txt."""
_UNO = ("-mmcu=atmega328p", "-DF_CPU=16000000L", "-DARDUINO=10819", "-DARDUINO_AVR_UNO", "-DARDUINO_ARCH_AVR")
_ALL = ("-c", "-g", "-Os", "-ffunction-sections", "-fdata-sections")
_OF_KIND = {
    ".c": ("-std=gnu11",),
    ".cpp": (
        "-std=gnu++11",
        "-fpermissive",
        "-fno-exceptions",
        "-fno-threadsafe-statics",
        "-Wno-error=narrowing",
        # WString.cpp of 1.8.7 wants a name that <float.h> of gcc 5.4 does not give C++ programs.
        "-DDECIMAL_DIG=__DECIMAL_DIG__",
    ),
    ".S": ("-x", "assembler-with-cpp"),
}
_LTO = ("-flto", "-fno-fat-lto-objects")
_QUIET, _PLAIN = ("-w",), "-fno-diagnostics-show-caret"
_SIZE = re.compile(r"^(\.\S+)\s+(\d+)", re.MULTILINE)
_IN_FLASH, _IN_SRAM = (".text", ".data", ".bootloader"), (".data", ".bss", ".noinit")
_NO_HEADER = re.compile(r"fatal error: (\S+): No such file or directory")


class Built(NamedTuple):
    """Result of a build. ``said``: what the compiler has said of it, its warnings."""

    hex: Path
    elf: Path
    flash_bytes: int
    sram_bytes: int
    said: str = ""


class BuildOptions(NamedTuple):
    """Options of a build. ``output``: None for ``build`` in the sketch's folder; ``has_lto``: as the IDE;
    ``has_warnings``: of the sketch's own files."""

    output: Path | None = None
    libraries: Sequence[Path] = ()
    has_lto: bool = False
    has_warnings: bool = False


def build_sketch(
    place: Path, options: BuildOptions | None = None, env: Mapping[str, str] | None = None
) -> Built:
    """Build a sketch, or a plain program, of a folder. ``env``: this process's, if it is not given.

    Raises:
        BuildFailed: it does not compile, or there is none; NoToolchain: something has to be installed.
    """
    env, options = os.environ if env is None else env, options or BuildOptions()
    try:
        tools = find_avr_tools(env)
        sketch = find_sketch(place, options.libraries, tools.core)
        core = core_of(tools) if sketch.inos else None
    except NoToolchain:
        sketch = find_sketch(place, options.libraries)
        if not sketch.inos or not (program := find_arduino_cli(env)):
            raise
        output = options.output or sketch.folder / "build"
        return Built(*build_by_arduino_cli(program, sketch, output, options.libraries, env))
    try:
        return _Build(tools, core, sketch, options, env).run()
    except OSError as error:
        raise BuildFailed(f"{error.filename or sketch.folder}: {error.strerror}") from error


class _Build:
    def __init__(
        self,
        tools: AvrTools,
        core: Path | None,
        sketch: SketchSources,
        options: BuildOptions,
        env: Mapping[str, str],
    ) -> None:
        self._tools, self._core, self._sketch, self._env = tools, core, sketch, env
        self._lto = _LTO if options.has_lto else ()
        self._own_warnings = (_PLAIN, "-Wall") if options.has_warnings else (_PLAIN, *_QUIET)
        self._output = options.output or sketch.folder / "build"
        self._said: list[str] = []
        includes = [core / "cores" / "arduino", core / "variants" / "standard"] if core else []
        self._core_includes = [f"-I{each}" for each in includes]
        of_libraries = [f"-I{each}" for library in sketch.libraries for each in library.includes]
        self._includes = [*self._core_includes, *of_libraries]

    def run(self) -> Built:
        self._output.mkdir(parents=True, exist_ok=True)
        name = self._sketch.name
        with tempfile.TemporaryDirectory(prefix=".sketch-", dir=self._output) as folder:
            new = Path(folder)
            objects = self._own_objects(new)
            for library in self._sketch.libraries:
                includes = [*(f"-I{each}" for each in library.includes), *self._includes]
                objects += self._kept(library.folder.name, library.folder, library.sources, includes)
            if self._core:
                core = self._core / "cores" / "arduino"
                sources = [path for path in sorted(core.glob("**/*")) if path.suffix in COMPILED]
                objects += self._kept("core", core, sources, self._core_includes, is_archive=True)
            elf, hex_file = new / f"{name}.elf", new / f"{name}.hex"
            self._link(objects, elf)
            sizes = _sizes(elf, self._tools, self._env)
            _check_room(*sizes)
            self._run([self._tools.objcopy, "-O", "ihex", "-R", ".eeprom", str(elf), str(hex_file)])
            for made in (elf, hex_file):  # each in its place as a whole
                os.replace(made, self._output / made.name)
        said = "".join(self._said)
        return Built(self._output / hex_file.name, self._output / elf.name, *sizes, said)

    # ---- what is compiled ----

    def _own_objects(self, folder: Path) -> list[Path]:
        """Objects of the sketch's own files."""
        own = [f"-I{self._sketch.folder}", *self._includes]
        sources = list(self._sketch.sources)
        if self._sketch.inos:
            made = folder / f"{self._sketch.name}.ino.cpp"
            self._write_cpp(made, own)
            sources.append(made)
        return self._compiled(sources, folder, own, self._own_warnings)

    def _write_cpp(self, made: Path, includes: Sequence[str]) -> None:
        """Write the sketch's C++. Its conditions are evaluated first, to know its functions: where that
        fails, as without a header, the compiler says why."""
        lines = lines_of((str(path), path.read_text(errors="replace")) for path in self._sketch.inos)
        made.write_text(cpp_text(lines))
        flags = [each for each in self._flags(".cpp") if each != "-c"]
        done = self._try([self._tools.gxx, *flags, *_QUIET, *includes, "-E", str(made)])
        seen = preprocessed_lines(done.stdout, map(str, self._sketch.inos)) if done.returncode == 0 else lines
        made.write_text(cpp_text(lines, prototypes_of(seen)))

    def _kept(
        self,
        name: str,
        folder: Path,
        sources: Sequence[Path],
        includes: Sequence[str],
        *,
        is_archive: bool = False,
    ) -> list[Path]:
        """Objects of the core or of a library, compiled once: of all in its folder and in the core's."""

        def make(new: Path) -> None:
            objects = self._compiled(sources, new, includes, _QUIET)
            if is_archive:
                self._run([self._tools.ar, "rcs", str(new / f"{name}.a"), *map(str, objects)])
                for each in objects:
                    each.unlink()

        folders = [folder, *(self._core / each for each in ("cores", "variants/standard") if self._core)]
        files = [path for each in folders for path in sorted(each.glob("**/*")) if path.is_file()]
        words = [self._version(), *self._flags(".c"), *self._flags(".cpp"), *includes]
        return kept(cache_folder(self._env), name, key_of(files, words), make)

    def _version(self) -> str:
        return self._try([self._tools.gcc, "--version"]).stdout.partition("\n")[0]

    def _flags(self, kind: str) -> list[str]:
        return [*_ALL, *_OF_KIND[kind], *(self._lto if kind != ".S" else ()), *_UNO]

    def _compiled(
        self, sources: Sequence[Path], folder: Path, includes: Sequence[str], warnings: Sequence[str]
    ) -> list[Path]:
        objects = [folder / f"{number:03}-{source.name}.o" for number, source in enumerate(sources)]

        def compile_one(source: Path, made: Path) -> None:
            program = self._tools.gxx if source.suffix == ".cpp" else self._tools.gcc
            flags = [*self._flags(source.suffix), *warnings, *includes]
            self._run([program, *flags, str(source), "-o", str(made)])

        with ThreadPoolExecutor(max_workers=os.cpu_count() or 1) as pool:
            for done in [pool.submit(compile_one, *each) for each in zip(sources, objects, strict=True)]:
                done.result()
        return objects

    def _link(self, objects: Sequence[Path], elf: Path) -> None:
        flags = ["-Os", "-g", *(("-flto", "-fuse-linker-plugin") if self._lto else ()), "-Wl,--gc-sections"]
        self._run([self._tools.gcc, *_QUIET, *flags, _UNO[0], "-o", str(elf), *map(str, objects), "-lm"])

    # ---- programs ----

    def _try(self, words: Sequence[str]) -> "subprocess.CompletedProcess[str]":
        return run_program(words, self._env)

    def _run(self, words: Sequence[str]) -> None:
        """Run a program. Raises BuildFailed, in its own words."""
        done = self._try(words)
        if done.returncode == 0:
            self._said.append(done.stderr)
            return
        said = done.stderr.rstrip() or f"{Path(words[0]).name} ended with {done.returncode}"
        raise BuildFailed("\n".join([said, *self._hints(said)]))

    def _hints(self, said: str) -> list[str]:
        if overflow := _OVERFLOW.search(said):
            end, is_data = int(overflow[1], 16), overflow[2] == "data"
            what, room = ("variables", SRAM_BYTES) if is_data else ("program", FLASH_BYTES)
            return [f"{end - _SRAM_AT if is_data else end} bytes of {what}; a Uno has room for {room}"]
        if not (missing := _NO_HEADER.search(said)):
            return []
        if missing[1].startswith(("avr/", "util/")) or missing[1] in ("stdlib.h", "stdio.h", "string.h"):
            return [f"the C library for AVR is not installed: `apt install {COMPILER_PACKAGES}`"]
        where = ", ".join(map(str, self._sketch.looked_in)) or "no folder"
        return [f"{missing[1]}: no library has it in {where}; name further folders with --libraries"]


def _sizes(elf: Path, tools: AvrTools, env: Mapping[str, str]) -> tuple[int, int]:
    """Bytes of flash, and of SRAM for variables."""
    done = run_program([tools.size, "-A", str(elf)], env)
    sizes = {name: int(size) for name, size in _SIZE.findall(done.stdout)}
    flash, sram = (sum(sizes.get(name, 0) for name in names) for names in (_IN_FLASH, _IN_SRAM))
    return flash, sram


_OVERFLOW = re.compile(r"address (0x[0-9a-f]+) of .* section `\S+' is not within region `(text|data)'")


def _check_room(flash_bytes: int, sram_bytes: int) -> None:
    if flash_bytes > FLASH_BYTES:
        raise BuildFailed(f"{flash_bytes} bytes of program; a Uno has room for {FLASH_BYTES}")
    if sram_bytes > SRAM_BYTES:
        raise BuildFailed(f"{sram_bytes} bytes of variables; a Uno has room for {SRAM_BYTES}")
