"""Checks of builds with the compiler that is installed, and of what is said where none is."""

import os
import shutil
from collections.abc import Mapping
from pathlib import Path

import pytest

from hil.toolchain.avr_tools import find_avr_tools
from hil.toolchain.build_failed import BuildFailed, NoToolchain
from hil.toolchain.sketch_build import BuildOptions, build_sketch

try:
    WHY = "" if find_avr_tools(os.environ).core else "arduino-core-avr is not installed"
except NoToolchain as error:
    WHY = str(error)
needs_compiler = pytest.mark.skipif(bool(WHY), reason=WHY)


@pytest.fixture(scope="session")
def env(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, str]:
    return {**os.environ, "XDG_CACHE_HOME": str(tmp_path_factory.mktemp("cache"))}


def write(folder: Path, files: Mapping[str, str]) -> Path:
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(content)
    return folder


BLINK = {
    "blink/blink.ino": "#include <Lamp.h>\nvoid setup() { light(PIN); }\nvoid loop() { more(); helped(); }\n",
    "blink/more.ino": "const int unused = 1;\nvoid more(int times = 2) { delay(times); }\n",
    "blink/help.cpp": '#include "help.h"\nint done;\nvoid helped() { done++; }\n',
    "blink/help.h": '#include "done.h"\nvoid helped();\n',
    "blink/done.h": "extern int done;\n",
    "blink/src/deep/other.c": "int other(void) { return 1; }\n",
    "libraries/Lamp/src/Lamp.h": "#pragma once\n#include <Wires.h>\nconst int PIN = LED;\nvoid light(int);\n",
    "libraries/Lamp/src/in/Lamp.cpp": "#include <Arduino.h>\nvoid light(int p) { pinMode(p, 1); }\n",
    "libraries/Wires/Wires.h": "#define LED 13\n",
    "libraries/Wires/examples/x.cpp": "#error not compiled\n",
}


@needs_compiler
def test_a_sketch_with_all_kinds_of_files_is_built(tmp_path: Path, env: Mapping[str, str]) -> None:
    files = BLINK | {"blink/blink.ino": '#include "help.h"\n' + BLINK["blink/blink.ino"]}
    built = build_sketch(write(tmp_path, files) / "blink", env=env)
    assert built.hex == tmp_path / "blink" / "build" / "blink.hex"
    assert built.hex.read_text().startswith(":100000000C94")
    assert built.elf.read_bytes()[:4] == b"\x7fELF"
    assert 400 < built.flash_bytes < 1500
    assert 9 < built.sram_bytes < 40
    assert sorted(each.name for each in built.hex.parent.iterdir()) == ["blink.elf", "blink.hex"]


@needs_compiler
def test_the_core_is_compiled_once(tmp_path: Path, env: Mapping[str, str]) -> None:
    place = write(tmp_path, {"a/a.ino": "void setup() {}\nvoid loop() {}\n"}) / "a"
    first = build_sketch(place, env=env)
    cache = Path(env["XDG_CACHE_HOME"]) / "hil" / "sketch"
    before = {path: path.stat().st_mtime_ns for path in cache.glob("**/*")}
    content = first.hex.read_bytes()
    assert any(path.name == "core.a" for path in before)
    assert (
        build_sketch(place / "a.ino", BuildOptions(output=tmp_path / "out"), env).hex.read_bytes() == content
    )
    assert {path: path.stat().st_mtime_ns for path in cache.glob("**/*")} == before


@needs_compiler
@pytest.mark.parametrize(
    ("files", "said"),
    [
        ({"a/a.ino": "void setup() {}\n\nvoid loop() { x = 1; }\n"}, "{}/a/a.ino:3:15: error: 'x' was not"),
        (
            {"a/a.ino": "void setup() {}\nvoid loop() {}\n", "a/z.ino": "\nvoid f() {\n  1 = 2;\n}\n"},
            "{}/a/z.ino:3:",
        ),
        (
            {"a/a.ino": "#include <Servo.h>\nvoid setup() {}\nvoid loop() {}\n", "libraries/x/y.h": ""},
            "Servo.h: no library has it in {}/libraries, ",
        ),
        ({"a/a.ino": "void setup() {}\n"}, "undefined reference to `loop'"),
        (
            {"a/a.ino": "char x[2100];\nvoid setup() { x[A0] = 1; }\nvoid loop() { Serial.print(x); }\n"},
            "bytes of variables; a Uno has room for 2048",
        ),
    ],
)
def test_what_is_wrong_is_said_with_its_line(
    files: dict[str, str], said: str, tmp_path: Path, env: Mapping[str, str]
) -> None:
    with pytest.raises(BuildFailed) as error:
        build_sketch(write(tmp_path, files) / "a", env=env)
    assert said.format(tmp_path) in str(error.value)
    assert not list((tmp_path / "a" / "build").iterdir())


@needs_compiler
def test_functions_that_a_condition_leaves_out_have_no_prototype(
    tmp_path: Path, env: Mapping[str, str]
) -> None:
    text = (
        "void setup() { f(); }\n#ifdef NOT_HERE\nvoid g(Unknown x) {}\n#endif\nvoid f() {}\nvoid loop() {}\n"
    )
    build_sketch(write(tmp_path, {"a/a.ino": text + "ISR(INT0_vect) {}\n"}) / "a", env=env)


@needs_compiler
def test_a_plain_program_has_no_core(tmp_path: Path, env: Mapping[str, str]) -> None:
    text = "#include <avr/io.h>\nint main(void) { DDRB = 32; for (;;) PINB = 32; }\n"
    built = build_sketch(write(tmp_path, {"p/main.c": text}) / "p", env=env)
    assert built.hex.name == "p.hex"
    assert built.flash_bytes < 200


@needs_compiler
def test_warnings_of_the_sketch_are_said_where_they_are_asked_for(
    tmp_path: Path, env: Mapping[str, str]
) -> None:
    place = write(tmp_path, {"a/a.ino": "void setup() { int x; }\nvoid loop() {}\n"}) / "a"
    assert build_sketch(place, env=env).said == ""
    assert (
        "a.ino:1:20: warning: unused variable 'x'"
        in build_sketch(place, BuildOptions(has_warnings=True), env).said
    )


@needs_compiler
def test_the_linker_dissolves_functions_where_it_is_asked_to(tmp_path: Path, env: Mapping[str, str]) -> None:
    place = write(tmp_path, {"a/a.ino": "void setup() {}\nvoid loop() { digitalWrite(13, 1); }\n"}) / "a"
    built = build_sketch(place, env=env)
    assert build_sketch(place, BuildOptions(has_lto=True), env).flash_bytes < built.flash_bytes


@pytest.mark.parametrize(
    ("files", "said"),
    [
        ({}, "a: there is no such folder; write that of the sketch"),
        ({"a/README": ""}, "a has no a.ino, and no *.c, *.cpp, *.S; write the folder of a sketch"),
        ({"a/b.ino": "", "a/c.ino": ""}, "a has no a.ino: the main file has the folder's name"),
    ],
)
def test_a_folder_without_a_sketch_is_refused(files: dict[str, str], said: str, tmp_path: Path) -> None:
    with pytest.raises(BuildFailed) as error:
        build_sketch(write(tmp_path, files) / "a", env={"PATH": str(tools(tmp_path))})
    assert str(error.value) == f"{tmp_path}/{said}"


def tools(folder: Path, **programs: str) -> Path:
    """Folder of programs that are as good as nothing, beside those given."""
    place = folder / "bin"
    place.mkdir()
    for name in programs or ("avr-gcc", "avr-g++", "avr-gcc-ar", "avr-objcopy", "avr-size"):
        (place / name).write_text(f"#!/bin/sh\n{programs.get(name, '')}\n")
        (place / name).chmod(0o755)
    return place


def test_a_compiler_that_is_not_installed_is_named_with_its_package(tmp_path: Path) -> None:
    write(tmp_path, {"a/a.ino": "", "bin/x": ""})
    with pytest.raises(
        NoToolchain, match="avr-gcc is not installed: `apt install gcc-avr avr-libc arduino-core-avr`"
    ):
        build_sketch(tmp_path / "a", env={"PATH": str(tmp_path / "bin")})


def test_a_core_that_is_not_installed_is_named_with_its_package(tmp_path: Path) -> None:
    place = tools(tmp_path)
    found = find_avr_tools({"PATH": str(place)}, tmp_path / "no core")
    assert found.core is None
    assert found.gcc == str(place / "avr-gcc")


CLI = """
while [ "$1" != --output-dir ]; do shift; done
printf ':00000001FF\\n' > "$2/a.ino.hex"; printf ELF > "$2/a.ino.elf"
echo "Sketch uses 924 bytes (2%) of program storage space. Maximum is 32256 bytes."
echo "Global variables use 9 bytes (0%) of dynamic memory."
"""


@pytest.mark.skipif(not shutil.which("sh"), reason="no shell is installed")
def test_arduino_cli_builds_where_it_is_installed_alone(tmp_path: Path) -> None:
    write(tmp_path, {"a/a.ino": "void setup() {}\nvoid loop() {}\n"})
    place = tools(tmp_path, **{"arduino-cli": CLI})
    built = build_sketch(tmp_path / "a", env={"PATH": str(place)})
    assert (built.hex.read_text(), built.flash_bytes, built.sram_bytes) == (":00000001FF\n", 924, 9)


def test_what_arduino_cli_refuses_is_said_in_its_words(tmp_path: Path) -> None:
    write(tmp_path, {"a/a.ino": ""})
    place = tools(tmp_path, **{"arduino-cli": "echo no platform >&2; exit 1"})
    with pytest.raises(BuildFailed, match="no platform"):
        build_sketch(tmp_path / "a", env={"PATH": str(place)})
