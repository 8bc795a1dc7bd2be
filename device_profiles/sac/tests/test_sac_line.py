"""Numbers and motion commands, for any input."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from device_profiles.sac.eeprom import SIZE, Eeprom, EepromError
from device_profiles.sac.parameters import BY_LETTER, Parameters, change
from device_profiles.sac.typed_text import NO_RAMP, Text, from_cycle, from_rpm, read_attributes
from hil.vocab.motion import MotionEntry

START = Parameters().default_entry()
RAMPS = Parameters().ramp
LATIN_1 = st.text(st.characters(max_codepoint=255), max_size=80)
CODED = st.text("mMvVcCaAdDlLuUtTfFpPsS0123456789.-x²", max_size=80)


@given(st.integers(0, 10**30))
def test_a_number_holds_32_bits(number: int) -> None:
    assert Text(str(number)).number() == number % 2**32


@given(st.integers(0, 99), st.text("0123456789", max_size=9))
def test_two_decimals_below_100(whole: int, decimals: str) -> None:
    shown = f"{whole}.{decimals}"
    assert Text(shown).hundredths() == int(f"{whole}{(decimals + '00')[:2]}")


@given(st.integers(100, 2**32 - 1), st.text("0123456789", max_size=9))
def test_no_decimals_from_100_on_and_999_is_the_end(whole: int, decimals: str) -> None:
    assert Text(f"{whole}.{decimals}").hundredths() == min(whole * 100, NO_RAMP)


@given(LATIN_1 | CODED)
def test_whatever_is_typed_gives_an_entry_that_the_memory_can_hold(typed: str) -> None:
    for with_steps in (False, True):
        said = read_attributes(Text(typed), 200, with_steps=with_steps)
        entry = said.apply(START, RAMPS)
        assert 0 <= entry.steps < 2**32
        assert 0 <= entry.rpm < 2**32
        assert 2 <= entry.cycle_us < 2**32
        assert 0 <= entry.acc_hundredths <= NO_RAMP
        assert 0 <= entry.dec_hundredths <= NO_RAMP
        assert 0 <= entry.extra_pulses < 256
        assert 0 <= entry.wait_us < 2**32
        eeprom = Eeprom(queue=[entry] * 30)
        assert Eeprom.unpacked(eeprom.packed()) == eeprom


ATTRIBUTES = {
    "v": "v120",
    "a": "a.8",
    "d": "d1.25",
    "l": "l1",
    "u": "u300",
    "t": "t5000",
    "p": "p",
    "s": "s",
}


@given(st.permutations(list(ATTRIBUTES.values())))
def test_attributes_come_in_any_order(order: list[str]) -> None:
    entry = read_attributes(Text("".join(order)), 200).apply(START, RAMPS)
    assert entry == MotionEntry(
        steps=200,
        is_ccw=False,
        rpm=120,
        cycle_us=2500,
        acc_hundredths=80,
        dec_hundredths=125,
        is_linear=True,
        extra_pulses=44,
        is_sync=True,
        wait_us=5000,
        is_pulses=True,
    )


@pytest.mark.parametrize(("line", "acc", "dec"), [("al1", 3, 4), ("l1a", 3, 4), ("dal1", 3, 4), ("a", 1, 9)])
def test_a_bare_a_or_d_is_the_default_of_the_lines_own_ramp(line: str, acc: int, dec: int) -> None:
    start = replace(START, acc_hundredths=8, dec_hundredths=9)
    entry = read_attributes(Text(line), 200).apply(
        start, Parameters(acc=1, dec=2, linear_acc=3, linear_dec=4).ramp
    )
    assert (entry.acc_hundredths, entry.dec_hundredths) == (acc, dec)


@given(st.integers(1, 2**32 - 1), st.integers(0, 65535))
def test_velocities_never_fall_below_the_drivers_period(number: int, steps_per_rev: int) -> None:
    assert from_rpm(number, steps_per_rev).cycle_us >= 2
    velocity = from_cycle(number, steps_per_rev)
    assert velocity.cycle_us == max(number, 2)
    assert velocity.rpm == 60_000_000 // max(steps_per_rev, 1) // velocity.cycle_us


@given(st.lists(st.tuples(st.sampled_from([*BY_LETTER, "u", "U", "?"]), LATIN_1 | CODED), max_size=6))
def test_any_configuration_survives_the_memory(edits: list[tuple[str, str]]) -> None:
    parameters = Parameters()
    for letter, rest in edits:
        change(parameters, Text(letter + rest))
    eeprom = Eeprom(parameters)
    packed = eeprom.packed()
    assert len(packed) == SIZE
    assert Eeprom.unpacked(packed) == eeprom
    parameters.setup()
    parameters.default_entry()


@given(st.binary(max_size=40) | st.binary(min_size=SIZE, max_size=SIZE))
def test_foreign_bytes_are_no_eeprom(data: bytes) -> None:
    with pytest.raises(EepromError):
        Eeprom.unpacked(data)
