"""The Print and Stream formats of the Arduino SAMD core 1.6.20, to the last digit and the last bit.

A 2018 core: ``long`` and ``int`` have 32 bits, ``float`` arithmetic is IEEE single, ``print`` of a
``float`` promotes it to double first.
"""

import math
import struct
from collections.abc import Generator
from typing import Any

from hil.vocab.firmware import ByteAvailable, Request, Uart
from hil.vocab.time import NS_PER_S

STREAM_TIMEOUT_NS = NS_PER_S
"""The core's default time-out for each awaited byte (``Stream::setTimeout``)."""

_LARGEST_PRINTED = 4_294_967_040.0  # the largest single below 2**32
_DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ"
_ASCII_DIGITS = frozenset(b"0123456789")
_MINUS, _POINT = b"-."
_NUMBER_STARTS = _ASCII_DIGITS | {_MINUS, _POINT}
_IGNORED = 0x01  # the core's "ignore nothing" mark is itself a byte that numbers may contain


def float32(x: float) -> float:
    """Round ``x`` to the nearest IEEE single, as a double; too large becomes an infinity."""
    try:
        rounded: float = struct.unpack("<f", struct.pack("<f", x))[0]
    except OverflowError:
        return math.copysign(math.inf, x)
    return rounded


def print_float(value: float, digits: int = 2) -> str:
    """Format as ``Print::print(double, digits)``. Pass a firmware's ``float`` through ``float32`` first."""
    if math.isnan(value):
        return "nan"
    if math.isinf(value):
        return "inf"  # the sign is lost, as on the board
    if abs(value) > _LARGEST_PRINTED:
        return "ovf"
    rounding = 0.5
    for _ in range(digits):
        rounding /= 10.0
    magnitude = abs(value) + rounding
    whole = int(magnitude)
    text = f"-{whole}" if value < 0.0 else str(whole)
    if digits == 0:
        return text
    decimals = []
    remainder = magnitude - whole
    for _ in range(digits):
        remainder *= 10.0
        digit = int(remainder)
        decimals.append(str(digit))
        remainder -= digit
    return f"{text}.{''.join(decimals)}"


def print_int(value: int, base: int = 10) -> str:
    """Format as ``Print::print(long, base)``, base 2 to 36: signed in base 10, as 32-bit unsigned in others.

    Raises:
        ValueError: there are no digits for the base.
    """
    if not 2 <= base <= len(_DIGITS):
        raise ValueError(f"base {base} is not in 2 to {len(_DIGITS)}")
    if base == 10:
        return str(_wrap32(value))
    rest = value & 0xFFFF_FFFF
    text = _DIGITS[rest % base]
    while rest >= base:
        rest //= base
        text = _DIGITS[rest % base] + text
    return text


def parse_float(uart: Uart, timeout_ns: int = STREAM_TIMEOUT_NS) -> Generator[Request, Any, float]:
    """Parse the next number of the input as ``Stream::parseFloat()``, as a single.

    ``timeout_ns`` counts again for each awaited byte; a time-out ends the number (0.0 if none has begun). The
    byte that ends the number stays held by ``peek``: ``available`` does not count it.
    """
    byte = yield from _timed_peek(uart, timeout_ns)
    while byte >= 0 and byte not in _NUMBER_STARTS:
        uart.read()
        byte = yield from _timed_peek(uart, timeout_ns)

    negative = byte == _MINUS
    if negative:
        uart.read()
        byte = yield from _timed_peek(uart, timeout_ns)

    value = 0
    fraction = 1.0
    after_point = False
    while byte in _ASCII_DIGITS or byte == _IGNORED or (byte == _POINT and not after_point):
        if byte == _POINT:
            after_point = True
        elif byte != _IGNORED:
            value = _wrap32(value * 10 + byte - ord("0"))
            if after_point:
                fraction = float32(fraction * 0.1)
        uart.read()
        byte = yield from _timed_peek(uart, timeout_ns)
    return float32(float32(_wrap32(-value if negative else value)) * fraction)


def _timed_peek(uart: Uart, timeout_ns: int) -> Generator[Request, Any, int]:
    # The held byte is not in the buffer, so that waiting before peeking would wait for one too many.
    byte = uart.peek()
    if byte < 0 and (yield ByteAvailable(timeout_ns)):
        byte = uart.peek()
    return byte


def _wrap32(value: int) -> int:
    return (value + 0x8000_0000) % 0x1_0000_0000 - 0x8000_0000
