"""Axes of no board: how an axis of runs has to be used, and no more."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from hil.firmware.set_point_paths import at, length_ns
from hil.vocab.axis import Axis, AxisNow, AxisState, How, Sample
from hil.vocab.path import DEG_PER_S, Path, PathPiece
from hil.vocab.time import NS_PER_MS, NS_PER_S, SimTimeNs
from hil.vocab.verbs import VerbRefused

STOPS_NS = 20 * NS_PER_MS
"""Time that a model needs to stop with grace."""


@dataclass
class Wrong:
    """Something that goes wrong with an axis at a time: it fails, refuses motions, somebody moves it, or its
    shaft stays behind."""

    at_ns: int
    what: str


@dataclass
class ModelClock:
    now_ns: SimTimeNs


@dataclass
class ModelAxis:
    """Axis that goes exactly along its paths, or at a constant speed to its targets. ``used`` says what was
    done with it, and when."""

    clock: ModelClock
    follows_paths: bool
    tells_position: bool
    wrong: Wrong | None = None
    lead_ns: int = 0
    used: list[tuple[int, str, Any]] = field(default_factory=list)
    is_held: bool = False
    refusal: str | None = None
    _from_ns: int = -1
    _path: Path = (PathPiece(0, 0.0),)
    _sampled_ns: int = 0

    def now(self) -> AxisNow:
        why_not = "it is held" if self.is_held else self.failure
        pins = ("in",) if self.tells_position else ()
        return AxisNow(
            self._at(self.clock.now_ns),
            self.follows_paths,
            ("v",),
            pins,
            why_not,
            tells_position=self.tells_position,
        )

    def _at(self, at_ns: int) -> float:
        return at(self._path, at_ns - self._from_ns)[0]

    def _has_gone(self, what: str) -> bool:
        return self.wrong is not None and self.wrong.what == what and self.clock.now_ns >= self.wrong.at_ns

    @property
    def failure(self) -> str | None:
        return "it is broken" if self._has_gone("fails") else None

    @property
    def is_under_way(self) -> bool:
        return self.clock.now_ns <= self.ends_ns and not self._has_gone("is moved")

    @property
    def ends_ns(self) -> int:
        return self._from_ns + length_ns(self._path)

    def state(self) -> AxisState:
        now_ns, moves = self.clock.now_ns, self.is_under_way
        at_deg = self._at(now_ns) + (77.7 if self._has_gone("is moved") else 0.0)  # to no angle of a run
        told_deg = at_deg if self.tells_position else None
        is_on = True if self.tells_position else None
        keeps = self.follows_paths and self.tells_position
        return AxisState(now_ns, at_deg, told_deg, moves, moves, is_on, keeps)

    def field(self, name: str) -> float:
        assert name in self.now().fields
        return self._at(self.clock.now_ns)

    def hold(self) -> None:
        assert not self.is_held
        self.is_held, self.refusal, self._sampled_ns = True, None, self.clock.now_ns
        self._note("hold")

    def release(self) -> None:
        assert self.is_held
        self.is_held = False
        self._note("release")

    def samples(self) -> Sequence[Sample]:
        assert self.is_held
        since_ns, self._sampled_ns = self._sampled_ns, self.clock.now_ns
        if not self.tells_position:
            return ()
        off_deg = 50.0 if self._has_gone("stays behind") else 0.0
        times_ns = range(since_ns + 1, self.clock.now_ns + 1, 5 * NS_PER_MS)
        return [(float(at_ns), self._at(at_ns), self._at(at_ns) - off_deg) for at_ns in times_ns]

    def follow(self, path: Path, start_ns: int) -> int:
        assert self.follows_paths
        self._begin("follow", path, start_ns)
        return start_ns

    def join(self, path: Path, start_ns: int) -> None:
        assert self.follows_paths
        assert self.tells_position
        assert self.is_held
        self._note("join", start_ns)
        self._path, self._from_ns = path, start_ns

    def move(self, position_deg: float, velocity_rpm: float, start_ns: int) -> None:
        assert not self.follows_paths
        from_deg, per_s = self._at(self.clock.now_ns), velocity_rpm * DEG_PER_S
        lasts_ns = round(abs(position_deg - from_deg) / per_s * NS_PER_S)
        rate = per_s if position_deg > from_deg else -per_s
        self._begin("move", (PathPiece(lasts_ns, from_deg, rate), PathPiece(0, position_deg)), start_ns)

    def set_pin(self, pin: str, level: int, at_ns: int) -> None:
        assert self.is_held
        assert pin in self.now().pins
        self._note("set_pin", level)

    def stop(self, how: How, acceleration_rpm_per_s: float) -> None:
        assert self.is_held
        assert acceleration_rpm_per_s > 0
        self._note("stop", how)
        at_deg, self._from_ns = self._at(self.clock.now_ns), self.clock.now_ns
        self._path = (PathPiece(STOPS_NS if how == "grace" else 0, at_deg), PathPiece(0, at_deg))

    def _begin(self, what: str, path: Path, start_ns: int) -> None:
        assert self.is_held
        assert start_ns >= self.clock.now_ns + self.lead_ns
        assert self.clock.now_ns >= self.ends_ns
        if self._has_gone("refuses"):
            raise VerbRefused("not_now", "it does not want to")
        if self._has_gone("refuses later"):
            self.refusal = "it could not"
            return
        self._note(what, start_ns)
        self._path, self._from_ns = path, start_ns

    def _note(self, what: str, about: Any = None) -> None:
        self.used.append((self.clock.now_ns, what, about))


class ModelAxes:
    """Axes by name, and their time, as ``hil.vocab.axis.Axes``."""

    def __init__(self, clock: ModelClock, by_name: dict[str, ModelAxis]) -> None:
        self._clock = clock
        self.by_name = by_name

    @property
    def now_ns(self) -> int:
        return self._clock.now_ns

    def axes(self) -> dict[str, AxisNow]:
        return {name: axis.now() for name, axis in self.by_name.items()}

    def __getitem__(self, device: str) -> Axis:
        return self.by_name[device]
