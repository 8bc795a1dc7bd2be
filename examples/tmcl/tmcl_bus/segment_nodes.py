"""Builder of the TMCL modules of a segment."""

from functools import partial

from hil.config.station_names import node_name
from hil.sim.bench import BenchRuntime
from hil.vocab.address import address_of
from hil.vocab.bus import NodeLine
from hil.vocab.time import NS_PER_MS
from tmcl_bus.card.module_axis import ModuleAxis
from tmcl_bus.card.tmcl_module import ModuleSpec, TmclModule
from tmcl_bus.tmcl_model import TMCL, TmclConfig


def add_nodes(bench: BenchRuntime, config: TmclConfig, line: NodeLine) -> None:
    """Put the modules of a segment on it, in the order of the configuration."""
    for axis, number in config.modules.items():
        owner, part = address_of(axis)
        device = bench.devices[owner]
        label, short = device.axes.label(owner, part), device.axes.short(part)
        moved = ModuleAxis(device, short, line.group, partial(bench.apply_unlogged, label))
        spec = ModuleSpec(
            node_name(label, TMCL),
            number,
            config.host,
            line.baud,
            round(config.response_ms * NS_PER_MS),
            line.version,
        )
        bench.add_card(TmclModule(spec, moved, line.segment, line.group))
