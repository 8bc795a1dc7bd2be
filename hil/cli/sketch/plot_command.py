"""``hil sketch plot``: numbers that a sketch prints, drawn."""

import math
import sys
from collections.abc import Iterator
from contextlib import suppress
from typing import Annotated

import typer

from hil.cli.boards.drawn_recordings import Output, check_output, shown_recording
from hil.cli.framework.ask import ANY_BENCH, BenchOptions, fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.framework.exit_codes import exit_of
from hil.cli.framework.progress_bars import bar
from hil.host.journal import say
from hil.sketch.printed_numbers import PrintedNumbers
from hil.vocab.shown_text import printable

_LOOK_S = 0.1


def plot(
    device: Annotated[str, typer.Argument(help="Device, or another port of one.", show_default=False)],
    seconds: Annotated[float, typer.Option("--seconds", help="Simulated time to draw.", min=0.001)] = 5.0,
    output: Output = None,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Draw the numbers that a sketch prints, as the plotter of the Arduino IDE does.

    Lines have numbers with commas, spaces or tabs between, each with a name before it or none: 20.5,40 or
    in:20.5 out:40. Lines with other text are left out. It listens without opening the port: the board is not
    reset, and a monitor may stay open. Ctrl-C ends it and draws.

    Example: hil sketch plot u1 --seconds 10

    Example: hil sketch plot u1 -o temperature.csv
    """
    from hil.telemetry.recording import Recording

    check_output(output)
    say(f"{device}: listening for {seconds:g} s; Ctrl-C ends it", sys.stderr)
    printed = PrintedNumbers()
    first_ns: int | None = None
    with suppress(KeyboardInterrupt), bar(f"{device} is heard", "s simulated") as shown:
        for at_ns, data, is_cut in _said_by(bench, device, seconds):
            first_ns = at_ns if first_ns is None else first_ns
            shown.tell((at_ns - first_ns) * 1e-9, seconds)
            if is_cut:
                printed.break_off()
            printed.add(at_ns, data)
    if not printed.rows:
        lines = f"{printed.others} lines of other text" if printed.others else "no whole line"
        why = f"{device} has printed no numbers in this time ({lines})"
        raise fail(f"{why}; `hil monitor {device}` shows what it prints, --seconds listens longer")
    names, rows = tuple(map(printable, printed.names)), printed.table()
    recording = Recording(names, rows, units=dict.fromkeys(names, ""))
    left_out = f"left out: {printed.others} lines of other text" if printed.others else ""
    text = shown_recording(recording, output, f"{device}: {', '.join(names)}", left_out)
    known = [[None if math.isnan(value) else value for value in row] for row in rows]
    return CommandAnswer({"signals": ["at_ns", *names], "rows": known}, text, is_harmless=True)


def _said_by(bench: BenchOptions, device: str, seconds: float) -> Iterator[tuple[int, bytes, bool]]:
    """Pieces that a board sends at its port in a simulated time, as they come: when, what, and whether
    something before it was lost."""
    from hil.cli.captures.capture_files import records_of
    from hil.cli.captures.capture_run import LiveInput
    from hil.net.control_client import ControlError, begin
    from hil.wire.pcapng import RecordKind

    try:
        client, _ = begin(bench.meant().socket, "capture", ports=[device])
    except ControlError as error:
        raise fail(f"hil: {error}", exit_of(error)) from None
    with client:
        begun_ns, first_ns = bench.ask("status")["sim_ns"], math.inf
        for record in records_of(LiveInput(client.fileno(), _LOOK_S)):
            if record is None:
                if bench.ask("status")["sim_ns"] - begun_ns >= seconds * 1e9:
                    return
                continue
            first_ns = min(first_ns, record.at_ns)
            if record.at_ns - first_ns > seconds * 1e9:
                return
            yield record.at_ns, record.data if record.event == RecordKind.RX else b"", record.lost > 0
        raise fail("hil: the bench has ended")
