"""Packages that others installed beside hil, by their entry points: boards, ports, bridges and buses."""

import os
import sys
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from importlib.machinery import PathFinder
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

BOARDS, PORTS, BRIDGES, BUSES = "hil.profiles", "hil.ports", "hil.bridges", "hil.buses"
"""Groups of entry points; the value of one is a package, as in ``pinger = "lab_boards.pinger"``."""


class NotThere(Exception):
    """Error of an entry point whose package cannot be found: ``str(error)`` says why."""


def installed(group: str) -> "Mapping[str, tuple[EntryPoint, ...]]":
    """Find entry points of a group by name, without importing anything; several of one name are a mistake."""
    found: dict[str, tuple[EntryPoint, ...]] = {}
    for point in sorted(every_point()[group], key=lambda each: (each.name, each.value)):
        if point not in (same := found.get(point.name, ())):
            found[point.name] = (*same, point)
    return found


@cache
def every_point() -> "Mapping[str, tuple[EntryPoint, ...]]":
    """Entry points of hil's groups, by group; the files of all packages are read once."""
    groups = (BOARDS, PORTS, BRIDGES, BUSES)
    if not any(map(_may_have_some, sys.path)) and not any(map(_is_other_finder, sys.meta_path)):
        return dict.fromkeys(groups, ())  # most often: the import below takes a tenth of `hil check`
    from importlib.metadata import entry_points

    found = entry_points()
    return {group: tuple(found.select(group=group)) for group in groups}


def _may_have_some(place: str) -> bool:
    """False if no package in a folder of ``sys.path`` says that it has entry points of hil's groups."""
    try:
        names = os.listdir(place or ".")
    except OSError as error:
        return isinstance(error, NotADirectoryError)  # an archive may have some
    infos = (name for name in names if name.lower().endswith(("dist-info", "egg-info")))
    return any(_says_some(os.path.join(place, name, "entry_points.txt")) for name in infos)


def _says_some(file: str) -> bool:
    try:
        with open(file, "rb", buffering=0) as opened:
            return b"[hil." in opened.read()
    except OSError:
        return False


def _is_other_finder(finder: object) -> bool:
    return finder is not PathFinder and hasattr(finder, "find_distributions")


def folder_of(point: "EntryPoint") -> Path:
    """Find the folder of a package.

    Raises:
        NotThere: it is missing, is no package, or one above it cannot be imported.
    """
    try:
        spec = find_spec(point.value)
    except Exception as error:  # a package above it may raise anything
        raise NotThere(f"{point.value} cannot be found: {error!r}") from None
    if spec is None or not spec.submodule_search_locations:
        raise NotThere(f"there is no package {point.value}")
    return Path(next(iter(spec.submodule_search_locations)))


def modules_of(package: str, group: str, module: str) -> tuple[str, ...]:
    """Find modules of a name, as in ``testing.fixtures``: of the folders of a package, and of packages that
    entry points of a group name. Imports at most what is above those packages."""
    spec = find_spec(package)
    roots = (spec.submodule_search_locations or []) if spec else []
    places = {f"{package}.{each.name}": each for root in roots for each in sorted(Path(root).iterdir())}
    for point in (each for points in installed(group).values() for each in points):
        with suppress(NotThere):  # who asks for the bus is told
            places[point.value] = folder_of(point)
    file = f"{module.replace('.', '/')}.py"
    return tuple(f"{name}.{module}" for name, folder in places.items() if (folder / file).is_file())


def told(point: "EntryPoint") -> str:
    """Name an entry point for people, with the distribution that it is of."""
    return f"{point.value} of the package {point.dist.name if point.dist else '?'}"
