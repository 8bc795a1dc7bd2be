"""Text of a sketch as C++: its files one behind the other, with Arduino.h before them and a prototype of each
function, so that it may be called above its definition. Pure.

Source: "Sketch build process" of the arduino-cli documentation: which file comes first, where prototypes
stand, and which functions get none.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple


class InoLine(NamedTuple):
    """One line of a sketch's file, without its end."""

    file: str
    number: int
    text: str


class Prototype(NamedTuple):
    """Declaration of a function. ``line``: where its definition begins."""

    line: InoLine
    text: str


def lines_of(files: Iterable[tuple[str, str]]) -> list[InoLine]:
    """Lines of files, which are given as name and text, the main one first."""
    return [
        InoLine(name, number, text)
        for name, content in files
        for number, text in enumerate(content.splitlines(), 1)
    ]


def cpp_text(lines: Sequence[InoLine], prototypes: Sequence[Prototype] = ()) -> str:
    """C++ of a sketch. The compiler names the sketch's own lines in all that it says of it."""
    parts = ["#include <Arduino.h>"]
    first = prototypes[0].line[:2] if prototypes else None
    before: InoLine | None = None
    for line in lines:
        if line[:2] == first:
            for each in prototypes:
                parts += [_place(each.line), each.text]
            before = None
        if before is None or before.file != line.file:
            parts.append(_place(line))
        parts.append(line.text)
        before = line
    return "\n".join(parts) + "\n"


def _place(line: InoLine) -> str:
    return f"#line {line.number} {_quoted(line.file)}"


def _quoted(name: str) -> str:
    escaped = name.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


_MARKER = re.compile(r'#(?: |line )\s*(\d+) "((?:[^"\\]|\\.)*)"')


def preprocessed_lines(text: str, files: Iterable[str]) -> list[InoLine]:
    """Lines of a sketch's own files in what the preprocessor has made of its C++ (``avr-g++ -E``): without
    those that no condition let through."""
    own, found = set(files), list[InoLine]()
    file, number = "", 0
    for line in text.split("\n"):
        if marker := _MARKER.match(line):
            file, number = re.sub(r"\\(.)", r"\1", marker[2]), int(marker[1])
        else:
            if file in own:
                found.append(InoLine(file, number, line))
            number += 1
    return found


# ---- functions ----

_HIDDEN = re.compile(
    r"""
    (?P<comment>//[^\n]* | /\*.*?(?:\*/|\Z)
    | ^[ \t]*\#(?:[^\n\\]|\\.|\\\n)*)          # a directive that was not preprocessed
    | R"(?P<mark>[^\s()\\]{0,16})\(.*?\)(?P=mark)"
    | "(?:\\.|[^"\\\n])*"
    | (?<![0-9A-Fa-f])'(?:\\.|[^'\\\n])+'
    """,
    re.VERBOSE | re.DOTALL | re.MULTILINE,
)
_HEADER = re.compile(
    r"""
    (?P<c>extern\s+"C"\s*)?
    (?P<before>(?:template\s*<[^{}()]*>\s*)?
       (?:[A-Za-z_][\w:]*(?![\w:])|__attribute__\s*\(\(.*?\)\)|<[^(){};]*>|[*&]|\s)+?[\s*&>])
    (?P<name>[A-Za-z_]\w*)\s*
    \((?P<parameters>.*?)\)\s*
    (?:noexcept|__attribute__\s*\(\(.*\)\)|\s)*
    """,
    re.VERBOSE | re.DOTALL,
)
_NO_TYPES = {
    "else",
    "return",
    "new",
    "delete",
    "throw",
    "case",
    "goto",
    "typedef",
    "using",
    "namespace",
    "operator",
}
_NO_NAMES = {"if", "while", "for", "switch", "catch", "operator", "sizeof", "defined", "asm"}
_BRACES = {"{": 1, "}": -1}
_STEPS = {"(": 1, "[": 1, ")": -1, "]": -1}


def prototypes_of(lines: Sequence[InoLine]) -> list[Prototype]:
    """Prototypes of the functions that a sketch defines, in their order. None for members of classes and
    namespaces, for those without a type before the name, as interrupts written with ISR, for those of C
    (extern "C"), and for those that the sketch declares itself.

    As where the Arduino IDE builds it, all stand above the first function: a type that is defined below that
    cannot be a parameter's. Default arguments stand in both, which -fpermissive lets pass.
    """
    defined, declared = list[Prototype](), set[str]()
    for line, header, is_definition in _headers(lines):
        if not (found := _HEADER.fullmatch(header)) or found["name"] in _NO_NAMES:
            continue
        words = set(re.findall(r"[A-Za-z_]\w*", found["before"]))
        if words & _NO_TYPES or "::" in found["before"].split()[-1] + found["name"]:
            continue
        text = " ".join(f"{found['before']}{found['name']}({found['parameters']});".split())
        if is_definition and not found["c"]:
            defined.append(Prototype(line, text))
        elif not is_definition:
            declared.add(_signature(text))
    return [each for each in defined if _signature(each.text) not in declared]


def _signature(prototype: str) -> str:
    """Name and number of parameters: enough to know a declaration by."""
    found = re.search(r"(\w+)\s*\((.*)\)", prototype, re.DOTALL)
    name, parameters = (found[1], found[2].strip()) if found else (prototype, "")
    return f"{name}/{0 if parameters in ('', 'void') else len(list(_parts(parameters)))}"


def _parts(parameters: str) -> Iterator[str]:
    """Parameters one by one: commas in brackets part none."""
    depth, part = 0, ""
    for character in parameters:
        depth += {"<": 1, ">": -1, **_BRACES, **_STEPS}.get(character, 0)
        if character == "," and depth == 0:
            yield part
            part = ""
        else:
            part += character
    yield part


def _headers(lines: Sequence[InoLine]) -> Iterator[tuple[InoLine, str, bool]]:
    """Texts outside all braces, each up to a brace or a semicolon: the line on which it begins, the text, and
    whether a body follows."""
    text = _HIDDEN.sub(_without_comment, "\n".join(line.text for line in lines))
    structure = _HIDDEN.sub(lambda hidden: _blank(hidden[0]), text)
    number, depth, round_depth = 0, 0, 0
    begun, header = 0, list[str]()
    for shown, character in zip(text, structure, strict=True):
        number += character == "\n"
        if round_depth == 0 and character in "{};":
            if depth == 0 and character != "}":
                yield lines[begun], "".join(header), character == "{"
            depth = max(0, depth + _BRACES.get(character, 0))
            header = []
        elif depth == 0:
            round_depth = max(0, round_depth + _STEPS.get(character, 0))
            if not header and not shown.isspace():
                begun = number
            if header or not shown.isspace():
                header.append(shown)


def _blank(text: str) -> str:
    return re.sub(r"[^\n]", " ", text)


def _without_comment(hidden: re.Match[str]) -> str:
    return _blank(hidden[0]) if hidden["comment"] is not None else hidden[0]
