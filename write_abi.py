"""Writes what Cython and Python know of the native core's face: ``make abi``.

Numbers come from the one table, ``hil/core/native/abi.def``; structs and functions from the C headers.
``hil/core/tests/test_abi_files.py`` holds the written files fresh.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from textwrap import wrap
from typing import NamedTuple

CORE = Path(__file__).parent / "hil/core"
NATIVE = CORE / "native"
STRUCT_FILES = ("types.h", "motion/engine.h", "hil_core.h")
OPAQUE = ("hil_core", "hil_snapshot", "hil_watchdog", "hil_replay", "hil_joint_replay")
"""Structs of which Cython knows the name alone."""
NUMBERS = ("hil_field", "hil_law", "hil_lanes")
"""Enumerations that functions take."""
PARAMETERS, SET_APART = "hil_axis_params", ("law", "is_full", "full", "load", "seed")
"""Struct that an axis is opened with, and its members that are no numbers of its motor, driver or law."""
DICTS = {
    "hil_rt_stats": ("RtStats", "Statistics of the real-time thread."),
    "hil_replay_row": ("ReplayRow", "One control step of the Mechaduino's law."),
    "hil_joint_row": ("JointRow", "State of a joint of Walter's Cortex."),
}
"""Structs that go to Python as dictionaries."""
SOURCE = "Written by `make abi` from native/abi.def and the C headers: change those."

_ROW = re.compile(r'^([A-Z_]+)\((\w+), (\d+), (?:(\w+), )?"(.*)"\)$', re.M)
_ENUM = re.compile(r"^#ifndef ([A-Z_0-9]+) /\* (\w+): (.*) \*/$", re.M)
_COMMENT = re.compile(r"/\*.*?\*/", re.S)
_STRUCT = re.compile(r"typedef struct (\w+) \{(.*?)\} \1;", re.S)
_FUNCTION = re.compile(r"^([a-z]\w*[ *]+)(hil_\w+)(\([^;{}]*\));", re.M)


class Row(NamedTuple):
    """Row of abi.def. ``python``: its name there, "" for a constant."""

    macro: str
    name: str
    value: int
    python: str
    meaning: str


class Member(NamedTuple):
    """Member of a struct. ``size``: of an array, by a constant's name, or ""."""

    type: str
    name: str
    size: str


def rows() -> list[Row]:
    """Rows of abi.def, in its order."""
    found = _ROW.findall((NATIVE / "abi.def").read_text())
    return [Row(macro, name, int(value), python, meaning) for macro, name, value, python, meaning in found]


def enums() -> dict[str, tuple[str, str]]:
    """Python's classes and their docstrings, by the macros of abi.def."""
    found = _ENUM.findall((NATIVE / "abi.def").read_text())
    return {macro: (name, meaning) for macro, name, meaning in found}


def structs() -> dict[str, list[Member]]:
    """Structs of the C headers by name."""
    found = {}
    for file in STRUCT_FILES:
        for name, body in _STRUCT.findall(_COMMENT.sub("", (NATIVE / file).read_text())):
            found[name] = [] if "#" in body else list(_members(body))
    return found


def _members(body: str) -> Iterator[Member]:
    for statement in filter(None, map(str.strip, body.split(";"))):
        first, *others = statement.split(",")
        kind, name = first.rsplit(maxsplit=1)
        for each in (name, *others):
            text = each.strip()
            pointer = "*" if text.startswith("*") else ""
            plain, _, size = text.lstrip("*").partition("[")
            yield Member(f"{kind} {pointer}".strip(), plain, size.rstrip("]"))


def functions() -> list[tuple[str, str, str]]:
    """Result, name and arguments of the public functions."""
    text = _COMMENT.sub("", (NATIVE / "hil_core.h").read_text())
    return [
        (result.strip(), name, " ".join(given.split())) for result, name, given in _FUNCTION.findall(text)
    ]


def _filling() -> Iterator[str]:
    """Function that fills the parameters of an axis from a dictionary; what a law does not have is 0."""
    yield f"cdef inline int fill_{PARAMETERS}({PARAMETERS} *p, dict given) except -1:"
    for kind, name, _ in structs()[PARAMETERS]:
        if name not in SET_APART:
            value = f'given.get("{name}", 0)'
            yield f"    p.{name} = {value if kind == 'double' else f'int({value})'}"
    yield "    return 0"


def pxd() -> str:
    """Text of hil_core.pxd."""
    known = {row.name: row.value for row in rows() if row.macro == "NUMBER"}
    of, calls = structs(), functions()
    words = set(re.findall(r"\w+", " ".join(given for _, _, given in calls))) | {"hil_field_info"}
    words |= {word for name in words & of.keys() for member in of[name] for word in member.type.split()}
    lines = [
        "# cython: language_level=3",
        f"# {SOURCE}",
        "from libc.stdint cimport int8_t, int16_t, int32_t, int64_t, uint8_t, uint16_t, uint32_t, uint64_t",
        "",
        'cdef extern from "native/hil_core.h" nogil:',
        "    enum:",
        *(f"        {name}" for name in (*known, "HIL_FIELDS")),
        *(f"    ctypedef int {name}" for name in NUMBERS),
        *(f"    ctypedef struct {name}:\n        pass" for name in OPAQUE),
    ]
    for name, members in of.items():
        if name not in words or name in OPAQUE:
            continue
        lines.append(f"    ctypedef struct {name}:")
        for kind, member, size in members:
            length = f"[{known.get(size, size)}]" if size else ""
            lines.append(f"        {kind} {member}{length}".replace("* ", "*"))
    lines.append("    const hil_field_info hil_field_table[]")
    for result, name, given in calls:
        given = re.sub(r"(\(\*\w+\)\([^)]*\))", r"\1 noexcept nogil", given)
        lines.append(f"    {result} {name}{given}".replace("* ", "*"))
    return "\n".join([*lines, "", *_filling()]) + "\n"


def abi() -> str:
    """Text of abi.py."""
    text = [
        '"""Numbers of the native core\'s face, and what it tells as dictionaries.',
        "",
        SOURCE,
        '"""',
        "",
        "from enum import IntEnum",
        "from typing import TypedDict",
        "",
    ]
    for row in rows():
        if row.macro == "NUMBER":
            words = row.meaning[0].upper() + row.meaning[1:]
            text += [f"{row.name.removeprefix('HIL_')} = {row.value}", *_docstring(words + ".", "")]
    for macro, (name, meaning) in enums().items():
        text += ["", "", f"class {name}(IntEnum):", f'    """{meaning}"""', ""]
        for row in rows():
            if row.macro == macro:
                text += [f"    {row.python} = {row.value}", *_docstring(row.meaning, "    ")]
    for struct, (name, meaning) in DICTS.items():
        text += ["", "", f"class {name}(TypedDict):", f'    """{meaning}"""', ""]
        for member in structs()[struct]:
            kind = "float" if member.type in ("float", "double") else "int"
            text.append(f"    {member.name}: " + (f"list[{kind}]" if member.size else kind))
    return "\n".join(text) + "\n"


def _docstring(words: str, indent: str) -> list[str]:
    return wrap(f'"""{words}"""', 110, initial_indent=indent, subsequent_indent=indent)


FILES = {CORE / "hil_core.pxd": pxd, CORE / "abi.py": abi}
"""Files that are written, each with the function that makes its text."""

if __name__ == "__main__":
    for file, text in FILES.items():
        file.write_text(text())
