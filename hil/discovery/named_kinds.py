"""Kinds of ports, bridges and buses: in the folders of hil, and in packages that are installed beside it."""

import sys
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from traceback import extract_tb
from types import ModuleType
from typing import TYPE_CHECKING, Any

from hil.discovery.installed import BUSES, installed, told
from hil.vocab.problem import Problem, Unusable

if TYPE_CHECKING:
    from hil.vocab.bus import BusKind, LogKind
    from hil.vocab.wire import WireInfo


@cache
def find_buses() -> "tuple[tuple[BusKind, ...], tuple[Problem, ...]]":
    """Find the kinds of buses: with hil among the ports and the bridges, and installed beside it; and the
    problems of those that cannot be imported."""
    found: list[BusKind] = []
    problems: list[Problem] = []
    for kinds in (Kinds("virtual_ports", None, "bus_kind"), Kinds("bridges", BUSES, "bus_kind")):
        for name in kinds:
            try:
                found.append(kinds.attribute(name, "BUS"))
            except Unusable as error:
                problems.append(Problem(f"the bus {name}", 0, 0, str(error), error.remedy))
    return tuple(found), tuple(problems)


@cache
def find_wire_infos() -> "Mapping[str, WireInfo]":
    """Find the reports on wires, by the key of a configuration under which they stand: segments first."""
    buses, _ = find_buses()
    segments = {bus.segments.info.key: bus.segments.info for bus in buses if bus.segments}
    return segments | {bus.wires.key: bus.wires.info for bus in buses if bus.wires}


@cache
def find_logs() -> "tuple[LogKind, ...]":
    """Find the kinds of frames that captures and logs have."""
    return tuple(bus.logs() for bus in find_buses()[0] if bus.logs)


class Kinds(Mapping[str, type[Any]]):
    """Options models by kind; a kind's module is imported only when it is asked for.

    ``package`` has a folder for each kind of hil's own; ``group`` is that of entry points for others,
    or None; each has ``module``. ``extra`` are the caller's own.

    Raises:
        KeyError: there is no such kind.
        Unusable: it cannot be imported, or there are two of the name.
    """

    def __init__(
        self, package: str, group: str | None, module: str, extra: Mapping[str, type[Any]] | None = None
    ) -> None:
        self._module, self._extra = module, extra or {}
        self._packages = {
            name: [(f"{package}.{name}", "that of hil")] for name in folders(package, f"{module}.py")
        }
        for name, points in (installed(group) if group else {}).items():
            self._packages.setdefault(name, []).extend((point.value, told(point)) for point in points)
        self._names = [*self._extra, *(name for name in self._packages if name not in self._extra)]

    def __getitem__(self, kind: str) -> type[Any]:
        if kind in self._extra:
            return self._extra[kind]
        options: type[Any] = self.attribute(kind, "Options")
        return options

    def __contains__(self, kind: object) -> bool:
        return kind in self._names

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def attribute(self, kind: str, name: str) -> Any:
        """Get what a kind's module defines. Raises as this class does."""
        (package, _), *others = self._packages[kind]
        if others:
            places = ", and ".join(origin for _, origin in self._packages[kind])
            raise Unusable(f"there are two of this name: {places}", "uninstall one of them")
        module = _imported(f"{package}.{self._module}")
        if not hasattr(module, name):
            raise Unusable(f"{module.__file__}:1: there is no {name} here", "each kind has to define it")
        return getattr(module, name)


@cache
def folders(package: str, marker: str) -> tuple[str, ...]:
    """Names of a package's folders that have the marker file, in their order."""
    spec = find_spec(package)
    roots = (spec.submodule_search_locations or []) if spec else []
    return tuple(path.parent.name for root in roots for path in sorted(Path(root).glob(f"*/{marker}")))


def _imported(name: str) -> ModuleType:
    try:
        return import_module(name)
    except (Exception, SystemExit) as error:  # the code of others may raise anything
        sys.modules.pop(name, None)
        frames = [each for each in extract_tb(error.__traceback__)[1:] if "importlib" not in each.filename]
        where = f"{frames[-1].filename}:{frames[-1].lineno}: " if frames else ""
        raise Unusable(f"{where}{type(error).__name__}: {error}", f"mend the package {name}") from None
