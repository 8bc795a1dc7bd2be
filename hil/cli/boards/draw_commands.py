"""``hil plot``, ``hil step`` and ``hil pulses``: drawings of an axis."""

import sys
from collections.abc import Callable, Iterator
from contextlib import nullcontext, suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hil.cli.boards.axis_samples import watching
from hil.cli.boards.drawn_recordings import Output, check_output, shown_recording
from hil.cli.framework.ask import ANY_BENCH, BenchOptions, DeviceName, fail
from hil.cli.framework.command_answers import CommandAnswer, pasteable, wants_json
from hil.cli.framework.interrupts import noted
from hil.cli.framework.progress_bars import bar
from hil.host.journal import say
from hil.host.shown_stream import own
from hil.vocab.problem import not_text
from hil.vocab.typed_numbers import plain_number

if TYPE_CHECKING:
    from hil.telemetry.step_response import StepResponse
    from hil.wire.step_dir import Train

_PATIENCE_NS = 3_000_000_000
"""Simulated time in which a board at its main menu has taken a command."""
_LOOP, _LAG = ("r", "yw", "e"), ("commanded_deg", "position_deg", "lag_steps")
"""Signals drawn of a pulse train: of a servo, and of a driver without an encoder. The last is the error."""
_SETTLE_NS = 300_000_000
"""Time between switching the loop on and the step."""
_STEP_INTERVAL_MS = 0.25
_DRIVE_INTERVAL_NS = 1_000_000
_LOOK_NS = 50_000
"""Time between the looks of which a drawing has the extremes: the shortest that a bench gives."""
_DRAWN_INTERVALS = 2000
"""Intervals of a drawing: as many as a wide picture has columns."""

Signals = Annotated[
    str,
    typer.Option(
        "--signals",
        help="Fields of the axis, with commas between; a wrong one lists them. [default: the main ones]",
    ),
]
_FARTHEST_DEG = 1e6
"""Largest step: that of a Mechaduino's verbs."""
Interval = Annotated[float, typer.Option("--interval", help="Simulated milliseconds between samples.")]


def plot(
    device: DeviceName,
    signals: Signals = "",
    seconds: Annotated[float, typer.Option("--seconds", help="Simulated time to draw.", min=0.001)] = 2.0,
    interval_ms: Annotated[
        float | None,
        typer.Option(
            "--interval",
            help="A sample at every so many simulated milliseconds, from 0.05 on. [default: the smallest and"
            " the largest value of short intervals, looked at each 0.05 ms]",
        ),
    ] = None,
    output: Output = None,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Record an axis from now on, and draw it.

    One panel for each unit. What swings faster than the drawing's columns has its true size there; samples at
    an interval show less. Ctrl-C ends the recording and draws it.

    Example: hil plot m1 --seconds 5
    """
    from hil.telemetry.recording import units_in

    check_output(output)
    wanted = tuple(name.strip() for name in signals.split(",")) if signals else ()
    looks = max(round(seconds * 1e9 / _DRAWN_INTERVALS / _LOOK_NS), 1) if interval_ms is None else 1
    interval_ns = looks * _LOOK_NS if interval_ms is None else round(interval_ms * 1e6)
    with watching(bench, device, wanted, interval_ns, looks) as (names, more):
        recording = _recorded(names, interval_ns, looks)
        if {"r", "e"} & {*names}:
            recording.units = units_in(bench.ask("state", device=device))
        say(f"{device}: recording {', '.join(names)} for {seconds:g} s; Ctrl-C ends it", sys.stderr)
        with suppress(KeyboardInterrupt), bar(f"{device} is recorded", "s simulated") as shown:
            for rows in more:
                recording.rows += rows
                if recording.rows:
                    recorded_ns = recording.rows[-1][0] - recording.rows[0][0]
                    if recorded_ns >= seconds * 1e9:
                        break
                    shown.tell(recorded_ns * 1e-9, seconds)
    recording.rows = [row for row in recording.rows if row[0] - recording.rows[0][0] <= seconds * 1e9]
    text = shown_recording(
        recording, output, _title(bench, device, ", ".join(names), recording), recording.sampling
    )
    answer = {
        "signals": ["at_ns", *names],
        "interval_ns": interval_ns,
        "points": looks,
        "rows": recording.rows,
    }
    return CommandAnswer(answer, text, is_harmless=True)


def step(
    device: DeviceName,
    degrees: Annotated[
        float,
        typer.Argument(help="The step, from where the shaft is held.", show_default=False),
    ],
    seconds: Annotated[
        float, typer.Option("--seconds", help="Simulated time after the step.", min=0.01)
    ] = 0.5,
    interval_ms: Interval = _STEP_INTERVAL_MS,
    output: Output = None,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Move a Mechaduino by a step, draw the response, and print overshoot and settling time.

    Types x, y and r at the board, which has to be calibrated and at its main menu. Exits with 1 if the shaft
    does not follow.

    Example: hil step m1 10
    """
    from hil.telemetry import other_motion, step_response

    if not abs(degrees) <= _FARTHEST_DEG:
        raise fail(f"DEGREES: {plain_number(degrees)} is too large; write -1000000 to 1000000 deg", 2)
    check_output(output)
    names = ("r", "yw", "u", "loop_on", "mode")
    if not {*names} <= bench.ask("state", device=device).keys():
        raise fail(
            f"hil: {device} has no set-point that could step: `hil step` is for boards with a servo loop, as"
            f" a Mechaduino; `hil axis {device}` lists what else turns it"
        )
    verbs = {row["verb"] for row in bench.ask("verbs", device=device)}
    if "type" not in verbs:
        raise fail(
            f"hil: {device} has no terminal, at which `hil step` types the set-point, as at a Mechaduino's;"
            f" `hil axis {device} move-abs` turns it, `hil plot {device}` draws that"
        )
    recording = _recorded(names, interval_ns := round(interval_ms * 1e6))

    def send(text: str) -> int:
        answer = bench.ask("send", device=device, data=text.encode().hex())
        return int(answer["effective_at_ns"])

    with watching(bench, device, names, interval_ns) as (_, more):
        sent_ns = send("xy")
        on = _until(more, recording, lambda row: row[0] > sent_ns and row[4:] == (1, ord("x")), device)
        if "move_rel" in verbs:  # a move by nothing: what keeps the board from moving is its own refusal
            still = {"device": device, "name": "move_rel", "parameters": {"angle_deg": 0.0}}
            bench.ask("do", **still)
        still_ns = recording.rows[on][0] + _SETTLE_NS
        start = recording.rows[_until(more, recording, lambda row: row[0] >= still_ns, device)][1]
        sent_ns = send(f"r{start + degrees:.2f}\n")
        at = _until(more, recording, lambda row: row[0] > sent_ns and row[1] != start, device)
        end_ns = recording.rows[at][0] + seconds * 1e9
        _until(more, recording, lambda row: row[0] >= end_ns, device, seconds)
    first_ns = recording.rows[at][0] - min(seconds / 10, 0.05) * 1e9
    shown = _recorded(names[:3], interval_ns)
    shown.rows = [row[:4] for row in recording.rows if first_ns <= row[0] <= end_ns]
    if other := other_motion(shown, degrees):
        _tell(shown_recording(shown, output, _title(bench, device, f"not a step of {degrees:g} deg", shown)))
        raise fail(f"hil: {device}: {other}; end it (`hil pulses {device} --stop` a pulse train) and repeat")
    try:
        figures = step_response(shown)
    except ValueError as error:
        raise fail(f"hil: {device}: {error}") from None
    title = _title(bench, device, f"step of {degrees:g} deg", shown)
    text = shown_recording(shown, output, title, figures.line("deg"), _seen_ns(figures))
    if abs(figures.final_error) > abs(figures.amplitude) / 2:
        _tell(text)
        raise fail(f"hil: the shaft of {device} did not follow: is its load too large?")
    return CommandAnswer({"step_deg": degrees, **asdict(figures)}, text, is_harmless=True)


def pulses(
    device: DeviceName,
    steps: Annotated[
        int | None,
        typer.Option(
            "--steps",
            help="How many, of a Mechaduino 1/32 full step each; negative: with the direction input high.",
        ),
    ] = None,
    rate_Hz: Annotated[float, typer.Option("--rate", help="Steps per second, up to 200000.")] = 1000.0,
    acceleration: Annotated[
        float | None,
        typer.Option(
            "--acceleration",
            metavar="STEPS/S2",
            help="Up to the rate and down from it. [default: none]",
        ),
    ] = None,
    file: Annotated[
        Path | None,
        typer.Option("--file", help="A pulse train in CSV: at_s,steps,duration_s or at_s,step,dir,..."),
    ] = None,
    stop: Annotated[bool, typer.Option("--stop", help="End the train that is being played.")] = False,
    draw: Annotated[
        bool, typer.Option("--plot", help="Wait for its end and draw the following error.")
    ] = False,
    output: Output = None,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Play a pulse train on the step/dir inputs of a board, at exact simulated times.

    A Mechaduino has to be in x mode with its loop on to follow.

    Example: hil pulses m1 --steps 3200 --rate 1000
    """
    check_output(output)
    if (steps is not None) + (file is not None) + stop != 1:
        given = (steps is not None) + (file is not None) + stop
        what = f"{given} of --steps, --file and --stop are given" if given else "no train is given"
        raise fail(f"{what}; give one of --steps, --file and --stop, as in --steps 3200", 2)
    train = _train(file, steps, rate_Hz, acceleration)
    rows = [(e.at_ns, e.pin, e.level, e.steps, e.duration_ns) for e in train]
    draws = draw or output is not None
    has_loop = not draws or "e" in bench.ask("state", device=device)
    recording = _recorded(_LOOP if has_loop else _LAG, _DRIVE_INTERVAL_NS)
    watch = watching(bench, device, recording.signals, _DRIVE_INTERVAL_NS)
    answer: dict[str, Any] = {}
    try:
        with watch if draws else nullcontext() as watched:
            with noted() as interrupts:  # the bench may have the train before its answer is here
                answer = bench.ask("drive", device=device, train=rows)
            length = _length(answer, train)
            if watched is not None:
                say(f"{length}; waiting for its end", sys.stderr)
            if interrupts:
                raise KeyboardInterrupt
            if watched is None:
                return CommandAnswer(answer, length)
            end_ns = answer["effective_at_ns"] + answer["length_ns"] + 100_000_000
            _until(watched[1], recording, lambda row: row[0] >= end_ns, device, answer["length_ns"] * 1e-9)
    except KeyboardInterrupt:
        if answer and train:
            typer.echo(pasteable(f"the train goes on; `hil pulses {device} --stop` ends it"), err=True)
        raise
    worst = max(abs(row[3]) for row in recording.rows)
    notes = f"largest following error {worst:.3f} {'deg' if has_loop else 'full steps'}"
    text = shown_recording(
        recording, output, _title(bench, device, "following a pulse train", recording), notes
    )
    key = "following_error_max_deg" if has_loop else "lag_max_steps"
    return CommandAnswer({**answer, key: worst}, text, is_harmless=True)


def _train(file: Path | None, steps: int | None, rate_Hz: float, acceleration: float | None) -> "Train":
    from hil.wire.step_dir import TrainError, generate, parse_train

    try:
        if file is not None:
            return parse_train(file.read_text("utf-8-sig"), str(file))
        return generate(steps, rate_Hz, acceleration) if steps is not None else ()
    except TrainError as error:
        raise fail(f"hil: {error}" if file is None else str(error), 2) from None
    except UnicodeDecodeError as error:
        raise fail(str(not_text(str(file), error)), 2) from None
    except OSError as error:
        raise fail(f"hil: {file}: {error.strerror}", 2) from None


def _length(answer: dict[str, Any], train: "Train") -> str:
    count = sum(e.steps for e in train)
    what = f"{count:,} steps in {answer['length_ns'] * 1e-9:.6g} s" if train else "no train"
    return f"{what}, from simulated {answer['effective_at_ns'] * 1e-9:.6f} s on"


def _recorded(signals: tuple[str, ...], interval_ns: int, points: int = 1) -> Any:
    from hil.telemetry import Recording

    return Recording(signals, interval_ns=interval_ns, points=points)


def _title(bench: BenchOptions, device: str, what: str, recording: Any) -> str:
    """Title of a drawing: bench, axis, what it shows, and the simulated time at which that begins."""
    begin = f", from {recording.rows[0][0] * 1e-9:.6f} s on" if recording.rows else ""
    return f"{bench.meant().name}: {device}: {what}{begin}"


def _seen_ns(figures: "StepResponse") -> float | None:
    """Time up to which a response is worth drawing: twice that in which it settled, at least 20 ms of it."""
    if figures.settling_ms is None:
        return None
    return figures.at_ns + max(2 * figures.settling_ms, 20.0) * 1e6


def _until(
    more: Iterator[list[tuple[float, ...]]],
    recording: Any,
    holds: Callable[[tuple[float, ...]], bool],
    device: str,
    expected_s: float = 0.0,
) -> int:
    """Record until a new sample fulfils a condition; answers its index."""
    seen = len(recording.rows)
    patience_ns = expected_s * 1e9 + _PATIENCE_NS
    with bar(f"{device} is recorded", "s simulated") as shown:
        for rows in more:
            recording.rows += rows
            for i in range(seen, len(recording.rows)):
                if holds(recording.rows[i]):
                    return i
            if not recording.rows:
                continue
            waited_ns = recording.rows[-1][0] - recording.rows[min(seen, len(recording.rows) - 1)][0]
            if waited_ns > patience_ns:
                why = "did not carry out the command: is it running, and at its main menu?"
                raise fail(f"hil: {device} {why}")
            shown.tell(waited_ns * 1e-9, expected_s)
    raise AssertionError("the pieces do not end")


def _tell(text: str) -> None:
    """Write what ``shown_recording`` has made, which may have colours; beside JSON to the standard error."""
    typer.echo(text, file=own(sys.stderr if wants_json() else sys.stdout))
