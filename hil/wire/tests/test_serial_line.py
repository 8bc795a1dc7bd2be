from fractions import Fraction
from itertools import pairwise, product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.vocab.line_format import EIGHT_N_1, format_named
from hil.wire.serial_line import Sampled, character_ends_ns, character_ns, resample

EVERY_BYTE = bytes(range(256))
BAUDS = st.integers(50, 4_000_000)


@given(st.integers(0, 10**15), st.integers(0, 40), BAUDS, st.integers(9, 12))
def test_the_ends_of_characters_are_each_rounded_once(
    start_ns: int, count: int, baud: int, bits: int
) -> None:
    one_by_one = [start_ns + character_ns(n + 1, baud, bits) for n in range(count)]
    assert character_ends_ns(start_ns, count, baud, bits) == one_by_one


def bytes_of(sampled: list[Sampled]) -> bytes:
    return bytes(one.byte for one in sampled)


def slow_receiver(data: bytes, sent_baud: int, read_baud: int) -> list[Sampled]:
    """The receiver's rules, followed from edge to edge in fractions of a second."""
    levels = [1]
    for byte in data:
        levels += [0, *((byte >> bit) & 1 for bit in range(8)), 1]
    edges = [Fraction(at, sent_baud) for at, (before, after) in enumerate(pairwise(levels)) if before > after]

    def level(at: Fraction) -> int:
        bit = 1 + at * sent_baud // 1
        return levels[bit] if bit < len(levels) else 1

    sampled = []
    idle_since = Fraction(-1)
    for edge in edges:
        if edge <= idle_since:
            continue
        idle_since = edge + Fraction(1, 2 * read_baud)
        if level(idle_since) == 0:
            bits = [level(edge + Fraction(3 + 2 * bit, 2 * read_baud)) for bit in range(9)]
            byte = sum(bit << place for place, bit in enumerate(bits[:8]))
            sampled.append(Sampled(byte, not bits[8], edge * 10**9 // 1))
            idle_since = edge + Fraction(19, 2 * read_baud)
    return sampled


def test_m_and_carriage_return_at_half_the_receivers_rate() -> None:
    sampled = resample(b"\x6d\x0d", 19_200, 38_400)
    assert bytes_of(sampled).hex(" ").upper() == "E6 9E E6 80"


def test_the_receivers_rate_changes_nothing_within_4_percent() -> None:
    for read_baud in range(96_000, 104_001, 125):
        sampled = resample(EVERY_BYTE, 100_000, read_baud)
        assert bytes_of(sampled) == EVERY_BYTE, read_baud
        assert not any(one.framing_error for one in sampled)


@pytest.mark.parametrize("read_baud", [93_000, 107_000])
def test_7_percent_are_too_much(read_baud: int) -> None:
    assert bytes_of(resample(EVERY_BYTE, 100_000, read_baud)) != EVERY_BYTE


@given(st.binary(max_size=40), BAUDS, st.integers(-4, 4))
def test_bytes_pass_unchanged_between_near_rates(data: bytes, sent_baud: int, percent: int) -> None:
    read_baud = max(1, sent_baud + sent_baud * percent // 100 + (percent < 0))
    sampled = resample(data, sent_baud, read_baud)
    assert sampled == [Sampled(byte, False, character_ns(n, sent_baud)) for n, byte in enumerate(data)]


@given(st.binary(max_size=12), BAUDS, BAUDS)
def test_any_rates_give_what_the_rules_say(data: bytes, sent: int, read: int) -> None:
    assert resample(data, sent, read) == slow_receiver(data, sent, read)


@given(st.binary(max_size=12), st.integers(1, 12), st.integers(1, 12))
def test_small_ratios_give_what_the_rules_say(data: bytes, sent: int, read: int) -> None:
    # Here samples fall on edges.
    assert resample(data, sent, read) == slow_receiver(data, sent, read)


def test_a_long_low_is_a_break() -> None:
    # Nine low bits at 300 baud last 72 bits of the receiver: one start edge, no stop bit.
    assert resample(b"\x00", 300, 2400) == [Sampled(0, True, 0)]


def test_a_short_start_bit_is_a_glitch() -> None:
    assert resample(b"\xff\xff", 115_200, 9_600) == []


def test_nothing_sent_is_nothing_read() -> None:
    assert resample(b"", 9_600, 9_600) == resample(b"", 9_600, 19_200) == []


@pytest.mark.parametrize(("sent", "read"), [(0, 9600), (9600, -1)])
def test_impossible_settings_are_refused(sent: int, read: int) -> None:
    with pytest.raises(ValueError, match="must be"):
        resample(b"x", sent, read)


def test_character_times_do_not_drift() -> None:
    assert [character_ns(n, 115_200) for n in (0, 1, 2, 3)] == [0, 86_805, 173_611, 260_416]
    assert character_ns(11_520, 115_200) == 10**9


@given(st.integers(0, 10**9), BAUDS)
def test_a_character_time_is_exact_to_the_nanosecond(n: int, baud: int) -> None:
    assert 0 <= Fraction(n * 10 * 10**9, baud) - character_ns(n, baud) < 1


NAMES = st.sampled_from(["".join(each) for each in product("5678", "NEOMS", "12")])


@given(st.binary(max_size=20), NAMES, BAUDS, st.integers(-2, 2))
def test_a_format_that_both_have_loses_nothing_but_bits_it_has_not(
    data: bytes, name: str, baud: int, off_pct: int
) -> None:
    line_format = format_named(name)
    assert line_format
    sampled = resample(data, baud * 100, baud * (100 + off_pct), line_format, line_format)
    mask = (1 << line_format.data_bits) - 1
    assert [each.byte & mask for each in sampled] == [byte & mask for byte in data]
    assert not any(each.framing_error or each.parity_error for each in sampled)


@pytest.mark.parametrize(
    ("sent", "read", "data", "heard", "errors"),
    [
        ("7E1", "8N1", b"m", b"\xed", ""),  # five ones: the parity is the eighth bit
        ("7E1", "8N1", b"r", b"r", ""),
        ("7O1", "8N1", b"m", b"m", ""),
        ("8N1", "7E1", b"m", b"m", "p"),
        ("8N1", "7E1", b"r", b"r", ""),
        ("8E1", "8N1", b"m", b"m", ""),
        ("8E1", "8N1", b"r", b"r", "f"),  # the parity is where the stop bit should be
        ("8N1", "8O1", b"m", b"m", "p"),
        ("8N2", "8N1", b"mr", b"mr", ""),
        ("8N1", "8N2", b"mr", b"mr", ""),
        ("5N1", "8N1", b"\x01", b"\xe1", ""),
        ("8S1", "8M1", b"m", b"m", "p"),
    ],
)
def test_what_a_receiver_of_another_format_reads(
    sent: str, read: str, data: bytes, heard: bytes, errors: str
) -> None:
    sampled = resample(data, 9600, 9600, format_named(sent) or EIGHT_N_1, format_named(read))
    assert bytes_of(sampled) == heard
    assert "".join("f" * one.framing_error + "p" * one.parity_error for one in sampled) == errors
