"""Random motions on random machines: nothing moves that should not, and commands come to where they should.

``HIL_FUZZ``: how many programs (20; ``make fuzz``: 2,000); ``HIL_FUZZ_SEED``.
"""

import os
from math import isfinite
from random import Random

from device_profiles.sac.path_planner import PATHS
from hil.gcode.canonical import Arc, Dwell, Feed, PathMode, Point, Straight, TextPlace
from hil.toolpath.line_load import line_load
from hil.toolpath.machine import machine_from_data
from hil.toolpath.node_phrases import NodePhrases
from hil.toolpath.path_plan import plan_path

PROGRAMS = int(os.environ.get("HIL_FUZZ", "20"))
SEED = int(os.environ.get("HIL_FUZZ_SEED", "1"))
SIZES = (1e-9, 1e-3, 0.05, 0.05, 1, 1, 5)


def random_machine(random):
    axes = {}
    for node, letter in enumerate(random.sample("xyzac", random.randint(1, 4))):
        unit = "deg" if letter in "abc" else "mm"
        axes[letter] = {
            "node": 4 + node,
            f"steps_per_{unit}": random.choice((0.5, 5, 80)),
            "microstep_exponent": random.randint(0, 4),
            "is_reversed": random.random() < 0.5,
            f"min_{unit}": -random.choice((3, 40, 200)),
            f"max_{unit}": random.choice((3, 40, 200)),
            f"velocity_{unit}_per_min": random.choice((6, 600, 6000)) / 4,
            f"acceleration_{unit}_per_s2": random.choice((0.5, 50, 2000)),
        }
    tolerance_mm, segment_ms = random.choice((0.001, 0.02, 1)), random.choice((20, 50, 200))
    return machine_from_data(
        {"machine": "any", "tolerance_mm": tolerance_mm, "segment_ms": segment_ms, "axes": axes}
    )


def random_motions(random, letters):
    here = Point()
    for line in range(1, random.randint(2, 25)):
        place, size = TextPlace(line, 1), random.choice(SIZES)
        feed = Feed("per_minute", 1e-9 if random.random() < 0.002 else random.choice((5, 60, 1200, 1e9)))
        kind = random.random()
        moved = {
            letter: getattr(here, letter) + random.uniform(-size, size)
            for letter in (letters if random.random() < 0.995 else "xyzuvw")
            if random.random() < 0.7
        }
        if kind < 0.1:
            yield PathMode(
                place, random.choice(("exact_path", "exact_stop", "blend")), random.choice((None, 0.05))
            )
        elif kind < 0.15:
            yield Dwell(place, random.choice((0.0, 0.5)))
        elif kind < 0.4 and {"x", "y"} <= {*letters}:
            end = here._replace(**moved)
            across = random.uniform(-2, 2)  # both ends have one radius
            centre = (
                (here.x + end.x) / 2 - across * (end.y - here.y),
                (here.y + end.y) / 2 + across * (end.x - here.x),
            )
            yield Arc(place, "xy", end, centre, random.choice((-2, -1, 1, 2)), feed)
            here = end
        else:
            here = here._replace(**moved)
            yield Straight(place, random.random() < 0.2, here, feed)


def check(machine, plan):
    limits = {axis.letter: (axis.minimum, axis.maximum, axis.pulses_per_unit) for axis in machine.axes}
    at = None
    for phrase in NodePhrases(machine, PATHS).of(plan):
        if not hasattr(phrase, "commands"):
            continue
        assert at is None or at == phrase.begin
        at, needed, ends = dict(phrase.begin), -1.0, {}
        for command, _ in phrase.commands:
            assert command.data[:2].strip(b"m-").isdigit() or command.data[2:3].isdigit()
            assert not command.data.startswith((b"m0", b"m-0"))  # without end
            assert command.pulses != 0
            assert command.start_us >= ends.get(command.axis, 0.0) >= 0
            assert command.end_us > command.start_us
            assert command.needed_us >= needed
            assert (b"s" in command.data) == (command.axis not in ends)
            needed, ends[command.axis] = command.needed_us, command.end_us
            at[command.axis] += command.pulses
            low, high, unit = limits[command.axis]
            place = at[command.axis] / unit
            assert low - 1 / abs(unit) <= place <= high + 1 / abs(unit)
        assert at == phrase.end


def test_fuzz_of_programs():
    moved = 0
    for number in range(PROGRAMS):
        random = Random(f"{SEED} {number}")
        machine = random_machine(random)
        letters = [axis.letter for axis in machine.axes]
        plan = plan_path(list(random_motions(random, letters)), machine, "any.ngc")
        assert isfinite(plan.duration_s)
        if plan.problems:
            assert plan.items == []
            continue
        for each in plan.stretches:
            segments = list(each.segments(machine))
            assert all(0 < segment.duration_s < 1e6 for segment in segments)
            assert line_load(machine, each.stretch.begin, segments).ahead >= 1
        if plan.duration_s < 100:
            check(machine, plan)
            moved += plan.duration_s > 1
    assert moved > PROGRAMS / 20
