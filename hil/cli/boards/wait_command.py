"""``hil wait``: a condition on the fields of an axis."""

import sys
import time
from collections.abc import Mapping
from typing import Annotated, Any

import typer

from hil.cli.boards.axis_samples import watching
from hil.cli.boards.time_given import Within, seconds_of
from hil.cli.framework.ask import ANY_BENCH, BenchOptions, DeviceName, fail
from hil.cli.framework.command_answers import CommandAnswer, wants_json
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.progress_bars import bar, end_bars
from hil.cli.framework.shown_words import shown_number
from hil.host.journal import say
from hil.net.condition import Condition, ConditionError, parse_condition

_LOOK_S = 0.02
_INTERVAL_MS = 1.0
"""Simulated time between two samples."""
_SAMPLES_PER_MS = 20.0
"""Maximum number of samples on this computer's clock, which a bench above speed 20 would exceed."""


def wait(
    device: DeviceName,
    condition: Annotated[
        str,
        typer.Argument(
            help="Comparisons of fields that `hil status` shows, with < <= > >= == !=; `and`, `or`, `not`,"
            " parentheses, + - * /, abs(), min(), max().",
            show_default=False,
        ),
    ],
    within: Within = "10s",
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Wait until a condition on the fields of an axis holds.

    It is looked at each simulated millisecond, or more rarely at a bench above speed 20. Exits with 1 if it
    did not hold within --within, and shows the last state. Codes have their words, as `hil status m1` shows
    them: mode == velocity, motion_state == standby.

    Example: hil wait m1 'position_deg >= 89' --within 2s

    Example: hil wait s1 'motion_state == standby'
    """
    within_s = seconds_of(within)
    try:
        wanted = parse_condition(condition)
        begin = bench.ask("state", device=device)
        wanted.check(device, [name for name in begin if name != "at_ns"])
    except ConditionError as error:
        raise fail(f"hil: {error}", Exit.MISTAKE) from None
    if wanted.holds(begin):
        return _held(device, condition, wanted, begin, 0.0)
    interval_ms = max(_INTERVAL_MS, float(bench.ask("status")["speed"]) / _SAMPLES_PER_MS)
    with (
        watching(bench, device, wanted.fields, round(interval_ms * 1e6)) as (names, more),
        bar(f"{device} until {condition}", "s simulated") as shown,
    ):
        first_ns: float | None = None
        for rows in more:
            for at_ns, *sample in rows:
                first_ns = at_ns if first_ns is None else first_ns
                after_s = (at_ns - first_ns) * 1e-9
                shown.tell(after_s, within_s)
                if after_s > within_s:
                    return _late(bench, device, condition, within_s)
                values = dict(zip(names, sample, strict=True))
                if wanted.holds(values):
                    return _held(device, condition, wanted, values, after_s)
            time.sleep(_LOOK_S)
    raise AssertionError("the samples do not end")


def _held(
    device: str, text: str, wanted: Condition, values: Mapping[str, float | None], after_s: float
) -> CommandAnswer:
    told = {name: values[name] for name in wanted.fields}
    shown = ", ".join(f"{name} is {shown_number(value)}" for name, value in told.items())
    said = f"{device}: {text} after {after_s:.3f} s: {shown}"
    return CommandAnswer({"holds": True, "after_s": after_s, "state": told}, said)


def _late(bench: BenchOptions, device: str, text: str, within_s: float) -> CommandAnswer:
    from hil.cli.bench.views import field_lines

    state: dict[str, Any] = bench.ask("state", device=device)
    end_bars()
    if not wants_json():
        say(f"hil: {device}: {text} did not hold within {within_s:g} s; the last state:", sys.stderr)
    answer = {"holds": False, "after_s": within_s, "state": state}
    return CommandAnswer(answer, "\n".join(field_lines(state)), Exit.FAILED)
