"""Numbers as the board has them: float32, and C's conversions of text, and text of numbers."""

import math
import re
from struct import pack, unpack

_DECIMAL = re.compile(r"[ \t\n\v\f\r]*([+-]?)(?:(\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)")
_HEX = re.compile(
    r"[ \t\n\v\f\r]*([+-]?)0[xX](?:[0-9a-fA-F]+\.?[0-9a-fA-F]*|\.[0-9a-fA-F]+)(?:[pP][+-]?\d+)?"
)
_WORD = re.compile(r"[ \t\n\v\f\r]*([+-]?)(infinity|inf|nan)", re.I)
_INTEGER = re.compile(r"[ \t\n\v\f\r]*([+-]?\d+)")
_LONG = 2**31
_TENTH = unpack("f", pack("f", 0.1))[0]
"""A digit's place as the board's library has it."""
_MOST_PRINTED = 4294967040.0


def f32(x: float) -> float:
    """Round to float32. The sum, difference, product or quotient of two, rounded so, is the board's."""
    try:
        value: float = unpack("f", pack("f", x))[0]
    except OverflowError:
        return math.copysign(math.inf, x)
    return value


def real_of(text: str) -> float:
    """Convert as ``atof``, to float32: the longest number that the text begins with, else 0."""
    if found := _HEX.match(text):
        try:
            return f32(float.fromhex(found.group().strip()))
        except OverflowError:
            return -math.inf if found.group(1) == "-" else math.inf
    if found := _WORD.match(text) or _DECIMAL.match(text):
        return f32(float(found.group()))
    return 0.0


def long_of(text: str) -> int:
    """Convert as ``atoi`` of a processor with 32 bits: leading digits, else 0."""
    found = _INTEGER.match(text)
    return max(-_LONG, min(_LONG - 1, int(found.group(1)))) if found else 0


def int16_of(text: str) -> int:
    """Convert as ``atoi`` into 16 bits: what is too large is cut."""
    return ((long_of(text) + 0x8000) & 0xFFFF) - 0x8000


def unsigned16_of(value: float) -> int:
    """Convert a float to 16 bits without sign, as the processor does: cut and saturated to 32 bits first."""
    if math.isnan(value) or value <= 0:
        return 0
    return int(min(value, 2.0**32 - 1)) & 0xFFFF


def real_text(x: float, decimals: int = 2) -> str:
    """Text of a number as the board's library prints it."""
    if math.isnan(x):
        return "nan"
    if math.isinf(x):
        return "inf"
    if abs(x) > _MOST_PRINTED:
        return "ovf"
    sign, rest = "-" if x < 0 else "", abs(x)
    rounding = 0.5
    for _ in range(decimals):
        rounding *= _TENTH
    rest += rounding
    whole = int(rest)
    rest -= whole
    digits = ""
    for _ in range(decimals):
        rest *= 10.0
        digits += str(int(rest))
        rest -= int(rest)
    return f"{sign}{whole}.{digits}"
