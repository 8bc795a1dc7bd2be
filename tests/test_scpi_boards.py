"""A board by a table with SCPI's forms: common commands, status registers, the queue of errors."""

from pathlib import Path

import pytest

from hil.testing import Bench

TABLE = """
name: source
title: Source
uarts: {main: {baud: 9600}}
dialogue:
  scpi: true
  queue: 4
  variables:
    level_V: {unit: V, value: 1, minimum: 0, maximum: 10, about: level}
    output: {type: switch, about: output}
    way: {type: choice, choices: [CV, CC], about: way}
    address: {type: whole, value: 1, minimum: 0, maximum: 30, kept: true, about: address}
    load_ohm: {unit: ohm, value: 5, minimum: 1, maximum: 9, input: true, about: load}
  commands:
    - {asks: "VOLTage {level_V}", when: "way == 'CV'"}
    - {asks: "VOLTage?", answers: "{level_V:.2f}"}
    - {asks: "OUTPut {output}"}
    - {asks: "WAY {way}"}
    - {asks: "ADDRess {address}"}
    - {asks: "ADDRess?", answers: "{address}"}
    - {asks: "*TST?", answers: "1"}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "source").mkdir()
    (tmp_path / "source/profile.yaml").write_text(TABLE)
    return tmp_path


def made(folder: Path, **device: object) -> Bench:
    return Bench(
        {"bench": "t", "profile_path": [str(folder)], "devices": {"s1": {"profile": "source", **device}}}
    )


def asked(bench: Bench, *lines: str) -> list[str]:
    """Answers to all lines."""
    for line in lines:
        bench.port("s1").write(line.encode() + b"\n")
        bench.run(ms=100)
    return bench.port("s1").read().decode().splitlines()


@pytest.mark.parametrize(
    ("typed", "number", "bit"),
    [
        ("VOLTA 5", -113, 32),
        ("VOLT", -109, 32),
        ("VOLT 5,6", -108, 32),
        ("VOLT 5 A", -131, 32),
        ("VOLT up", -104, 32),
        ("OUTP maybe", -224, 16),
        ("WAY CW", -224, 16),
        ("VOLT 11", -222, 16),
        ("*ESE 256", -222, 16),
        ("*ESE", -109, 32),
        ("VOLT? 5", -108, 32),
    ],
)
def test_an_error_waits_and_sets_its_bit(folder: Path, typed: str, number: int, bit: int) -> None:
    with made(folder) as bench:
        said, status = asked(bench, "*CLS", typed, "SYST:ERR?;ERR?", "*STB?;*ESR?")
        assert said.startswith(f'{number},"')
        assert said.endswith(';0,"No error"')
        assert status == f"0;{bit}"


def test_a_condition_that_does_not_hold(folder: Path) -> None:
    with made(folder) as bench:
        assert asked(bench, "WAY CC;VOLT 2;:SYST:ERR?") == ['-221,"Settings conflict"']


def test_power_on_and_what_is_enabled(folder: Path) -> None:
    with made(folder) as bench:
        assert asked(bench, "*ESR?", "*ESE 36;*SRE 32", "*ESE?;*SRE?") == ["128", "36;32"]
        assert asked(bench, "nonsense", "*STB?", "*CLS;*STB?") == ["100", "0"]
        assert asked(bench, "*OPC;*ESR?", "*OPC?;*WAI;*TST?") == ["1", "1;1"]
        bench.device("s1").reset()
        assert asked(bench, "*ESE?;*SRE?;*ESR?") == ["0;0;128"]


def test_an_answer_that_waits_is_in_the_status_byte(folder: Path) -> None:
    with made(folder) as bench:
        assert asked(bench, "VOLT?;*STB?") == ["1.00;16"]


def test_a_reset_is_as_after_power_up(folder: Path) -> None:
    """Check that first values, values of the world and those kept without power are as they were."""
    with made(folder, fields={"level_V": 3}) as bench:
        bench.axis("s1").set("load_ohm", 7)
        assert asked(bench, "VOLT 5;OUTP ON;ADDR 9;WAY CC", "*RST;VOLT?;ADDR?") == ["3.00;9"]
        state = bench.axis("s1").snapshot()
        assert (state.output, state.way, state.load_ohm) == (0, 0, 7)


def test_who_it_is(folder: Path) -> None:
    with made(folder) as bench:
        assert asked(bench, "*idn?", "SYSTem:VERSion?") == ["hil,source,0,0", "1999.0"]


def test_a_semicolon_too_many_is_nothing(folder: Path) -> None:
    with made(folder) as bench:
        assert asked(bench, "VOLT 5;;VOLT?;", "SYST:ERR?", ";") == ["5.00", '0,"No error"']


def test_a_full_queue(folder: Path) -> None:
    with made(folder) as bench:
        asked(bench, *["X"] * 6)
        errors = asked(bench, *["SYST:ERR?"] * 5)
        assert errors == ['-113,"Undefined header"'] * 3 + ['-350,"Queue overflow"', '0,"No error"']
