"""Lengths of time on the command line, as in 2s, 500ms or 1min."""

import re
from typing import Annotated

import typer

from hil.cli.framework.ask import fail

_SECONDS = {"": 1.0, "us": 1e-6, "ms": 1e-3, "s": 1.0, "min": 60.0}
_TIME = re.compile(r"(\d+\.?\d*|\.\d+)\s*([a-z]*)")
_LONGEST_S = 86_400.0

Within = Annotated[
    str, typer.Option("--within", metavar="TIME", help="Maximum wait, of simulated time: 2s, 500ms, 1min.")
]


def seconds_of(text: str, option: str = "--within") -> float:
    """Read a length of time: more than 0, at most a day. Ends the command if it is none."""
    found = _TIME.fullmatch(text.strip().lower())
    if found is None or found[2] not in _SECONDS:
        raise fail(f"{option} {text}: this is no time; write a number and s, ms, us or min, as in 2s", 2)
    seconds = float(found[1]) * _SECONDS[found[2]]
    if not 0 < seconds <= _LONGEST_S:
        raise fail(
            f"{option} {text}: this is too short or too long; write more than 0 and at most a day, 1440min", 2
        )
    return seconds
