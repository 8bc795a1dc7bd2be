"""Lease of a bench: who has it for a while, and the doors that are closed to others meanwhile."""

from hil.vocab.late_dataclass import dataclass

DOORS = {
    "ports": "clients of serial ports, and of taps",
    "modbus": "clients of the Modbus bridge",
    "can": "programs at channels of CAN buses",
    "web": "the page, where it has no users",
    "zenoh": "clients over zenoh, where the bench has no users",
}
"""Doors whose askers have no name, so that a lease closes them to commands, unless it opens them."""
LONGEST_S = 7 * 86_400.0
"""Maximum time from now to the end of a lease: one that is forgotten ends within a week."""
WHY_CHARACTERS = 200


@dataclass(frozen=True)
class Lease:
    """Lease of a bench. Times are the wall's, in nanoseconds since 1970. ``user``: its holder, by the name
    that doors know; ``doors``: those of ``DOORS`` that it opens."""

    user: str
    why: str
    doors: tuple[str, ...]
    since_wall_ns: int
    until_wall_ns: int

    @property
    def closed(self) -> tuple[str, ...]:
        """Doors that are closed to commands."""
        return tuple(door for door in DOORS if door not in self.doors)


def time_said(length_s: float) -> str:
    """Format a length of time, in the two largest units: 1 h 59 min, 12 s."""
    left = max(0, round(length_s))
    units = (("d", 86_400), ("h", 3_600), ("min", 60), ("s", 1))
    said = []
    for unit, size in units:
        if count := left // size:
            said.append(f"{count} {unit}")
            left -= count * size
    return " ".join(said[:2]) or "0 s"
