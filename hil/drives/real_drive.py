"""Real drive: its link, and what it has told, whatever it is asked over."""

import asyncio
import logging
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from hil.drives.drive_link import DriveLink, Reading
from hil.vocab.desk_protocol import AxisField
from hil.vocab.ports import EchoStats
from hil.vocab.verbs import Verb

OLD_NS = 500_000_000
"""Age of a state, beside the time for an answer, at which no run goes on with it, and a drive on CAN
is lost."""
FOUND_S = 0.5
"""Interval of looks for a drive whose place is not there."""

log = logging.getLogger("hil")


@dataclass(frozen=True)
class DrivePace:
    """Interval of a real drive's readings, and time-out of its answers, in seconds."""

    interval_s: float
    """Interval of readings of its state."""
    timeout_s: float
    """Time for an answer."""
    setpoint_s: float
    """Interval of set-points."""


@dataclass
class SentSetPoint:
    """Set-point that the drive confirmed last, at ``at_ns`` of simulated time."""

    deg: float
    at_ns: int


class RealDrive(ABC):
    """Drive of a bench. ``address``: where it is, in words; ``now_ns``: simulated time, which goes as fast as
    the wall's; ``listeners``: called with each reading."""

    fields: Mapping[str, AxisField]
    verbs: Mapping[str, Verb]

    def __init__(self, name: str, address: object, pace: DrivePace, now_ns: Callable[[], int]) -> None:
        self.name, self.pace, self.now_ns = name, pace, now_ns
        self.address = str(address)
        self.link = DriveLink()
        self.reading: Reading | None = None
        """Last reading, also of a session that has ended."""
        self.sent: SentSetPoint | None = None
        """Last set-point of this session."""
        self.listeners: list[Callable[[Reading], None]] = []
        self.settings: Mapping[str, float] = {}
        """Parameters as they were read or written last."""
        self.found = asyncio.Event()
        """Set while its place is there."""

    # ---- its place ----

    def place_found(self) -> None:
        self.link.place_found()
        self.found.set()

    def place_lost(self, why: str) -> None:
        was_there = self.link.is_there
        self.link.place_lost(why)
        self.found.clear()
        self.note(was_there)

    def note(self, was_there: bool) -> None:
        """Log that the drive is there, or not any more."""
        if was_there == self.link.is_there:
            return
        if was_there:
            self.sent = None
            log.warning("%s: the drive at %s is lost: %s", self.name, self.address, self.link.why)
        else:
            log.info("%s: the drive at %s is there", self.name, self.address)

    def is_in(self, session: int) -> bool:
        """True if this session goes on."""
        return self.link.is_there and self.link.session == session

    def note_reading(self, reading: Reading) -> None:
        """Note a reading, and tell those who listen."""
        self.reading = reading
        self.link.counters.polls += 1
        for listener in list(self.listeners):
            listener(reading)

    # ---- what it tells ----

    @property
    @abstractmethod
    def follows_paths(self) -> bool:
        """True if it takes a stream of set-points."""

    @property
    def has_angle(self) -> bool:
        """True if it can be sent to an angle; False: it only turns."""
        return True

    @property
    @abstractmethod
    def is_on(self) -> bool:
        """True if its loop is on."""

    @property
    @abstractmethod
    def fault(self) -> str | None:
        """Its fault in words, or None."""

    @property
    @abstractmethod
    def commanded_deg(self) -> float | None:
        """Set-point: the last that it confirmed, unless it tells another one since."""

    @property
    @abstractmethod
    def step_deg(self) -> float:
        """Step of its position: of two angles less far apart it does not know which."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Further facts about it now, for `hil status`."""
        return ()

    @property
    def echo(self) -> EchoStats | None:
        """Echo of its line's adapter; None: it has none."""
        return None

    @property
    def identity(self) -> Mapping[str, str]:
        """The drive's identity as it tells it, by names."""
        return {}

    @property
    def position_deg(self) -> float | None:
        return self.reading.values.get("position_deg") if self.reading else None

    def values(self) -> dict[str, float]:
        """Values of its fields by name; NaN of what is not told."""
        link, reading = self.link, self.reading
        told: dict[str, float] = dict.fromkeys(self.fields, math.nan)
        counters = vars(link.counters) | {"reconnects": link.counters.reconnects}
        told |= {name: value for name, value in counters.items() if name in told}
        told |= {name: value for name, value in self.settings.items() if name in told}
        told["connected"] = int(link.is_there)
        for part, name in ((0.5, "round_trip_p50_ms"), (0.99, "round_trip_p99_ms")):
            if (trip_ns := link.round_trip_ns(part)) is not None:
                told[name] = trip_ns / 1e6
        told["at_ns"] = 0
        if reading:
            told |= {name: value for name, value in reading.values.items() if name in told}
            told["at_ns"], told["age_ms"] = reading.at_ns, max(self.now_ns() - reading.at_ns, 0) / 1e6
            told["moving"] = int(reading.bits.get("status.moving", False))
            told["enabled"], told["fault"] = int(self.is_on), int(self.fault is not None)
            if (commanded_deg := self.commanded_deg) is not None and "commanded_deg" in told:
                told["commanded_deg"] = commanded_deg
        return told
