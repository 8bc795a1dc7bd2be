"""The reader against LinuxCNC 2.9's interpreter: the same motions, and refusals of the same lines.

``linuxcnc_outcomes.jsonl`` has what ``rs274`` of Debian's linuxcnc-uspace 2.9.0~pre1 made of programs that we
wrote, a JSON object a line: lengths in millimetres, rounded to 1e-7.
"""

import json
import os
from pathlib import Path
from typing import Any

import chance_programs
import pytest
from linuxcnc_reference import Outcome, Reference, differences, is_here, outcome_of

from hil.gcode.differences import DIFFERENCES, DialectDifference
from hil.gcode.reader import read_program

EACH = 1 if os.environ.get("HIL_FUZZ") else 10
"""Each how many of the stored programs the interpreter reads again: it starts in 15 ms."""

PROGRAMS = 2000 if os.environ.get("HIL_FUZZ") else 60

OUTCOMES = Path(__file__).with_name("linuxcnc_outcomes.jsonl")


def stored() -> list[tuple[str, Outcome]]:
    rows = [json.loads(line) for line in OUTCOMES.read_text().splitlines()]
    return [(row["program"], Outcome(_tuples(row.get("items", [])), row.get("refused"))) for row in rows]


def _tuples(value: Any) -> Any:
    return value if not isinstance(value, list) else [tuple(_tuple(each) for each in item) for item in value]


def _tuple(value: Any) -> Any:
    return tuple(map(_tuple, value)) if isinstance(value, list) else value


def different(text: str, theirs: Outcome) -> list[str]:
    program = text.encode()
    return differences(outcome_of(read_program(program), program), theirs)


@pytest.fixture(scope="module")
def reference(tmp_path_factory: pytest.TempPathFactory) -> Reference:
    if not is_here():
        pytest.skip("there is no rs274 here")
    return Reference(tmp_path_factory.mktemp("linuxcnc"))


def test_what_linuxcnc_made_of_programs() -> None:
    rows = stored()
    assert len(rows) > 500
    assert sum(outcome.refused is not None for _, outcome in rows) > 200
    assert [(text, found) for text, outcome in rows if (found := different(text, outcome))] == []


def test_a_difference_is_found() -> None:
    wrong = {"G1 F100 X10\nM2\n": "G1 F100 X10.00001\nM2\n", "G0 X1\nM2\n": "G0 X\nM2\n"}
    for text, other in wrong.items():
        theirs = outcome_of(read_program(other.encode()), other.encode())
        assert different(text, theirs)


@pytest.mark.long
def test_linuxcnc_still_makes_the_same(reference: Reference) -> None:
    changed = []
    for text, outcome in stored()[::EACH]:
        now = reference.read(text.encode())
        if found := differences(now, outcome):
            changed.append((text, found))
    assert changed == []


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
        text = chance_programs.program(seed, rare=(0.005, 0.1)[seed % 4 == 0]).encode()
        program = read_program(text)
        refused += bool(program.problems)
        if what := differences(outcome_of(program, text), reference.read(text)):
            found[seed] = what
    assert found == {}
    assert 0.2 < refused / PROGRAMS < 0.7
