"""Commands in the forms of SCPI."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.instruments.patterns import Found, PatternRefused, SlotKind
from hil.instruments.scpi import factor_of, read_command, read_typed, split

KINDS = {
    "level_V": SlotKind("number"),
    "n": SlotKind("whole"),
    "on": SlotKind("switch"),
    "label": SlotKind("text"),
}


def fit(asks: str, typed: str) -> Found | bool:
    command = read_command(asks, KINDS.get, {"level_V": "V"})
    unit, _ = read_typed(typed, ())
    return command.fit(unit, lambda slot, found: None)


@pytest.mark.parametrize(
    ("asks", "typed", "found"),
    [
        ("[SOURce:]VOLTage[:LEVel] {level_V}", "volt 5", {"level_V": 5.0}),
        ("[SOURce:]VOLTage[:LEVel] {level_V}", ":SOURCE:Voltage:lev 5", {"level_V": 5.0}),
        ("[SOURce:]VOLTage[:LEVel] {level_V}", "SOUR:VOLT 500 mV", {"level_V": 0.5}),
        ("[SOURce:]VOLTage[:LEVel] {level_V}", "VOLT MAX", {"level_V": "MAXIMUM"}),
        ("[SOURce:]VOLTage[:LEVel] {level_V}", "VOLT 5 A", True),
        ("[SOURce:]VOLTage[:LEVel] {level_V}", "VOLT 5,6", True),
        ("[SOURce:]VOLTage[:LEVel] {level_V}", "VOLT", True),
        ("[SOURce:]VOLTage[:LEVel] {level_V}", "VOLTA 5", False),
        ("[SOURce:]VOLTage[:LEVel] {level_V}", "VOLT? 5", False),
        ("VOLTage? MAXimum", "VOLT? max", {}),
        ("VOLTage? MAXimum", "VOLT? min", True),
        ("OUTPut{n} {on}", "OUTP2 ON", {"n": 2.0, "on": 1.0}),
        ("OUTPut{n} {on}", "OUTP off", {"n": 1.0, "on": 0.0}),
        ("OUTPut CH{n},{on}", "outp ch3 , 1", {"n": 3.0, "on": 1.0}),
        ("*IDN?", "*idn?", {}),
        ("DISPlay {label}", 'DISP "a,b;c"', {"label": '"a,b;c"'}),
    ],
)
def test_what_fits(asks: str, typed: str, found: Found | bool) -> None:
    assert fit(asks, typed) == found


def test_a_line_goes_on_where_its_command_before_ended() -> None:
    assert split('VOLT 1;DISP "a;b"; :OUTP ON', ";") == ["VOLT 1", 'DISP "a;b"', ":OUTP ON"]
    first, path = read_typed("MEAS:VOLT?", ())
    common, path = read_typed("*WAI", path)
    after, path = read_typed("CURR?", path)
    root, _ = read_typed(":OUTP?", path)
    assert [each.words for each in (first, common, after, root)] == [
        ("MEAS", "VOLT"),
        ("*WAI",),
        ("MEAS", "CURR"),
        ("OUTP",),
    ]


def test_units() -> None:
    assert [factor_of(each, "V") for each in ("V", "MV", "KV", "XV", "", "A")] == [
        1,
        1e-3,
        1e3,
        None,
        None,
        None,
    ]
    assert factor_of("MHZ", "HZ") == 1e6


@pytest.mark.parametrize(
    "asks", ["[SOURce]", "VOLT[:A[:B]]", "VOLT]", ":", "A{m}", "[A:][B:][C:][D:][E:][F:][G:]H"]
)
def test_what_is_no_command(asks: str) -> None:
    with pytest.raises(PatternRefused):
        read_command(asks, KINDS.get, {})


@given(st.text(max_size=60))
def test_any_line_is_read(line: str) -> None:
    path: tuple[str, ...] = ()
    for each in split(line, ";"):
        unit, path = read_typed(each, path)
        assert isinstance(fit("VOLTage{n}:A {level_V}", each), bool | dict), unit
