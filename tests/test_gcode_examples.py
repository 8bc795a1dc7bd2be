"""Programs of ``examples/gcode``: made by their program, read without a problem, and what they draw."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent.parent / "examples" / "gcode"))
from make_programs import PROGRAMS, engraving, mixed_units

from hil.gcode.canonical import Arc, Program, Straight
from hil.gcode.reader import read_program

FOLDER = Path(__file__).parent.parent / "examples" / "gcode"


def read(text: str) -> Program:
    program = read_program(text.encode())
    assert program.problems == ()
    assert program.remarks == ()
    return program


def ends(program: Program) -> list[tuple[float, float, float]]:
    return [each.end[:3] for each in program.motions if isinstance(each, Straight | Arc)]


def test_each_file_is_made_by_the_program() -> None:
    assert {path.name for path in FOLDER.glob("*.ngc")} == set(PROGRAMS)
    for name, make in PROGRAMS.items():
        assert (FOLDER / name).read_text() == make(), f"run: python examples/gcode/make_programs.py ({name})"


@pytest.mark.parametrize("name", PROGRAMS)
def test_each_stays_where_a_small_mill_is(name: str) -> None:
    for x, y, z in ends(read((FOLDER / name).read_text())):
        assert 0 <= x <= 120
        assert 0 <= y <= 80
        assert -5 <= z <= 30


def test_an_engraving_has_the_lines_that_are_asked_for() -> None:
    text = engraving(10_000)
    assert text.count("\n") == 10_000
    assert len(ends(read(text))) > 9_900


def test_a_square_is_the_same_in_all_units() -> None:
    places = ends(read(mixed_units()))
    once = [tuple(round(value, 6) for value in place) for place in places]
    assert len(set(once)) == 5
