from array import array
from collections.abc import Sequence
from typing import Protocol

class _State(Protocol):
    @property
    def position_deg(self) -> float: ...
    @property
    def velocity_deg_per_s(self) -> float: ...
    @property
    def acceleration_deg_per_s2(self) -> float: ...

class _Limits(Protocol):
    @property
    def velocity_max(self) -> float: ...
    @property
    def acceleration_max(self) -> float: ...
    @property
    def jerk_max(self) -> float: ...

MAX_AXES: int
SEGMENTS: int

class Course:
    axes: int
    is_line: bool
    fault_axis: int
    least_ns: int
    duration_ns: int
    def __init__(self, axes: int, room: int = ...) -> None: ...
    def joint(
        self,
        starts: Sequence[_State],
        targets: Sequence[float],
        limits: Sequence[_Limits],
        is_s_curve: bool,
        duration_ns: int = ...,
    ) -> int: ...
    def line(
        self,
        starts: Sequence[float],
        targets: Sequence[float],
        limits: Sequence[_Limits],
        is_s_curve: bool,
        duration_ns: int = ...,
    ) -> int: ...
    def velocity(
        self,
        starts: Sequence[_State],
        velocities: Sequence[float],
        limits: Sequence[_Limits],
        is_s_curve: bool,
    ) -> int: ...
    def stop(self, running: Course, at_ns: int, limits: Sequence[_Limits], is_s_curve: bool) -> int: ...
    def spline(self, times_ns: Sequence[int], points: Sequence[Sequence[float]]) -> int: ...
    def stretched(self, factor: float) -> tuple[int, Course]: ...
    def at(self, axis: int, at_ns: int) -> tuple[float, float, float]: ...
    def positions(self, from_ns: int, step_ns: int, count: int) -> array[float]: ...
    def segments_of(self, axis: int) -> list[tuple[float, float, float, float, float, float]]: ...
    def check(self, limits: Sequence[_Limits], is_s_curve: bool) -> int: ...
    def violation(
        self, limits: Sequence[_Limits], is_s_curve: bool
    ) -> tuple[int, int, int, float, float] | None: ...
    def fit(self, limits: Sequence[_Limits], is_s_curve: bool) -> float: ...
