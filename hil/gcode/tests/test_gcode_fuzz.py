"""Damaged programs: nothing is raised, every problem has a place, and nothing moves that should not.

``HIL_FUZZ`` sets how many are tried (1000; ``make fuzz``: 100,000), ``HIL_FUZZ_SEED`` where they start.
"""

import os
from math import hypot, isfinite
from random import Random

import pytest
from chance_programs import damaged, program
from hypothesis import example, given, settings
from hypothesis import strategies as st

from hil.gcode.block import LIMIT
from hil.gcode.canonical import PLANE_AXES, Arc, Dwell, Point, Program, Straight, Switch
from hil.gcode.reader import MOST_PROBLEMS, read_program
from hil.gcode.state import TOLERANCE_INCH

CASES = int(os.environ.get("HIL_FUZZ", "1000"))
SEED = int(os.environ.get("HIL_FUZZ_SEED", "1"))
WORDS = st.sampled_from(
    (
        *("g0", "g1", "g2", "g3", "g4", "g10", "g20", "g28", "g53", "g92", "g93", "g95", "m2", "m3", "m6"),
        *"xyzafsprijklnto#=[]<>();/%+-*10@é \n\t\udc80",
        *(
            "**",
            ".5",
            "7.",
            "1e9",
            "99999999999",
            "#1",
            "#<a>",
            "sin",
            "atan",
            "exists",
            "mod",
            "and",
            "\r\n",
        ),
    )
)


def check(text: bytes) -> Program:
    """Read a text, and check what holds of any."""
    read = read_program(text)
    marks = text.decode(errors="surrogateescape").replace("\r", "\n")
    last = marks.count("\n") + 1
    assert len(read.problems) <= MOST_PROBLEMS
    for each in (*read.problems, *read.remarks):
        assert 1 <= each.line <= last
        assert 1 <= each.column <= len(text) + 1
        assert each.message
        assert each.remedy
        assert str(each).isprintable()
    if read.problems:
        assert read.motions == ()
    here = Point()
    for motion in read.motions:
        assert 1 <= motion.place.line <= last
        if isinstance(motion, Straight | Arc):
            check_motion(here, motion)
            here = motion.end
        elif isinstance(motion, Dwell):
            assert 0 <= motion.seconds < LIMIT
        elif isinstance(motion, Switch) and motion.speed_rpm is not None:
            assert 0 <= motion.speed_rpm < LIMIT
    return read


def check_motion(here: Point, motion: Straight | Arc) -> None:
    assert all(isfinite(value) and abs(value) < LIMIT for value in motion.end)
    if isinstance(motion, Straight):
        assert motion.end != here
        assert (motion.feed is None) == motion.is_rapid
    if motion.feed is not None:
        assert 0 < motion.feed.value < 26 * LIMIT
    if isinstance(motion, Arc):
        assert motion.turns != 0
        first, second, _ = PLANE_AXES[motion.plane]
        radii = [
            hypot(point[first] - motion.centre[0], point[second] - motion.centre[1])
            for point in (here, motion.end)
        ]
        assert min(radii) > 0
        assert abs(radii[0] - radii[1]) <= TOLERANCE_INCH.never_mm


def test_fuzz_damaged_programs() -> None:
    chance = Random(SEED)
    refused = 0
    for case in range(CASES):
        text = program(SEED * 1_000_000 + case, rare=0.005).encode()
        refused += bool(check(damaged(chance, text)).problems)
    assert 0.5 < refused / CASES < 0.99


@settings(max_examples=300, deadline=None)
@given(st.binary(max_size=300))
def test_any_bytes(text: bytes) -> None:
    check(text)


@settings(max_examples=500, deadline=None)
@given(st.lists(WORDS, max_size=60))
@example(["#1=", "1", "0" * 29, " g", "#1"])
@example(["#5420", "=", "1", "\n", "g#5421"])
def test_any_words(words: list[str]) -> None:
    check("".join(words).encode(errors="surrogateescape"))


def test_usual_lines_are_read_as_all_others_are() -> None:
    for seed in range(300):
        text = program(seed, rare=0.002)
        slow = text.replace("\n", ";\n")
        usual, other = read_program(text.encode()), read_program(slow.encode())
        assert usual.motions == other.motions
        assert [problem.message for problem in usual.problems] == [each.message for each in other.problems]


@pytest.mark.long
def test_the_time_is_that_of_the_length() -> None:
    """Each would take minutes if a part of it were tried again and again."""
    for line in (
        b"1" * 250,
        b"G0 X" + b"-" * 250,
        b"(" * 250,
        b"X1" * 125,
        b" " * 250,
        b"[" * 120,
        b"N" + b"0" * 250,
    ):
        read = check((line + b"\n") * 2000)
        assert read.problems
    check(b"G1 X1 F9\n" * 100_000)
    check(b";" * 3_000_000)
    check(b"\n" * 1_000_000)
