"""Words for people: numbers (0 for what is as good as 0, and no sign before it), doors, echoes of adapters,
and what to type first at a board that says nothing by itself."""

from collections.abc import Mapping
from struct import Struct
from typing import Any

_FLOAT = Struct("f")
DUST = 1e-12
"""Magnitude below which a field's value is 0, whatever its unit: what decays and sums leave."""
EXACT = 1 << 53
"""Magnitude up to which a float has each whole number, as one of nanoseconds."""


def counted(count: int, noun: str) -> str:
    """Format a number of things, as in ``1 device`` and ``2 devices``."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def shown_number(value: float | None, *, is_short: bool = False) -> str:
    """Format a field's value; None is one that is not told. ``is_short``: it is a float of 32 bits, and only
    the digits that tell it from its neighbours count."""
    if value is None:
        return "-"
    if abs(value) < DUST:
        return "0"
    is_whole = float(value).is_integer() and abs(value) < EXACT
    if is_whole or not is_short:
        return str(round(value)) if is_whole else f"{value:.10g}"
    digits = (f"{value:.{count}g}" for count in range(1, 10))
    return next((each for each in digits if _same_float(float(each), value)), f"{value:.10g}")


def _same_float(one: float, other: float) -> bool:
    return _FLOAT.pack(one) == _FLOAT.pack(other)


def fixed(value: float | None, decimals: int) -> str:
    """Format a value with so many decimals; None is one that is not told."""
    return "-" if value is None else f"{round(value, decimals) + 0.0:.{decimals}f}"


def reached_at(status: Mapping[str, Any]) -> str:
    """Say what a bridge has and where it is reached; once, where the former is a URL. ``status``: its own."""
    root, doors = str(status["root"]), [*status["listen"], *status["connect"]]
    return root if len(doors) == 1 and doors[0] in root else f"{root} at {', '.join(doors)}"


def echo_words(echo: Mapping[str, str | int]) -> str:
    """Say what is known of an adapter, and what came of it; of one without an echo the first alone."""
    said = f"echo: {echo['state']}"
    if echo["bytes"]:
        said += f", {echo['bytes']} bytes that came back were dropped"
    return f"{said}, {echo['collisions']} collisions" if echo["collisions"] else said


def first_keys(greeting: str) -> str:
    """Words for what to type to see something of a board that answers ``greeting``; empty without one."""
    typed = greeting.rstrip("\r\n")
    parts = [f"type {typed if typed.isprintable() else ascii(typed)}"] if typed else []
    if greeting != typed:
        parts.append("press Enter")
    return " and ".join(parts)


def starts_words(device: str, ready_in_ns: int) -> str:
    """Say that a board has just got its power, and when it answers."""
    return f"{device} starts, and answers in {ready_in_ns / 1e9:.1f} s"


def line_end(greeting: str) -> bytes:
    """End of line that a board takes, by what makes it answer; a line feed where that says none."""
    return greeting[len(greeting.rstrip("\r\n")) :].encode() or b"\n"
