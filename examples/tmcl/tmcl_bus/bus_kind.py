"""TMCL as a kind of bus: all that hil asks of it."""

from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from hil.vocab.bus import BusKind, NodeKind, NodeLine, Raw
from hil.vocab.framing import Framing
from hil.vocab.line_format import LineFormat

if TYPE_CHECKING:
    from hil.config.catalogue import ProfileInfo
    from hil.config.document import Finding
    from hil.sim.bench import BenchRuntime
    from tmcl_bus.tmcl_model import TmclConfig


def _model() -> type[Any]:
    from tmcl_bus.tmcl_model import TmclConfig

    return TmclConfig


def _findings(
    segments: Raw, devices: "Mapping[str, ProfileInfo]", real: Collection[str]
) -> "Iterable[Finding]":
    from tmcl_bus.tmcl_findings import tmcl_findings

    return tmcl_findings(segments, devices, real)


def _framing(line_format: LineFormat) -> Framing:
    from tmcl_bus.framing import TMCL_FRAMING

    return TMCL_FRAMING


def _add(bench: "BenchRuntime", config: "TmclConfig", line: NodeLine) -> None:
    from tmcl_bus.segment_nodes import add_nodes

    add_nodes(bench, config, line)


BUS = BusKind(
    nodes=NodeKind(
        key="tmcl",
        about="Axes on this wire as modules of TMCL, a mapping.",
        model=_model,
        axes_key="modules",
        findings=_findings,
        framing=_framing,
        add=_add,
    ),
    sections=(("## TMCL modules: `segments.<name>.tmcl`", "TmclConfig"),),
)
