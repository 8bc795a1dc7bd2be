"""Kinds of buses that exist."""

from collections.abc import Mapping
from functools import cache

from hil.discovery.installed import BUSES
from hil.discovery.named_kinds import Kinds
from hil.vocab.bus import BusKind
from hil.vocab.problem import Problem, Unusable
from hil.vocab.wire import WireInfo


@cache
def find_buses() -> tuple[tuple[BusKind, ...], tuple[Problem, ...]]:
    """Find the kinds of buses: with hil among the ports and the bridges, and installed beside it; and the
    problems of those that cannot be imported."""
    found, problems = list[BusKind](), list[Problem]()
    for kinds in (Kinds("virtual_ports", None, "bus_kind"), Kinds("bridges", BUSES, "bus_kind")):
        for name in kinds:
            try:
                found.append(kinds.attribute(name, "BUS"))
            except Unusable as error:
                problems.append(Problem(f"the bus {name}", 0, 0, str(error), error.remedy))
    return tuple(found), tuple(problems)


@cache
def find_wire_infos() -> Mapping[str, WireInfo]:
    """Find the reports on wires, by the key of a configuration under which they stand: segments first."""
    buses, _ = find_buses()
    segments = {bus.segments.info.key: bus.segments.info for bus in buses if bus.segments}
    return segments | {bus.wires.key: bus.wires.info for bus in buses if bus.wires}
