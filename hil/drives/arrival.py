"""Watch over the end of a motion: by what the drive tells: under way, arrived, or stopped short."""

from dataclasses import dataclass
from typing import Literal

from hil.drives.reading import Reading

ARRIVED_DEG = 0.5
"""Maximum distance from the target at which a motion has come to it."""
SHOWS_NS = 200_000_000
"""Time from the command until a drive says that it moves."""
SETTLES_NS = 1_000_000_000
"""Time for the shaft to come to the target when nothing moves any more, or does not come nearer."""
STUCK_NS = 3_000_000_000
"""Time for a drive that says that it moves to come nearer by a tenth of the distance at which it is there."""

Verdict = Literal["under_way", "arrived", "short"]


@dataclass
class Arrival:
    """Watch over one motion to ``target_deg``, from the time on at which its end was commanded
    (``since_ns``). ``within_deg``: maximum distance, a step of the drive's registers included."""

    target_deg: float
    since_ns: int
    within_deg: float = ARRIVED_DEG

    def __post_init__(self) -> None:
        self._progress_ns = self.since_ns
        self._nearest_deg = float("inf")
        self._has_moved = False

    def look(self, reading: Reading) -> Verdict:
        """Say how the motion does, by a reading."""
        if reading.at_ns <= self.since_ns:
            return "under_way"
        off_deg = abs(reading.values["position_deg"] - self.target_deg)
        moves = reading.bits.get("status.moving")  # None: the map has no such bit
        self._has_moved = self._has_moved or bool(moves)
        has_begun = self._has_moved or reading.at_ns > self.since_ns + SHOWS_NS
        if off_deg <= self.within_deg and (moves is None or (not moves and has_begun)):
            return "arrived"
        if off_deg < self._nearest_deg - self.within_deg / 10:
            self._progress_ns = reading.at_ns
            self._nearest_deg = off_deg
        patience_ns = STUCK_NS if moves else SHOWS_NS + SETTLES_NS
        return "short" if reading.at_ns > self._progress_ns + patience_ns else "under_way"
