"""Characters of all formats on a line: read as they were sent, and spoiled ones known by their parity."""

import pytest

from hil.vocab.line_format import FORMATS, LineFormat
from hil.wire.serial_line import character_ns, resample
from virtual_ports.rs485.waveform import Driving, low_line, read

BAUD = 19200
ALL = bytes(range(256))
each_format = pytest.mark.parametrize("form", FORMATS.values(), ids=FORMATS)


@each_format
def test_a_character_has_its_levels(form: LineFormat) -> None:
    assert len(form.levels(0x53)) == form.bits == 9 + form.has_parity + form.stop_bits
    assert form.levels(0x53)[:9] == (0, 1, 1, 0, 0, 1, 0, 1, 0)
    assert form.levels(0x53)[-form.stop_bits :] == (1,) * form.stop_bits
    parity = {"E": 0, "O": 1}  # 53h has four bits that are 1
    assert not form.has_parity or form.levels(0x53)[9] == parity[form.parity]


@each_format
@pytest.mark.parametrize("read_baud", [BAUD, 19000, 19400])
def test_what_is_sent_is_read_at_about_its_speed(form: LineFormat, read_baud: int) -> None:
    sampled = resample(ALL, BAUD, read_baud, form)
    assert bytes(each.byte for each in sampled) == ALL
    assert not any(each.framing_error or each.parity_error for each in sampled)


@each_format
def test_a_driven_line_reads_as_what_drives_it(form: LineFormat) -> None:
    end_ns = character_ns(256, BAUD, form.bits)
    lows = low_line([Driving(0, ALL, BAUD, 0, end_ns)], 0, end_ns, form)
    characters, _ = read(lows, BAUD, 0, end_ns, end_ns, form)
    assert bytes(each.byte for each in characters) == ALL
    assert [each.at_ns for each in characters] == pytest.approx(
        [character_ns(at + 1, BAUD, form.bits) for at in range(256)], abs=1
    )
    assert not any(each.is_framing_error or each.is_parity_error for each in characters)


@pytest.mark.parametrize("name", ["8E1", "8O1"])
def test_a_line_of_the_other_parity_reads_as_parity_errors(name: str) -> None:
    form, other = FORMATS[name], FORMATS["8O1" if name == "8E1" else "8E1"]
    end_ns = character_ns(256, BAUD, form.bits)
    lows = low_line([Driving(0, ALL, BAUD, 0, end_ns)], 0, end_ns, form)
    characters, _ = read(lows, BAUD, 0, end_ns, end_ns, other)
    assert all(each.is_parity_error for each in characters)
    assert bytes(each.byte for each in characters) == ALL


def test_characters_of_two_speeds_have_parity_errors() -> None:
    sampled = resample(ALL, BAUD, BAUD * 3 // 4, FORMATS["8E1"])
    assert any(each.parity_error for each in sampled)
