"""Lines and streams of SACs on a segment, measured pulse by pulse in simulated time.

``HIL_FUZZ``: how many random lines for each microstep exponent; ``HIL_FUZZ_SEED``.
"""

import os
from math import hypot
from random import Random

import pytest
from line_rig import LineRig

from device_profiles.sac.path_planner import PATHS
from device_profiles.sac.pulse_times import ramp_us
from hil.vocab.path_planning import AxisMotion, NodePhrase

LINES = int(os.environ.get("HIL_FUZZ", "8"))
SEED = int(os.environ.get("HIL_FUZZ_SEED", "1"))


def largest_deviation(times, steps, exponents):
    """Largest distance of two axes from the straight line between its ends, in full steps; each of ``times``
    begins and ends with the line."""
    events = sorted((at, axis) for axis, each in enumerate(times) for at in each)
    place, largest = [0.0, 0.0], 0.0
    for number, (at, axis) in enumerate(events):
        place[axis] += 2.0 ** -exponents[axis]
        if number + 1 == len(events) or events[number + 1][0] > at:
            off = abs(place[0] * steps[1] - place[1] * steps[0]) / hypot(*steps)
            largest = max(largest, off)
    assert place == list(steps)
    return largest


def random_move(axis, random, longest):
    steps = random.randint(1, random.choice((40, 400, longest)))
    unit = axis.pulses_per_step
    return AxisMotion(
        axis,
        random.choice((1, -1)) * steps * unit,
        random.uniform(20, 2000) * unit,
        random.uniform(100, 5000) * unit,
    )


@pytest.mark.long
@pytest.mark.parametrize("exponents", [(0, 0), (1, 1), (2, 2), (3, 3), (4, 4), (0, 3)])
def test_two_axes_leave_a_line_by_at_most_a_step(exponents):
    random, rig = Random(SEED), LineRig(exponents)
    longest = 4000 >> max(exponents)
    lines = [
        {name: random_move(axis, random, longest) for name, axis in rig.axes.items()} for _ in range(LINES)
    ]
    for moves in lines:
        rig.perform(PATHS.line(moves))
    assert rig.late == 0
    found = []
    for moves, pulses in zip(lines, rig.pulses(), strict=True):
        steps = [abs(move.pulses) / move.axis.pulses_per_step for move in moves.values()]
        found.append(largest_deviation(pulses.values(), steps, exponents))
    # A pulse by itself is up to 1, 0.5, 0.25... steps; the rest is what the plan leaves.
    assert max(found) <= min(1.0, 2.0 ** -min(exponents) + 0.3)
    assert max(found) > 0.4 * 2.0 ** -min(exponents)


def test_six_axes_end_within_a_period_of_each_other():
    rig, random = LineRig((0, 1, 2, 2, 1, 0)), Random(SEED)
    lines = [{name: random_move(axis, random, 1500) for name, axis in rig.axes.items()} for _ in range(20)]
    plans = [PATHS.line(moves) for moves in lines]
    for plan in plans:
        rig.perform(plan)
    for moves, plan, pulses in zip(lines, plans, rig.pulses(), strict=True):
        assert {name: len(each) for name, each in pulses.items()} == {
            name: abs(move.pulses) for name, move in moves.items()
        }
        release_ns = begin_of(plan, pulses)
        ends_us = {name: max(c.end_us for c in plan.commands if c.axis == name) for name in moves}
        last_steps_us = [
            end_us - (pulses[name][-moves[name].axis.pulses_per_step] - release_ns) / 1000
            for name, end_us in ends_us.items()
        ]
        assert max(ends_us.values()) - min(ends_us.values()) <= max(last_steps_us)


def begin_of(plan, pulses):
    """Time of the release, from an axis's first pulse."""
    first = plan.commands[0]
    return pulses[first.axis][0] - first.start_us * 1000


def test_a_plan_says_when_its_commands_begin_and_end():
    rig = LineRig((1, 0))
    plan = PATHS.line(
        {
            "s0": AxisMotion(rig.axes["s0"], 3000, 2000, 3000),
            "s1": AxisMotion(rig.axes["s1"], -617, 2000, 1000),
        }
    )
    rig.perform(plan)
    pulses = rig.pulses()[0]
    release_ns = begin_of(plan, pulses)
    for name in rig.axes:
        done = 0
        for command in (c for c in plan.commands if c.axis == name):
            assert pulses[name][done] == release_ns + command.start_us * 1000
            done += abs(command.pulses)
        assert done == len(pulses[name])


def test_speed_and_acceleration_stay_within_the_limits():
    axis = LineRig((1,)).axes["s0"]
    plan = PATHS.line({"s0": AxisMotion(axis, 8000, 2000, 3000)})
    cruise = max(plan.commands, key=lambda c: c.pulses)
    assert cruise.data == b"m6668vc1000a999"
    assert plan.commands[0].data.startswith(b"m666l1v300a47.12d999")  # 3000 pulses/s2 are 47.124 rad/s2


def test_a_line_of_nothing_is_refused():
    axis = LineRig((1,)).axes["s0"]
    for move in (AxisMotion(axis, 0, 1, 1), AxisMotion(axis, 9, 0, 1), AxisMotion(axis, 9, 1, -1.0)):
        with pytest.raises(ValueError, match="s0: a line needs"):
            PATHS.line({"s0": move})


def test_the_first_periods_of_a_ramp():
    """10.47 rad/s2 at 200 steps: the manual's c0 is 0.676 f sqrt(2 alpha / acc)."""
    assert ramp_us(200, 1047, 3) == (52367, 31420, 24438)


def test_a_stream_keeps_to_its_times_and_rests():
    rig = LineRig((1, 2))
    stream = PATHS.stream(rig.axes)
    commands = []
    ways = [{"s0": 37, "s1": -11}, {"s0": 41}, {"s0": -3, "s1": 0}, {"s1": 53}, {"s0": 1, "s1": 997}] * 4
    for pulses in ways:
        commands += stream.add(20_000, pulses)
    commands.sort(key=lambda c: c.needed_us)
    rig.perform(NodePhrase(commands, stream.at_us))
    assert rig.late == 0
    pulses = rig.pulses()[0]
    release_ns = begin_of(NodePhrase(commands, 0), pulses)
    for name in rig.axes:
        done = 0
        for number, way in enumerate(ways):
            if count := abs(way.get(name, 0)):
                begin_ns = pulses[name][done] - release_ns
                assert abs(begin_ns / 1000 - number * 20_000) <= 0.5 * 250
                done += count
        assert done == len(pulses[name])


def test_what_a_command_takes_on_the_line():
    assert PATHS.line_characters(len(b"m-123vc12345")) == 18 + 2 + 7
