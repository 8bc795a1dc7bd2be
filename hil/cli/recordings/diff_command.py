"""The command that compares recordings."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.progress_bars import bar
from hil.cli.framework.shown_words import shown_number
from hil.cli.recordings.opened import OfBench, Trust, named, refusals, trusts

if TYPE_CHECKING:
    from hil.recorded.log_differences import LogDifferences
    from hil.sim.input_log import InputLog
    from hil.sim.inputs import Logged

_CONFIGS = (".yaml", ".yml")
_MOST = 12
"""Maximum lines of one kind."""


def diff(
    log: Annotated[
        Path, typer.Argument(help="A recording: a file or bundle, or its name in `hil recordings`, as last.")
    ],
    other: Annotated[
        Path | None,
        typer.Argument(
            help="Another recording, or a configuration (.yaml) that gets the same inputs."
            " [default: the boards as they are today]",
            show_default=False,
        ),
    ] = None,
    trust: Trust = False,
    bench: OfBench = None,
) -> CommandAnswer:
    """Compare a recording with another one, with a configuration, or with the boards as they are today.

    Says whether program, configuration, memories, boards or inputs differ, and the first difference in bytes,
    times or state, with what was before it and the fields of both. A recording of another version runs as far
    as its inputs are taken. Exits with 1 if there is a difference.

    Example: hil diff bench.log
    """
    log = named(log)
    with refusals(log):
        one = _read(log)
        if other is None:
            with bar(f"{log.name} runs again"):
                found, sides = _today(one), ("logged", "now")
        elif other.suffix in _CONFIGS:
            with bar(f"{log.name} runs again, also by {other.name}"):
                found, sides = _at_config(one, other), ("recorded", str(other))
        else:
            other = named(other)
            with refusals(other):
                from hil.recorded.log_differences import compare_logs

                second = _read(other)
                with bar(f"{log.name} and {other.name} are compared"):
                    found, sides = compare_logs(one, second), (str(log), str(other))
    lines = [*_lines(found, sides), *(f"note: {note}" for note in found.notes)]
    code = Exit.FAILED if found.differ else Exit.DONE
    return CommandAnswer(_values(found, sides), "\n".join(lines), code)


def _read(log: Path) -> "InputLog":
    from hil.compose.log_lines import read_log

    return read_log(log, strict=False, trusts=trusts)


def _today(log: "InputLog") -> "LogDifferences":
    from hil.recorded.log_differences import compare_today

    return compare_today(log)


def _at_config(log: "InputLog", file: Path) -> "LogDifferences":
    from hil.compose import find_catalogue, read_text
    from hil.compose.simulated_config import as_simulated
    from hil.config import ConfigError, parse
    from hil.recorded.log_differences import compare_config

    try:
        config = parse(read_text(file), str(file), find_catalogue())
        return compare_config(log, config, as_simulated(config), find_catalogue({}, config.profile_path))
    except ConfigError as error:
        raise fail(f"hil: {error}", Exit.MISTAKE) from None
    except (OSError, UnicodeDecodeError) as error:
        raise fail(f"hil: {file}: {getattr(error, 'strerror', None) or error}", Exit.MISTAKE) from None


def _lines(found: "LogDifferences", sides: tuple[str, str]) -> list[str]:
    from hil.recorded.run_events import bytes_words
    from hil.recorded.time_words import time_text

    if not found.differ:
        return ["identical" + (f", by other programs: {', '.join(found.program)}" if found.program else "")]
    lines = ["different" if found.at_ns is None else f"different from {time_text(found.at_ns)} on"]
    lines += [f"program: {', '.join(found.program)}"] if found.program else []
    for title, some in (
        ("configuration", found.config),
        ("memory at the start", found.memories),
        ("boards", found.boards),
    ):
        lines += _part(title, some)
    if found.inputs:
        number, *both = found.inputs
        lines += [f"inputs, of which {number} are the same:"]
        lines += [f"  {side}: {_input(each)}" for side, each in zip(sides, both, strict=True)]
    lines += _part("sent", [each.words(*sides) for each in found.pieces])
    lines += _states(found, sides)
    lines += _part("inputs before it", found.inputs_before)
    lines += [f"said before it: {bytes_words(found.said_before)}"] if found.said_before else []
    return lines


def _part(title: str, lines: Any) -> list[str]:
    shown = [f"  {line}" for line in lines[:_MOST]]
    more = [f"  and {len(lines) - _MOST} more"] if len(lines) > _MOST else []
    return [f"{title}:", *shown, *more] if lines else []


def _input(logged: "Logged | None") -> str:
    from hil.recorded.run_events import input_event

    return input_event(logged).line() if logged else "none"


def _states(found: "LogDifferences", sides: tuple[str, str]) -> list[str]:
    from hil.recorded.run_events import bytes_words
    from hil.recorded.time_words import time_text

    apart, lines = found.apart, []
    if apart.at_ns is not None:
        title = f"states at {time_text(apart.at_ns)}, {sides[0]} and {sides[1]}, run today"
        both = [(f"{each.axis}.{each.name}", each.then, each.now) for each in apart.fields]
        lines += _part(title, [f"{name}  {shown_number(a)}  {shown_number(b)}" for name, a, b in both])
    for each in apart.sent[:_MOST] if not found.pieces else ():
        pieces = (piece and f"{bytes_words(piece.data)} at {time_text(piece.at_ns)}" for piece in each[1:])
        said = ", ".join(f"{side} {piece or 'nothing'}" for side, piece in zip(sides, pieces, strict=True))
        lines.append(f"sent by {each.place}: {said}")
    for axis, fields in found.state.items():
        told = [
            f"{name}={shown_number(value)}" for name, value in fields.items() if value and name != "at_ns"
        ]
        lines.append(f"state of {axis} now: {', '.join(told)}")
    return lines


def _values(found: "LogDifferences", sides: tuple[str, str]) -> dict[str, Any]:
    def piece(of: Any) -> dict[str, Any] | None:
        return of and {"at_ns": of.at_ns, "hex": of.data.hex(), "state": getattr(of, "state", None)}

    apart, inputs = found.apart, found.inputs
    return {
        "identical": not found.differ,
        "sides": sides,
        "at_ns": found.at_ns,
        "program": found.program,
        "config": [*found.config],
        "memories": found.memories,
        "boards": found.boards,
        "inputs": inputs and {"same": inputs[0], "first": [_input(each) for each in inputs[1:]]},
        "sent": [
            {"device": e.device, "piece": e.number, "first": [piece(e.was), piece(e.now)]}
            for e in found.pieces
        ],
        "states_at_ns": apart.at_ns,
        "fields": [each._asdict() for each in apart.fields],
        "sent_today": [{"place": e.place, "first": [piece(e.then), piece(e.now)]} for e in apart.sent],
        "state_now": found.state,
        "inputs_before": found.inputs_before,
        "said_before": found.said_before.hex(),
        "notes": found.notes,
    }
