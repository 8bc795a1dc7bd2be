"""Kind of bus, as its folder gives it: parts, each for those buses that have such a thing."""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from hil.vocab.framing import Framing
from hil.vocab.line_format import LineFormat
from hil.vocab.segment import Segment
from hil.vocab.wire import WireInfo

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
    info: WireInfo
    """Reports on them: tables, metrics, kinds of problems."""
    add: Callable[[Any, Any, Any], None]
    """Puts the wires, with what is on them, into a bench whose devices are there. Arguments: the
    ``BenchRuntime``, the ``BenchConfig``, the ``Catalogue``."""


@dataclass(frozen=True)
class NodeLine:
    """Segment that nodes are put on. ``group``: the ``Group`` of the bench whose time it has; ``baud``: its
    speed; ``boards``: the ``Profile`` of each board; ``version``: hil's, which nodes may tell."""

    segment: Segment
    group: Any
    baud: int
    boards: Mapping[str, Any]
    version: str


@dataclass(frozen=True)
class NodeKind:
    """Nodes of a protocol on segments: cards of axes, stations of their own. They stand in a segment of a
    configuration under ``key``, and are called after their axes, ``axis.key``."""

    key: str
    about: str
    """Description of the key in schema and reference."""
    model: Callable[[], type[Any]]
    """Answers the pydantic model of what stands under the key."""
    axes_key: str
    """Key of the model with a mapping of axes, each of which has a node."""
    findings: Callable[[Raw, Mapping[str, Any], Collection[str]], Iterable[Any]]
    """Finds what is wrong with the nodes of all segments, as ``WireKind.findings``. The first argument are
    the segments."""
    framing: Callable[[LineFormat], Framing]
    """Answers the framing of its packets on a line of this format, always the same object."""
    add: Callable[[Any, Any, NodeLine], None]
    """Puts the nodes of a segment on it, in the order of the configuration. Arguments: the ``BenchRuntime``,
    what stands under the key, the segment."""
    has_other_formats: bool = False
    """True if a line whose format is not 8N1, on which no board can be, has packets of this protocol."""
    fault_target: str | None = None
    """Kind of target of its own faults, a key of ``TARGETS``."""


@dataclass(frozen=True)
class BusKind:
    """Kind of bus: ``BUS`` of ``bus_kind.py`` in its folder.

    Most benches have no such bus, so the functions of the parts import what they need when they are called.
    """

    wires: WireKind | None = None
    """Its own wires; None: its stations are on wires of another bus."""
    nodes: NodeKind | None = None
    sections: tuple[tuple[str, str], ...] = ()
    """Sections of the reference: a heading or a sentence, and the model whose keys follow."""
