"""The reader against LinuxCNC 2.9's interpreter: the same motions, and refusals of the same lines."""

import os

import chance_programs
import pytest
from linuxcnc_reference import RARE, Outcome, Reference, differences, is_here, outcome_of, stored

from hil.gcode.differences import DIFFERENCES, DialectDifference
from hil.gcode.reader import read_program

EACH = 1 if os.environ.get("HIL_FUZZ") else 20
"""Each how many of the stored programs the interpreter reads again: it starts in 15 ms."""

PROGRAMS = 2000 if os.environ.get("HIL_FUZZ") else 40


def different(text: bytes, theirs: Outcome) -> list[str]:
    return differences(outcome_of(read_program(text), text), theirs)


@pytest.fixture(scope="module")
def reference(tmp_path_factory: pytest.TempPathFactory) -> Reference:
    if not is_here():
        pytest.skip("there is no rs274 here")
    return Reference(tmp_path_factory.mktemp("linuxcnc"))


def test_what_linuxcnc_made_of_programs() -> None:
    rows = stored()
    assert len(rows) > 580
    assert 200 < sum(row.outcome.refused is not None for row in rows) < 300
    assert [(row.key, found) for row in rows if (found := different(row.text, row.outcome))] == []


def test_a_difference_is_found() -> None:
    wrong = {b"G1 F100 X10\nM2\n": b"G1 F100 X10.00001\nM2\n", b"G0 X1\nM2\n": b"G0 X\nM2\n"}
    for text, other in wrong.items():
        assert different(text, outcome_of(read_program(other), other))


@pytest.mark.long
def test_linuxcnc_still_makes_the_same(reference: Reference) -> None:
    changed = {}
    for row in stored()[::EACH]:
        if found := differences(reference.read(row.text), row.outcome):
            changed[str(row.key)] = found
    assert changed == {}


def outcome_of_ours(program: str) -> Outcome:
    text = f"{program}\nM2\n".encode()
    return outcome_of(read_program(text), text)


@pytest.mark.parametrize("row", DIFFERENCES, ids=lambda row: row.what)
def test_what_the_table_of_differences_says_of_ours(row: DialectDifference) -> None:
    assert (outcome_of_ours(row.program).refused is not None) == (row.ours == "refuses")


@pytest.mark.long
@pytest.mark.parametrize("row", DIFFERENCES, ids=lambda row: row.what)
def test_what_the_table_of_differences_says_of_linuxcnc(row: DialectDifference, reference: Reference) -> None:
    theirs = reference.read(f"{row.program}\nM2\n".encode())
    assert (theirs.refused is not None) == (row.theirs == "refuses"), theirs
    assert differences(outcome_of_ours(row.program), theirs)


@pytest.mark.long
def test_programs_by_chance(reference: Reference) -> None:
    found, refused = {}, 0
    for seed in range(PROGRAMS):
        text = chance_programs.program(seed, rare=(RARE, 0.1)[seed % 4 == 0]).encode()
        program = read_program(text)
        refused += bool(program.problems)
        if what := differences(outcome_of(program, text), reference.read(text)):
            found[seed] = what
    assert found == {}
    assert 0.2 < refused / PROGRAMS < 0.7
