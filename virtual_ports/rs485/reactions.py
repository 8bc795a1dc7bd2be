"""Reaction times of a segment's nodes beside their turnaround: no two boards are alike to the nanosecond."""

from hil.wire.byte_faults import Chance
from virtual_ports.rs485.stations import Stations

CLASHING_NS = 100_000
"""Spread of the answers of nodes that share an address, unless it is said: what the main loops and timers of
two small processors differ by. It is four bits at 38,400 baud, less than the half character that a master
spares."""


class StationReactions:
    """Reaction times by station, drawn from the seed, the station's name and the number of its answer."""

    def __init__(self, stations: Stations) -> None:
        self._stations = stations
        self._most_ns: int | None = None
        self._seed = 0
        self._chances: dict[str, Chance] = {}

    def spread(self, most_ns: int | None, seed: int) -> None:
        """Set how much later an answer begins at most; None: only those of nodes that share an address do."""
        self._most_ns, self._seed = most_ns, seed
        self._chances.clear()

    def delay_ns(self, station: str) -> int:
        """Draw the time by which a station's answer begins later than its turnaround is over."""
        most_ns = self._most_ns
        if most_ns is None:
            address = self._stations[station].address if station in self._stations else None
            is_alone = address is None or len(self._stations.by_address.get(address, ())) < 2
            most_ns = 0 if is_alone else CLASHING_NS
        if most_ns <= 0:
            return 0
        if (chance := self._chances.get(station)) is None:
            chance = self._chances[station] = Chance(self._seed ^ int.from_bytes(station.encode(), "big"))
        return chance.bits() % (most_ns + 1)
