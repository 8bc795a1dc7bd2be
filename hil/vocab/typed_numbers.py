"""Numbers as people type them: the number, or what is wrong with the text and what to write instead.

Units stand in names, as in ``position_deg``: a number is written without its unit, with a point before its
decimals. Who writes another unit of the same quantity reads its value in the one that is meant.
"""

import math
import re

_UNSIGNED = r"(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_NUMBER = rf"[-+]?{_UNSIGNED}"
_WITH_UNIT = re.compile(rf"({_NUMBER})\s*([^\W\d_][^\d\s]*(?:\^?2|²)?|[°%])")
_WITH_THOUSANDS = re.compile(rf"({_NUMBER})\s*([kKM])")
_IN_BASE_16 = re.compile(rf"(?!{_NUMBER}$)(?:0[0-9A-Fa-f]+|[0-9][0-9A-Fa-f]{{2,}})")
_WITH_COMMA = re.compile(r"([-+]?\d+),(\d+)")
_WITH_SIGNS = re.compile(rf"[-+]+([-+]{_UNSIGNED})")
_MOST_SHOWN = 40

_UNITS: dict[str, tuple[str, float, str]] = {
    "deg": ("angle", 1.0, "degrees"),
    "rad": ("angle", 180 / math.pi, "radians"),
    "turn": ("angle", 360.0, "turns"),
    "rpm": ("speed", 1.0, "rpm"),
    "deg/s": ("speed", 1 / 6, "deg/s"),
    "rad/s": ("speed", 30 / math.pi, "rad/s"),
    "turn/s": ("speed", 60.0, "turns a second"),
    "rpm/s": ("acceleration", 1.0, "rpm/s"),
    "deg/s2": ("acceleration", 1 / 6, "deg/s2"),
    "s": ("time", 1.0, "seconds"),
    "ms": ("time", 1e-3, "milliseconds"),
    "us": ("time", 1e-6, "microseconds"),
    "ns": ("time", 1e-9, "nanoseconds"),
    "min": ("time", 60.0, "minutes"),
    "h": ("time", 3600.0, "hours"),
    "A": ("current", 1.0, "A"),
    "mA": ("current", 1e-3, "mA"),
    "V": ("voltage", 1.0, "V"),
    "mV": ("voltage", 1e-3, "mV"),
    "Nm": ("torque", 1.0, "Nm"),
    "Ncm": ("torque", 1e-2, "Ncm"),
    "mNm": ("torque", 1e-3, "mNm"),
    "Hz": ("frequency", 1.0, "Hz"),
    "kHz": ("frequency", 1e3, "kHz"),
    "MHz": ("frequency", 1e6, "MHz"),
    "m": ("length", 1e3, "m"),
    "cm": ("length", 10.0, "cm"),
    "mm": ("length", 1.0, "mm"),
    "um": ("length", 1e-3, "um"),
    "in": ("length", 25.4, "inches"),
    "": ("part", 1.0, ""),
    "%": ("part", 1e-2, "percent"),
    "bit/s": ("rate", 1.0, "bit/s"),
    "kbit/s": ("rate", 1e3, "kbit/s"),
    "Mbit/s": ("rate", 1e6, "Mbit/s"),
    "degC": ("temperature", 1.0, "degrees Celsius"),
    "count": ("count", 1.0, "counts"),
}
"""Units with their quantity, their size, and their name as a person says it."""
_ALSO = {
    **{each: "deg" for each in ("°", "degree", "degrees", "degs")},
    **{each: "rad" for each in ("rads", "radian", "radians")},
    **{each: "turn" for each in ("turns", "rev", "revs", "rot", "revolutions")},
    **{each: "rpm" for each in ("rev/min", "turns/min", "1/min", "U/min", "RPM")},
    **{each: "turn/s" for each in ("rps", "rev/s", "turns/s")},
    **{each: "deg/s2" for each in ("deg/s^2", "deg/s²", "°/s2", "°/s²")},
    **{each: "s" for each in ("sec", "secs", "second", "seconds")},
    **{each: "us" for each in ("µs", "μs", "usec")},
    **{each: "ms" for each in ("msec", "millis")},
    **{each: "min" for each in ("mins", "minute", "minutes")},
    **{each: "count" for each in ("counts", "cnt")},
    **{each: "in" for each in ("inch", "inches")},
    **{each: "degC" for each in ("°C", "C", "celsius")},
    **{each: "Nm" for each in ("N.m", "N·m", "N*m")},
    **{each: "Hz" for each in ("hz", "HZ")},
    **{each: "kHz" for each in ("khz", "KHz")},
    **{each: "bit/s" for each in ("baud", "Bd", "bd", "bps", "bits/s")},
    "°/s": "deg/s",
    "percent": "%",
}
"""Other spellings."""
_UNITS_OF_NAMES = {"baud": "bit/s", "bit_rate": "bit/s", "rate_hz": "Hz"}
_PLAIN_UNITS = {"current", "voltage", "torque", "frequency", "rate"}
"""Quantities whose values are in the unit without a prefix where a name says none."""
_NAMED = {"True": "true", "False": "false", "None": "nothing"}


def typed_number(text: str) -> float | int | str:
    """Number that a text is; the text itself if it is none, or is not finite."""
    for read in (int, float):
        try:
            value = read(text)
        except ValueError:
            continue
        return value if math.isfinite(value) else text
    return text


def unit_in(name: str) -> str:
    """Unit that a name says, as that of ``position_deg`` or ``acceleration_rpm_per_s``; empty: it says
    none."""
    ending = name.replace("_per_s", "/s").rpartition("_")[2]
    return ending if ending in _UNITS and "_" in name else _UNITS_OF_NAMES.get(name, "")


def is_unit(text: str) -> bool:
    """True if a text is a unit, or another spelling of one."""
    return bool(text) and (text in _UNITS or text in _ALSO)


def quoted(given: object) -> str:
    """Text of a given value for a message, not too long: in quotes if it is a text, a flag as in JSON."""
    said = _NAMED.get(repr(given), str(given))
    if isinstance(given, float):
        said = f"{given:.15g}"
    said = said if len(said) <= _MOST_SHOWN else f"{said[:_MOST_SHOWN]}..."
    return f'"{said}"' if isinstance(given, str) else said


def unit_said(unit: str) -> str:
    """Name of a unit as a person says it, as ``degrees``; the unit itself if it has no other."""
    return _UNITS[unit][2] if unit in _UNITS else unit


def number_problem(given: str, unit: str = "", limits: str = "a number") -> tuple[str, str]:
    """Problem of a text that is no number: what is wrong with it, and what to write. ``limits``: what may be
    written, in ``unit``."""
    text, said = given.strip(), quoted(given)
    if not isinstance(typed_number(text), str):
        return f"{said} is a text", f"write the number without quotes, as {text}"
    if found := _WITH_COMMA.fullmatch(text):
        return f"{said} has a comma", f"write a point before decimals, as {found[1]}.{found[2]}"
    if found := _WITH_THOUSANDS.fullmatch(text):
        times, name = (1e6, "million") if found[2] == "M" else (1e3, "thousand")
        return f"{said} has {found[2]} for {name}", f"write {plain_number(float(found[1]) * times)}"
    if _IN_BASE_16.fullmatch(text) and not _is_with_unit(text):
        return f"{said} is a number in base 16", f"write 0x before it, as 0x{text}"
    if found := _WITH_UNIT.fullmatch(text):
        return _unit_problem(said, found[1], _ALSO.get(found[2], found[2]), unit, limits)
    if found := _WITH_SIGNS.fullmatch(text):
        return f"{said} has more than one sign", f"write one, as {found[1]}"
    try:
        is_huge = math.isinf(float(text)) and any(map(str.isdigit, text))
    except ValueError:
        is_huge = False
    what = f"{said} is too large" if is_huge else f"{said} is no number" if text else "no number is given"
    return what, f"write {limits}"


def _is_with_unit(text: str) -> bool:
    found = _WITH_UNIT.fullmatch(text)
    return bool(found and text[0] != "0" and _ALSO.get(found[2], found[2]) in _UNITS)


def _unit_problem(said: str, number: str, is_in: str, unit: str, limits: str) -> tuple[str, str]:
    """Problem of a number with the unit ``is_in`` where one in ``unit`` is meant."""
    name = unit_said(unit) or "the number"
    without = f"write {name} without the unit" if unit else "write it without a unit"
    if is_in not in _UNITS:
        return f"{said} is no number", f"{without}, as {number}"
    if is_in == unit:
        return f"{said} has its unit", f"{without}, as {number}"
    of, size, other = _UNITS[is_in]
    wanted, own, _ = _UNITS.get(unit, ("", 1.0, ""))
    if of == wanted:
        return f"{said} is in {other}", f"{without}, as {plain_number(float(number) * size / own)}"
    if not unit:
        value = plain_number(float(number) * size) if of in _PLAIN_UNITS and size != 1 else number
        return f"{said} has a unit", f"{without}, as {value}"
    return f"{said} is in {other}, and {name} are meant", f"write {limits}"


def plain_number(value: float) -> str:
    """Format a number of at most six digits, without an exponent where none is needed; a whole one with all
    its digits."""
    if 1 <= abs(value) < 1e12 and abs(value - round(value)) < 1e-9 * abs(value):
        return str(round(value))
    return f"{value:.6g}".replace("e+0", "e").replace("e-0", "e-")
