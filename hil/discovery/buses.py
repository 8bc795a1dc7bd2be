"""Kinds of buses that exist."""

from collections.abc import Mapping
from functools import cache

from hil.discovery.installed import BUSES, PORTS
from hil.discovery.named_kinds import Kinds
from hil.vocab.bus import BusKind
from hil.vocab.problem import Problem, Unusable
from hil.vocab.wire import WireInfo


@cache
def find_buses() -> tuple[tuple[BusKind, ...], tuple[Problem, ...]]:
    """Find the kinds of buses: with hil among the bridges, and installed beside it; and the problems of those
    that cannot be imported."""
    kinds = Kinds("bridges", BUSES, "bus_kind")
    found, problems = list[BusKind](), list[Problem]()
    for name in kinds:
        try:
            found.append(kinds.attribute(name, "BUS"))
        except Unusable as error:
            problems.append(Problem(f"the bus {name}", 0, 0, str(error), error.remedy))
    return tuple(found), tuple(problems)


@cache
def find_wire_infos() -> Mapping[str, WireInfo]:
    """Find the reports on wires, by the key of a configuration under which they stand: segments first."""
    segments: WireInfo = Kinds("virtual_ports", PORTS, "segment_reports").attribute("rs485", "REPORTS")
    own = {bus.wires.key: bus.wires.info for bus in find_buses()[0] if bus.wires}
    return {segments.key: segments, **own}
