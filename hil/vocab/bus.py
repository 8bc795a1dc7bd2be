"""Kind of bus, as its folder gives it: parts, each for those buses that have such a thing."""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

Raw = Mapping[str, Any]
"""Part of a configuration as it is written: a mapping whose values may be wrong."""


@dataclass(frozen=True)
class WireKind:
    """Wires of a bus. They stand in a configuration under ``key``, each under a name of its own."""

    key: str
    about: str
    """Description of the key in schema and reference."""
    model: Callable[[], type[Any]]
    """Answers the pydantic model of a wire. It has ``taps``, a mapping of names to models with ``port``, and
    ``members()``, the names of the devices that are on it."""
    findings: Callable[[Raw, Mapping[str, Any], Collection[str]], Iterable[Any]]
    """Finds what is wrong with the wires of a whole configuration, each a ``hil.config.document.Finding``.
    Arguments: the configuration, the ``ProfileInfo`` of each device, the names of the real boards."""
    fault_places: Callable[[str, Raw, Mapping[str, Any]], Mapping[str, Collection[str]]]
    """Finds where faults may be: targets of a wire, itself and its stations, with their kinds (keys of
    ``TARGETS``). Arguments: the wire's name, the wire, the ``ProfileInfo`` of each device."""
    add: Callable[[Any, Any, Any], None]
    """Puts the wires, with what is on them, into a bench whose devices are there. Arguments: the
    ``BenchRuntime``, the ``BenchConfig``, the ``Catalogue``."""


@dataclass(frozen=True)
class BusKind:
    """Kind of bus: ``BUS`` of ``bus_kind.py`` in its folder.

    Most benches have no such bus, so the functions of the parts import what they need when they are called.
    """

    wires: WireKind | None = None
    """Its own wires; None: its stations are on wires of another bus."""
    sections: tuple[tuple[str, str], ...] = ()
    """Sections of the reference: a heading or a sentence, and the model whose keys follow."""
