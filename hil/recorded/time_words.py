"""Times of a run as people write them: ``12.5s``, ``900ms``, ``1:02:03.5``, ``-10s`` before the end,
``fault-1s`` before the latest fault, ``fault2+500ms`` after the one of this number."""

import re
from collections.abc import Mapping
from decimal import Decimal

from hil.vocab.time import NS_PER_MS, NS_PER_S, SimTimeNs

_UNITS = {
    "": NS_PER_S,
    "s": NS_PER_S,
    "ms": NS_PER_MS,
    "us": 1000,
    "ns": 1,
    "min": 60 * NS_PER_S,
    "h": 3600 * NS_PER_S,
}
_NUMBER = re.compile(r"(?P<number>\d+\.?\d*|\.\d+)\s*(?P<unit>[a-z]*)")
_CLOCK = re.compile(r"(?:(?P<hours>\d+):)?(?P<minutes>\d+):(?P<seconds>\d+(?:\.\d*)?)")
_FAULT = re.compile(r"fault\s*(?P<number>\d{1,9})?\s*(?:(?P<sign>[-+])(?P<length>.+))?")
_EXAMPLES = "write it as 12.5s, 900ms, 1:02:03.5, or -10s for ten seconds before the end"
_NO_FAULTS: Mapping[int, int] = {}


class NoSuchTime(ValueError):
    """Error of a text that is no time of the run: ``str(error)`` says what to write."""


def parse_length(text: str) -> SimTimeNs:
    """Read a length of time; a number alone is in seconds.

    Raises:
        NoSuchTime: it is none.
    """
    if (found := _NUMBER.fullmatch(text.strip().lower())) and found["unit"] in _UNITS:
        return SimTimeNs(round(Decimal(found["number"]) * _UNITS[found["unit"]]))
    if clock := _CLOCK.fullmatch(text.strip()):
        minutes = int(clock["hours"] or 0) * 60 + int(clock["minutes"])
        return SimTimeNs(round((minutes * 60 + Decimal(clock["seconds"])) * NS_PER_S))
    raise NoSuchTime(f"{text!r} is no time; {_EXAMPLES}")


def parse_time(text: str, end_ns: SimTimeNs, faults: Mapping[int, int] = _NO_FAULTS) -> SimTimeNs:
    """Read a time of a run that ends at ``end_ns``; with - before it, it is counted from there. ``faults``:
    when those of the run began, by their numbers: ``fault`` is the latest, ``fault2`` has its number.

    Raises:
        NoSuchTime: it is none, or not within the run.
    """
    if fault := _FAULT.fullmatch(text.strip().lower()):
        at_ns = _fault_ns(fault["number"], faults)
        if fault["sign"]:
            length_ns = parse_length(fault["length"])
            at_ns += length_ns if fault["sign"] == "+" else -length_ns
    else:
        length_ns = parse_length(text.strip().removeprefix("-"))
        at_ns = end_ns - length_ns if text.strip().startswith("-") else length_ns
    if not 0 <= at_ns <= end_ns:
        raise NoSuchTime(
            f"{text} is not within the run, which is {time_text(end_ns)} long; write a time up to that"
        )
    return SimTimeNs(at_ns)


def _fault_ns(number: str | None, faults: Mapping[int, int]) -> int:
    if not faults:
        raise NoSuchTime("the run had no fault; write a time, as 12.5s")
    if number is None:
        return max(faults.values())
    if int(number) not in faults:
        raise NoSuchTime(f"the run had no fault {number}; its faults are {', '.join(map(str, faults))}")
    return faults[int(number)]


def time_text(at_ns: int) -> str:
    """Format a time as ``parse_time`` reads it: seconds, or hours, minutes and seconds from a minute on."""
    seconds = Decimal(at_ns) / NS_PER_S
    if seconds < 60:
        return f"{_plain(seconds)}s"
    hours, rest = divmod(seconds, 3600)
    minutes, rest = divmod(rest, 60)
    whole, _, parts = _plain(rest).partition(".")
    return f"{int(hours)}:{int(minutes):02d}:{int(whole):02d}{'.' if parts else ''}{parts}"


def _plain(seconds: Decimal) -> str:
    """Seconds without zeros at the end."""
    text = f"{seconds:f}"
    return text.rstrip("0").rstrip(".") if "." in text else text
