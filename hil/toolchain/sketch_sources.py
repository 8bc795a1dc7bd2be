"""Files of a sketch, and of the libraries that it includes.

Source: "Sketch specification" and "Library specification" of the arduino-cli documentation: which files are
compiled, and where a library has its own.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from hil.toolchain.build_failed import BuildFailed

COMPILED = (".c", ".cpp", ".S")
_HEADERS = (".h", ".hpp", ".hh", ".ino", *COMPILED)
_INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*[<"]([^>"\n]+)[>"]', re.MULTILINE)
_MOST_BYTES = 4 << 20
"""Size from which on a file is no source."""


class Library(NamedTuple):
    """Library of a sketch. ``include``: folder of its headers."""

    folder: Path
    include: Path
    sources: Sequence[Path]
    includes: Sequence[Path]


class SketchSources(NamedTuple):
    """Files of a sketch. ``inos``: the main one first; of a plain program there are none. ``looked_in``:
    folders of libraries that were looked into."""

    name: str
    folder: Path
    inos: Sequence[Path]
    sources: Sequence[Path]
    libraries: Sequence[Library]
    looked_in: Sequence[Path]


def find_sketch(place: Path, library_folders: Sequence[Path] = (), core: Path | None = None) -> SketchSources:
    """Find the files of a sketch, or of a plain program without an .ino. ``place``: its folder, or its main
    file. Libraries are looked for in ``library_folders``, then in ``libraries`` in the folder and beside it,
    then in the core's.

    Raises:
        BuildFailed: there is none.
    """
    folder = place.parent if place.suffix == ".ino" else place
    if not folder.is_dir():
        raise BuildFailed(f"{place}: there is no such folder; write that of the sketch")
    name = folder.resolve().name
    inos = _in_order(name, sorted(folder.glob("*.ino")), folder)
    sources = [*_sources(folder, deep=False), *_sources(folder / "src", deep=True)]
    if not inos and not sources:
        raise BuildFailed(
            f"{folder} has no {name}.ino, and no {', '.join(f'*{end}' for end in COMPILED)};"
            " write the folder of a sketch"
        )
    for each in library_folders:
        if not each.is_dir():
            raise BuildFailed(f"{each}: there is no such folder of libraries")
    places = [*library_folders, folder / "libraries", folder.resolve().parent / "libraries"]
    places += [core / "libraries"] if core and inos else []
    places = [each for each in dict.fromkeys(places) if each.is_dir()]
    own = [*inos, *sources, *_headers(folder)]
    return SketchSources(name, folder, inos, sources, list(_libraries(own, places)), places)


def _in_order(name: str, inos: list[Path], folder: Path) -> list[Path]:
    """Main file first: the one with the folder's name, or the only one."""
    main = folder / f"{name}.ino"
    if main in inos:
        return [main, *(each for each in inos if each != main)]
    if len(inos) > 1:
        raise BuildFailed(f"{folder} has no {name}.ino: the main file has the folder's name")
    return inos


def _sources(folder: Path, *, deep: bool) -> list[Path]:
    return [path for path in sorted(folder.glob("**/*" if deep else "*")) if path.suffix in COMPILED]


def _headers(folder: Path) -> list[Path]:
    return [*folder.glob("*.h*"), *(folder / "src").glob("**/*.h*")]


def _libraries(files: Iterable[Path], places: Sequence[Path]) -> Iterator[Library]:
    """Libraries that files include, and that those include."""
    found = dict[Path, Library]()
    left = [header for file in files for header in _included(file)]
    seen = set[str]()
    while left:
        header = left.pop(0)
        if header in seen:
            continue
        seen.add(header)
        if (library := _library_with(header, places)) and library.folder not in found:
            found[library.folder] = library
            yield library
            left += (each for file in library.folder.glob("**/*") for each in _included(file))


def _included(file: Path) -> list[str]:
    if file.suffix not in _HEADERS or not file.is_file() or file.stat().st_size > _MOST_BYTES:
        return []
    return _INCLUDE.findall(file.read_text(errors="replace"))


def _library_with(header: str, places: Sequence[Path]) -> Library | None:
    for place in places:
        for folder in sorted(each for each in place.iterdir() if each.is_dir()):
            has_src = (folder / "src").is_dir()
            include = folder / "src" if has_src else folder
            if (include / header).is_file():
                utility = folder / "utility"
                if has_src:
                    return Library(folder, include, _sources(include, deep=True), [include])
                sources = [*_sources(folder, deep=False), *_sources(utility, deep=False)]
                return Library(folder, include, sources, [folder, *([utility] if utility.is_dir() else [])])
    return None
