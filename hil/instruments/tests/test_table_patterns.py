"""Patterns of commands: what fits, what does not, and how long it takes to know."""

import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.instruments.check_sums import CheckSum
from hil.instruments.command_cuts import CommandCutter, Cuts
from hil.instruments.patterns import Found, Match, PatternRefused, SlotKind, match, read_pattern

KINDS = {
    "level_V": SlotKind("number"),
    "n": SlotKind("whole"),
    "on": SlotKind("switch"),
    "mode": SlotKind("choice", ("CC", "CV", "CVX")),
    "label": SlotKind("text"),
    "address": SlotKind("whole"),
}


def found(pattern: str, text: str, *, has_cases: bool = True, is_hex: bool = False) -> Found | None:
    made = read_pattern(pattern, KINDS.get, has_cases=has_cases, is_hex=is_hex)
    fit = match(made, text, 0, lambda slot, given: 7.0)
    return fit.found if isinstance(fit, Match) and fit.end == len(text) else None


@pytest.mark.parametrize(
    ("pattern", "text", "values"),
    [
        ("V{n}:{level_V}", "V1:-2.5e-3", {"n": 1.0, "level_V": -0.0025}),
        ("V{n}:{level_V}", "V1:.5", {"n": 1.0, "level_V": 0.5}),
        ("V{n}:{level_V}", "V1:", None),
        ("SET {on}", "SET   1", {"on": 1.0}),
        ("SET {on}", "SET1", None),
        ("SET {on:OFF|ON}", "SET ON", {"on": 1.0}),
        ("MODE {mode}!", "MODE CVX!", {"mode": 2.0}),
        ("MODE {mode}!", "MODE CV!", {"mode": 1.0}),
        ("#{n:02d}{level_V}", "#0312.5", {"n": 3.0, "level_V": 12.5}),
        ("#{n:02X}", "#fF", {"n": 255.0}),
        ("#{n:02d}", "#3", None),
        ("T {label};", "T a b;", {"label": "a b"}),
        ("T {label}", "T ", None),
        ("{{{n}}}", "{5}", {"n": 5.0}),
        ("@{=address:02d}?", "@07?", {}),
        ("@{=address:02d}?", "@08?", None),
        ("V {level_V}", "V 1234567890123456", None),
    ],
)
def test_what_fits(pattern: str, text: str, values: Found | None) -> None:
    seen = found(pattern, text)
    if values is not None and seen is not None:
        seen = {name: value for name, value in seen.items() if name != "address"}
    assert seen == values


def test_small_letters_and_bytes() -> None:
    assert found("Set {on:off|on}", "sEt oN", has_cases=False) == {"on": 1.0}
    assert found("FF {n} {on}", "\xff\x02\x01", is_hex=True) == {"n": 2.0, "on": 1.0}
    assert found("02 {n:2} {n:2le}", "\x02\x01\x02\x01\x02", is_hex=True) == {"n": 513.0}


@pytest.mark.parametrize(
    ("pattern", "why"),
    [
        ("V{n", "a { has no }"),
        ("V}", "a } has no {"),
        ("V{no}", 'there is no variable "no"'),
        ("V{n}{level_V}", "nothing says where {n} ends and {level_V} begins"),
        ("V{n}5", "{n} takes the '5' after it"),
        ("V{n:q}", "'q' is no format of n"),
        ("V{label:.3f}", "'.3f' is no format of label"),
        ("V{on:ON|ON}", "two words of {on:ON|ON} are alike, or empty"),
        ("V{n + 1}", "{n + 1} is no place for a value"),
    ],
)
def test_what_is_no_pattern(pattern: str, why: str) -> None:
    with pytest.raises(PatternRefused) as refused:
        read_pattern(pattern, KINDS.get)
    assert str(refused.value) == why


@given(st.text(max_size=40), st.sampled_from(["{level_V}", "A{label}B{label}C", "{n}  {mode}", "{on}{=n}"]))
def test_any_text_fits_or_does_not(text: str, pattern: str) -> None:
    found(pattern, text)


def test_the_time_grows_with_the_length_alone() -> None:
    pattern = "{label}" + "".join(f"a{{label}}b{{n}}{end}" for end in "cdefgh")
    taken = []
    for length in (10_000, 40_000):
        text = ("ab" * length)[:length] + "0" * length
        begin = time.process_time()
        for _ in range(5):
            found(pattern, text)
        taken.append(time.process_time() - begin)
    assert taken[1] < 12 * taken[0] + 0.05


def test_check_sums() -> None:
    assert (
        CheckSum("crc16", is_hex=False).of("\x01\x03\x00\x00\x00\x0a") == "\xc5\xcd"
    )  # Modbus: 01 03 .. C5 CD
    assert CheckSum("xor", is_hex=True).of("AB") == "03"
    assert CheckSum("sum", is_hex=True).of("AB") == "83"
    for kind in ("xor", "sum", "crc16"):
        for is_hex in (False, True):
            check = CheckSum(kind, is_hex)
            assert check.checked("R1" + check.of("R1")) == "R1"
            assert check.checked("R2" + check.of("R1")) is None
            assert check.checked("") is None


def commands(cuts: Cuts, text: str) -> list[str]:
    cutter = CommandCutter(cuts)
    return [line for byte in text if (line := cutter.feed(byte)) is not None]


def test_where_a_command_ends() -> None:
    assert commands(Cuts(("\r", "\n")), "a\r\nb\n") == ["a", "", "b"]
    assert commands(Cuts(("\n", "\r\n")), "a\r\nb\nc") == ["a", "b"]
    assert commands(Cuts(("\r\n",)), "a\rb\r\n") == ["a\rb"]
    assert commands(Cuts(size=3, begins="\xff"), "x\xff\x01\x00\x01\xff\x02\x01") == [
        "\xff\x01\x00",
        "\xff\x02\x01",
    ]
    assert commands(Cuts(("\r\n",), longest=4), "0123456789\r\nab\r\n")[1] == "ab"
