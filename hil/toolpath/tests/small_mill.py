"""A machine for the tests, and programs for it."""

from hil.gcode.reader import read_program
from hil.toolpath.machine import machine_from_data
from hil.toolpath.path_plan import plan_path

LINEAR = {
    "steps_per_mm": 80,
    "min_mm": -100,
    "max_mm": 200,
    "velocity_mm_per_min": 3000,
    "acceleration_mm_per_s2": 200,
}
ROTARY = {
    "steps_per_deg": 10,
    "min_deg": -360,
    "max_deg": 360,
    "velocity_deg_per_min": 7200,
    "acceleration_deg_per_s2": 300,
}


def mill(letters="xyz", **changes):
    """Machine with these axes at the nodes from 4 on."""
    axes = {
        letter: {"node": 4 + number} | (ROTARY if letter in "abc" else LINEAR)
        for number, letter in enumerate(letters)
    }
    return machine_from_data({"machine": "mill", "axes": axes} | changes)


def motions_of(text):
    is_whole = any(end in text for end in ("M2\n", "M30", "%"))
    program = read_program(text.encode() + (b"" if is_whole else b"\nM2\n"))
    assert not program.problems, program.problems
    return program.motions


def planned(text, machine):
    return plan_path(motions_of(text), machine, "drawing.ngc")


def said(problems):
    return [str(problem) for problem in problems]
