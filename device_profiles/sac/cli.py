"""``hil sac ...``: files of the companion. The caller adds which board."""

from pathlib import Path
from typing import Annotated

import typer

from device_profiles.sac import companion
from device_profiles.sac.companion_files import LINE_BYTES, is_line, read_one_shot, read_queue, write_queue
from device_profiles.sac.long_files import read_long_file
from device_profiles.sac.row_stream import RowStream
from hil.vocab.dialogue import Refusal, Task
from hil.vocab.profile import Commands

QueuePath = Annotated[Path, typer.Argument(help="A queue's file.", metavar="QUEUE", show_default=False)]


def load(
    file: QueuePath,
    store: Annotated[
        bool, typer.Option("--store", help="Save the queue in the board's EEPROM too (qs).")
    ] = False,
) -> Task:
    """Write a queue's file into a board.

    Checks every row before it sends the first, and reads the whole queue back.

    Example: hil sac load moves.txt
    """
    queue = read_queue(_content(file), str(file))
    where = " and its EEPROM" if store else ""
    return Task(
        companion.load(queue, store=store), lambda rows: f"{rows} rows are in the board's queue{where}"
    )


def save(file: QueuePath) -> Task:
    """Write a board's queue into a file.

    Example: hil sac save moves.txt
    """
    if not file.parent.is_dir():
        raise Refusal(f"{file}: there is no folder {file.parent}")

    return Task(companion.save(), lambda rows: f"{file}: {len(rows)} rows", file=file, content=write_queue)


def stream(
    file: Annotated[
        Path, typer.Argument(help="A file of rows, as many as you like.", metavar="FILE", show_default=False)
    ],
    first: Annotated[int, typer.Option("--from", help="The first row to run.")] = 1,
    last: Annotated[
        int | None, typer.Option("--to", help="The last row to run. [default: the file's]")
    ] = None,
) -> Task:
    """Run the rows of a long file, each sent when the board's queue has room.

    Checks every row before it sends the first. Ctrl-C ends it behind the row that runs, and says which.

    Example: hil sac stream long.txt --from 2
    """
    rows = RowStream(read_long_file(_content(file), str(file)), first, last)
    return Task(rows.run(), lambda count: f"{file}: {count:,} rows have run", rows.halt)


def oneshot(
    file: Annotated[
        Path, typer.Argument(help="A file of one-shot commands.", metavar="FILE", show_default=False)
    ],
    line: Annotated[int, typer.Argument(help="Which of its lines, from 1.", metavar="N", show_default=False)],
) -> Task:
    """Send one command of a one-shot file.

    Example: hil sac oneshot commands.txt 1
    """
    command = read_one_shot(_content(file), str(file), line)
    return Task(companion.commands([command]), lambda lines: "\n".join([f"sent: {command}", *lines]))


def command(
    lines: Annotated[list[str], typer.Argument(help="As typed at the prompt.", metavar="LINE...")],
) -> Task:
    """Type lines at a board, and print what it says.

    Quote what the shell would take for its own.

    Example: hil sac command '$CM90' '$R'
    """
    for line in lines:
        if not is_line(line):
            raise Refusal(f"{line!r}: a line has at most {LINE_BYTES} printable ASCII characters")
    return Task(companion.commands(lines), "\n".join)


def calibrate(
    rpm: Annotated[int, typer.Argument(help="The speed, one that the motor can start at.")],
) -> Task:
    """Run for a minute at a speed, and compare the board's clock with this computer's.

    The motor turns without a ramp. Start and stop are told by soft_ops over the terminal; a USB adapter may
    hold a byte for 16 ms, 270 millionths of a minute.

    Example: hil sac calibrate 60
    """
    return Task(companion.calibrate(rpm), _judged, companion.stop_and_restore)


def _content(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise Refusal(f"{file}: {error.strerror}") from None


def _judged(found: companion.Calibration) -> str:
    lines = [
        f"{found.measured_ns / 1e9:.6f} s instead of {found.nominal_ns / 1e9:.6f} s",
        f"factor {found.factor:.6f} ({(found.factor - 1) * 1e6:+.0f} ppm)",
    ]
    if (correction_us := found.correction_us) == 0:
        lines.append("less than half a microsecond a pulse: nothing to correct")
    elif correction_us > 0:
        lines.append(f"too fast: $CI{found.clock_correction_us + correction_us}, then $R")
    else:
        lines.append(f"too slow: $CH{found.interrupt_overhead_us - correction_us}, then $R")
    return "\n".join(lines)


COMMANDS = Commands(
    about="Load and save files of the SAC's companion program.",
    functions=(load, save, stream, oneshot, command, calibrate),
    baud=38400,
)
