import ctypes
import json
import math
import struct
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.firmware.arduino import STREAM_TIMEOUT_NS, float32, parse_float, print_float, print_int
from hil.firmware.runtime import RxBuffer
from hil.vocab.firmware import ByteAvailable
from hil.vocab.time import NS_PER_MS

REFERENCE: dict[str, Any] = json.loads((Path(__file__).parent / "data" / "arduino_formats.json").read_text())


def single(bits: str) -> float:
    value: float = struct.unpack(">f", bytes.fromhex(bits))[0]
    return value


class Line(RxBuffer):
    """A receive buffer that bytes reach at set times; nothing is sent."""

    def __init__(self, arrivals: list[tuple[int, bytes]]) -> None:
        super().__init__(4096)
        self.now_ns = 0
        self._arrivals = arrivals
        self._deliver()

    def write(self, data: bytes) -> None:
        raise AssertionError("parse_float sends nothing")

    def wait(self, request: ByteAvailable) -> bool:
        assert request.timeout_ns is not None
        until_ns = self.now_ns + request.timeout_ns
        if not self.available():
            next_ns = self._arrivals[0][0] if self._arrivals else until_ns
            self.now_ns = min(next_ns, until_ns)
            if next_ns < until_ns:
                self._deliver()
        return self.available() > 0

    def _deliver(self) -> None:
        while self._arrivals and self._arrivals[0][0] <= self.now_ns:
            self.feed(self._arrivals.pop(0)[1])

    def parse(self) -> float:
        parser = parse_float(self)
        try:
            request = next(parser)
            while True:
                assert isinstance(request, ByteAvailable)
                request = parser.send(self.wait(request))
        except StopIteration as end:
            value: float = end.value
            return value


@pytest.mark.parametrize(("bits", "digits", "text"), REFERENCE["print_float"])
def test_a_float_prints_as_the_core_prints_it(bits: str, digits: int, text: str) -> None:
    assert print_float(single(bits), digits) == text


@pytest.mark.parametrize(("value", "base", "text"), REFERENCE["print_int"])
def test_an_int_prints_as_the_core_prints_it(value: int, base: int, text: str) -> None:
    assert print_int(value, base) == text


@pytest.mark.parametrize(("text", "bits", "taken", "held", "elapsed_ms"), REFERENCE["parse_float"])
def test_a_number_is_parsed_as_the_core_parses_it(
    text: str, bits: str, taken: int, held: int, elapsed_ms: int
) -> None:
    data = text.encode("latin-1")
    line = Line([(0, data)])
    assert struct.pack(">f", line.parse()).hex() == bits
    assert len(data) - line.available() == taken
    assert line.now_ns == elapsed_ms * NS_PER_MS
    # Nothing is held only after a time-out; the buffer is empty then, and peek has nothing to take.
    assert line.peek() == held


def test_the_largest_value_that_prints_is_the_largest_single_below_two_to_the_32() -> None:
    assert print_float(4294967040.0, 0) == "4294967040"
    assert print_float(math.nextafter(4294967040.0, math.inf), 0) == "ovf"


@pytest.mark.parametrize("base", [-2, 0, 1, 37])
def test_a_base_without_digits_is_refused(base: int) -> None:
    with pytest.raises(ValueError, match="base"):
        print_int(1, base)


@given(st.integers(-(2**31), 2**31 - 1), st.integers(2, 36))
def test_every_int_reads_back(value: int, base: int) -> None:
    expected = value if base == 10 else value % 2**32
    assert int(print_int(value, base), base) == expected


@given(st.floats())
def test_float32_is_the_conversion_to_float_of_c(x: float) -> None:
    assert struct.pack("d", float32(x)) == struct.pack("d", ctypes.c_float(x).value) or math.isnan(x)
    assert math.isnan(float32(x)) == math.isnan(x)


@given(st.floats(-1e6, 1e6, width=32), st.integers(0, 9))
def test_a_printed_float_is_near_its_value(value: float, digits: int) -> None:
    text = print_float(value, digits)
    assert abs(float(text) - value) <= 0.5 * 10.0**-digits + 1e-9
    assert len(text.partition(".")[2]) == digits


@given(
    st.text(alphabet="-.0123456789 \r\nx\x01", max_size=20),
    st.lists(st.integers(0, STREAM_TIMEOUT_NS - 1), min_size=20, max_size=20),
)
def test_the_value_does_not_depend_on_when_the_bytes_come(text: str, gaps_ns: list[int]) -> None:
    data = text.encode("latin-1")
    at_ns = 0
    arrivals = []
    for byte, gap_ns in zip(data, gaps_ns, strict=False):
        at_ns += gap_ns
        arrivals.append((at_ns, bytes([byte])))
    together, apart = Line([(0, data)]), Line(arrivals)
    assert together.parse() == apart.parse()
    timed_out = together.now_ns == STREAM_TIMEOUT_NS
    assert timed_out == (apart.now_ns - STREAM_TIMEOUT_NS == at_ns)


def test_a_byte_at_the_very_end_of_the_time_out_is_too_late() -> None:
    assert Line([(0, b"12"), (STREAM_TIMEOUT_NS - 1, b"3\n")]).parse() == 123.0
    assert Line([(0, b"12"), (STREAM_TIMEOUT_NS, b"3\n")]).parse() == 12.0


def test_the_held_byte_is_the_first_of_the_next_number() -> None:
    line = Line([(0, b"5-3.25x")])
    assert [line.parse(), line.parse()] == [5.0, -3.25]
    assert (line.available(), line.read()) == (0, ord("x"))
