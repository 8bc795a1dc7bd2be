"""Kinds of buses that exist."""

from functools import cache

from hil.compose.kinds_of_doors import Kinds
from hil.config.catalogue import Unusable
from hil.discovery.installed import BUSES
from hil.vocab.bus import BusKind
from hil.vocab.problem import Problem


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
