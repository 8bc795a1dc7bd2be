"""Time to plan 1,000 moves of 6 axes; at most 100 ms is wanted.

S-curves from rest, from starts in motion, and in a line. Beside them ruckig (extra dev), with the moves from
rest and in motion, and without the time that handing them over takes: its objects are made before.
"""

import random
import statistics
import time
from collections.abc import Callable

from _report import check_work, is_quick, report

from hil.core.trajectory import AxisLimits, PointState, plan_joint, plan_line

MOVES, AXES = 1000, 6
WANTED_MS = 100
RUNS = 3 if is_quick() else 11

Move = tuple[list[PointState], list[float], list[AxisLimits]]


def moves(is_moving: bool) -> list[Move]:
    rng = random.Random(1)
    made = []
    for _ in range(MOVES):
        limits = [
            AxisLimits(10 ** rng.uniform(1, 3), 10 ** rng.uniform(1, 4), 10 ** rng.uniform(2, 5))
            for _ in range(AXES)
        ]
        starts = [start(rng, axis) if is_moving else PointState(rng.uniform(-100, 100)) for axis in limits]
        made.append((starts, [rng.uniform(-720, 720) for _ in range(AXES)], limits))
    return made


def start(rng: random.Random, limits: AxisLimits) -> PointState:
    """State in motion, from which the limits can be kept: at most half of the velocity and acceleration
    limits, and no acceleration that leads above the velocity limit."""
    v = rng.uniform(-0.5, 0.5) * limits.velocity_max
    most_a = min(limits.acceleration_max / 2, (limits.velocity_max * limits.jerk_max) ** 0.5)
    return PointState(rng.uniform(-100, 100), v, rng.uniform(-1, 1) * most_a)


def ours(made: list[Move]) -> Callable[[], None]:
    def run() -> None:
        for starts, targets, limits in made:
            plan_joint(starts, targets, limits)

    return run


def lines(made: list[Move]) -> Callable[[], None]:
    points = [([start.position_deg for start in starts], targets, limits) for starts, targets, limits in made]

    def run() -> None:
        for starts, targets, limits in points:
            plan_line(starts, targets, limits)

    return run


def theirs(made: list[Move]) -> Callable[[], None] | None:
    try:
        import ruckig
    except ImportError:
        return None
    planner, tasks, found = ruckig.Ruckig(AXES), [], ruckig.Trajectory(AXES)
    for starts, targets, limits in made:
        task = ruckig.InputParameter(AXES)
        task.current_position = [start.position_deg for start in starts]
        task.current_velocity = [start.velocity_deg_per_s for start in starts]
        task.current_acceleration = [start.acceleration_deg_per_s2 for start in starts]
        task.target_position = targets
        task.max_velocity = [axis.velocity_max for axis in limits]
        task.max_acceleration = [axis.acceleration_max for axis in limits]
        task.max_jerk = [axis.jerk_max for axis in limits]
        tasks.append(task)

    def run() -> None:
        for task in tasks:
            planner.calculate(task, found)

    return run


def check_ends(rest: list[Move], moving: list[Move]) -> None:
    """Check that what is planned ends at its targets, at rest."""
    plans = [plan_joint(*move) for move in (*rest, *moving)]
    plans += [plan_line([each.position_deg for each in starts], *move) for starts, *move in rest]
    targets_deg = [targets for _, targets, _ in (*rest, *moving, *rest)]
    reached = sum(
        all(
            abs(state.position_deg - target_deg) < 1e-6 and abs(state.velocity_deg_per_s) < 1e-6
            for state, target_deg in zip(plan.at(plan.duration_ns), targets, strict=True)
        )
        for plan, targets in zip(plans, targets_deg, strict=True)
    )
    check_work("moves that end at their targets", reached, len(plans))


def median_ms(run: Callable[[], None]) -> float:
    times = []
    for _ in range(RUNS):
        began = time.perf_counter()
        run()
        times.append((time.perf_counter() - began) * 1e3)
    return statistics.median(times)


def main() -> None:
    rest, moving = moves(False), moves(True)
    check_ends(rest, moving)
    for name, mine, reference in (
        ("rest", ours(rest), theirs(rest)),
        ("moving", ours(moving), theirs(moving)),
        ("line", lines(rest), None),
    ):
        ruckig_ms = median_ms(reference) if reference else None
        extra = {"reference": "what is wanted", "ruckig_ms": ruckig_ms}
        report(f"planning_{name}", median_ms(mine), "ms", WANTED_MS, 1, extra)
        if ruckig_ms is not None:
            print(f"  ruckig: {ruckig_ms:.4g} ms")
        else:
            print("  ruckig: none, " + ("it has no lines" if name == "line" else "it is not installed"))


main()
