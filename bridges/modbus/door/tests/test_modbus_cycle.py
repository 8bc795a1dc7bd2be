"""``hil modbus cycle``: what it prints, for people and programs, and what it refuses."""

import json

import pytest
from typer.testing import CliRunner

from bridges.modbus.cli import app


def run(*words: str, code: int = 0) -> str:
    result = CliRunner().invoke(app, ["cycle", *words])
    assert result.exit_code == code, result.output
    return result.output


def test_a_cycle_for_people() -> None:
    assert run("1-2:4:10", "0:6", "--baud", "9600", "--format", "8N1").splitlines() == [
        "9600 baud 8N1: t1.5 1.562 ms, t3.5 3.646 ms",
        "unit  function  count  start ms  request ms  wait ms  answer ms  silence ms",
        "   1         4     10     0.000       8.333    4.646     26.042       3.646",
        "   2         4     10    42.667       8.333    4.646     26.042       3.646",
        "   0         6      1    85.333       8.333  100.000      0.000       0.000",
        "cycle 193.667 ms, 15.5 polls/s, 5.16 cycles/s, load 39.8%",
    ]


def test_a_cycle_for_programs() -> None:
    said = json.loads(run("7:3:2", "--json", "--response-ms", "0", "--pause-ms", "1"))
    (poll,) = said["polls"]
    assert (said["t3_5_ns"], said["format"], poll["unit"], poll["answer_bytes"]) == (2005208, "8E1", 7, 9)
    parts = ("request_ns", "wait_ns", "answer_ns", "silence_ns")
    assert said["cycle_ns"] == sum(poll[part] for part in parts)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("1",), "1: write UNIT:FUNCTION or UNIT:FUNCTION:COUNT, as in 1:4:10 or 1-32:4:10"),
        (("1:4:x",), "1:4:x: write UNIT"),
        (("1:4:1:1",), "1:4:1:1: write UNIT"),
        (("9-3:4",), "9-3:4: 9 comes after 3"),
        (("1-300:4",), "1-300:4: unit 248: write 1 to 247"),
        (("1:8",), "1:8: function 8: write one of 1, 2, 3"),
        (("1:4:0",), "1:4:0: count 0: function 4 takes 1 to 125"),
        (("1:4", "--format", "7E1"), "--format 7E1: formats are 8N1, 8E1, 8O1, 8N2"),
    ],
)
def test_what_it_refuses(words: tuple[str, ...], said: str) -> None:
    assert f"hil: {said}" in run(*words, code=2)
