"""``hil capture``, ``hil decode`` and ``hil line play``: traffic on lines, buses and at ports."""

import errno
import sys
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hil.cli.framework.ask import ANY_BENCH, BenchOptions, fail
from hil.cli.framework.command_answers import AsJson, CommandAnswer

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from hil.compose.decoded_item import DecodedItem
    from hil.compose.decoding import Decoder, LineChoice
    from hil.wire.pcapng import CaptureBytes

_IDLE_S = 0.2
"""Pause after which what is held is shown, where only silence ends a packet; of a bench in real time."""
_SLOWEST = 0.02
"""Least speed of a bench for whose sake the pause is longer."""
_WRONG_PLACE = (errno.ENOENT, errno.EISDIR, errno.ENOTDIR, errno.EACCES, errno.EPERM)
"""Errors of Linux for a file that cannot be where it was asked for."""


def capture(
    sources: Annotated[
        list[str], typer.Argument(help="Segments, CAN buses and ports by name: bus0, can0, s2, s1.network.")
    ],
    write: Annotated[
        str | None,
        typer.Option(
            "--write",
            "-w",
            "--output",
            "-o",
            help="Write pcapng to this file, and print nothing; - is the standard output.",
        ),
    ] = None,
    count: Annotated[
        int | None,
        typer.Option("--count", "-c", help="End after so many packets, frames or lines.", min=1),
    ] = None,
    wireshark: Annotated[
        bool, typer.Option("--wireshark", help="Show it live in Wireshark, with hil's dissector.")
    ] = False,
    rotate_mb: Annotated[
        float | None, typer.Option("--rotate", help="Begin a new file after so many megabytes.", min=0.001)
    ] = None,
    files: Annotated[int, typer.Option("--files", help="How many files to keep with --rotate.", min=1)] = 10,
    as_json: AsJson = False,
    bench: BenchOptions = ANY_BENCH,
) -> None:
    """Show what passes on segments, CAN buses and at ports, or write it to a file, until Ctrl-C.

    A line is a packet, a frame of CAN, or a line of bytes at a terminal: seconds since the first, where, from
    whom to whom, what. They are in the order of time, for which each waits half a second at most while others
    pass. On the standard error is what is captured, and at the end how much it was. Exits with 1 if the bench
    ends.

    Example: hil capture bus0 -c 10

    Example: hil capture bus0 -w bus0.pcapng

    A file of CAN buses named .log is as candump writes it, .asc and .blf as Vector's tools do.
    """
    from hil.cli.captures.capture_files import log_kind

    if sum((write is not None, wireshark, as_json)) > 1:
        raise fail("hil: choose one of --write, --wireshark and --json", 2)
    if rotate_mb and (write in (None, "-") or log_kind(write or "")):
        raise fail("hil: --rotate needs --write with a file of pcapng", 2)
    if write == "-" and sys.stdout.isatty():
        raise fail(
            "hil: pcapng is no text for a terminal: leave out -w to see the packets here, name a file,"
            f" or write it to a program, as in `hil capture {' '.join(sources)} -w - | hil decode -`",
            2,
        )
    from hil.cli.captures.capture_targets import FileTarget, LinesTarget, WiresharkTarget

    target: FileTarget | LinesTarget | WiresharkTarget
    if wireshark:
        target = WiresharkTarget()
    elif write is not None:
        target = FileTarget(write, round((rotate_mb or 0) * 1e6), files)
    else:
        target = LinesTarget(as_json=as_json)
    _capture(sources, target, count, bench)


def _capture(sources: list[str], target: Any, count: int | None, bench: BenchOptions) -> None:
    from hil.cli.captures.capture_run import capture_run
    from hil.cli.captures.time_order import WINDOW_NS
    from hil.cli.framework.exit_codes import exit_of
    from hil.net.control_client import ControlError, ask, begin
    from hil.wire.pcapng import CaptureError

    socket = bench.meant().socket
    try:
        is_waiting = count is not None or target.is_live
        speed = max(_SLOWEST, ask(socket, "status")["speed"])
        idle_s = _IDLE_S / min(1, speed) if is_waiting else None
        client, _ = begin(socket, "capture", ports=sources)
    except ControlError as error:
        raise fail(f"hil: {error}", exit_of(error)) from None
    with client:
        try:
            capture_run(client, target, count, idle_s, round(WINDOW_NS * max(1, speed)))
        except OSError as error:
            code = 2 if error.errno in _WRONG_PLACE else 1
            raise fail(f"{target.name}: {error.strerror or error}", code) from None
        except CaptureError as error:
            raise fail(f"hil: {target.name}: {error}") from None


def decode(
    file: Annotated[
        Path,
        typer.Argument(
            help="A capture (pcapng, pcap) or a log of CAN (candump's, .asc, .blf); - is the standard input.",
            metavar="FILE",
        ),
    ],
    eds: Annotated[
        list[str] | None,
        typer.Option("--eds", help="The EDS of a CANopen node, by its id, as in 5=drive.eds; for each node."),
    ] = None,
    framing: Annotated[
        str | None,
        typer.Option(
            "--framing",
            help="Framing of the lines that do not say theirs, perhaps with their format, as in"
            " 'modbus_rtu 8E1'. [default: bytes]",
        ),
    ] = None,
    baud: Annotated[
        int | None,
        typer.Option(
            "--baud", help="Speed of the lines that do not say theirs. [default: 38400]", min=1, max=10**8
        ),
    ] = None,
    fields: Annotated[
        bool,
        typer.Option("--fields", help="Each packet's fields, with the bytes that they are."),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Print a capture's packets and frames as text: time, place, sender, receiver, contents.

    They are in the order of time: exactly of a file, within half a second as they come.

    Live: hil capture can0 -w - | hil decode -

    What cannot be read is left out, which the standard error says in one line.

    Exits with 2 if the file ends within a record, or has nothing that can be read. Prints the complete
    records.

    Example: hil decode bus0.pcapng
    """
    from hil.cli.captures.capture_targets import LinesTarget
    from hil.cli.framework.interrupts import ended_by
    from hil.cli.framework.progress_bars import bar
    from hil.compose.decoding import Decoder
    from hil.discovery.named_kinds import find_logs
    from hil.host.journal import say
    from hil.wire.pcapng import CaptureError

    def tell(text: str) -> None:
        say(f"hil: {text}", sys.stderr)

    try:
        names = {kind: kind.names(eds or (), tell) for kind in find_logs()}
    except ValueError as error:
        raise fail(f"hil: {error}", 2) from None
    name = "the standard input" if file == Path("-") else str(file)
    decoders: list[Decoder] = []
    choice = _line_choice(framing, baud)

    def new() -> Decoder:
        decoders.append(Decoder(names, choice))
        return decoders[-1]

    target, first_ns, why = LinesTarget(as_json=as_json, with_fields=fields), None, ""
    try:
        # In a pipeline Ctrl-C ends the capture, too: what it has sent before is still to come.
        with target.open(), suppress(KeyboardInterrupt), ended_by(lambda: None):
            is_silent = file != Path("-") and not sys.stdout.isatty()
            with bar(f"{file.name} is decoded") if is_silent else nullcontext():
                for item in _items(file, new):
                    first_ns = item.at_ns if first_ns is None else first_ns
                    target.show([item], first_ns)
    except CaptureError as error:
        why = str(error)
    except OSError as error:
        raise fail(f"hil: {target.name}: {error.strerror}") from None
    left_out = decoders[0].left_out.told() if decoders else ""
    if first_ns is None:
        why = why or "there is nothing in it that can be read"
    if why:
        raise fail(f"hil: {name}: {'; '.join(filter(None, (why, left_out)))}", 2)
    if left_out:
        say(f"hil: {name}: {left_out}", sys.stderr)


def _items(file: Path, new: "Callable[[], Decoder]") -> "Iterator[DecodedItem]":
    """Items of a file in the order of their times, or of the standard input as they come. ``new``: makes a
    decoder."""
    from hil.cli.captures.capture_input import any_form, of_file
    from hil.cli.captures.capture_run import LiveInput
    from hil.cli.captures.time_order import in_order

    if file == Path("-"):
        return any_form(LiveInput(sys.stdin.fileno(), _IDLE_S, sys.stdout.fileno()), new())
    content = _mapped(file)
    return in_order(lambda: of_file(file.name, content, new()))


def _line_choice(framing: str | None, baud: int | None) -> "LineChoice":
    from hil.compose.decoding import LINE_BAUD, LineChoice
    from hil.compose.find import find_catalogue
    from hil.vocab.line_format import EIGHT_N_1, FORMATS
    from hil.vocab.near_words import meant

    name, _, form = (framing or "").partition(" ")
    if name and name not in (known := find_catalogue().framings):
        raise fail(f"hil: there is no framing {name!r}; {meant(name, list(known))}", 2)
    if form and form not in FORMATS:
        raise fail(f"hil: {form!r} is no format; formats are {', '.join(FORMATS)}", 2)
    return LineChoice(name, FORMATS[form] if form else EIGHT_N_1, baud or LINE_BAUD)


def _mapped(file: Path) -> "CaptureBytes":
    """Content of a file that may be large: its pages come as they are read. A pipe is read whole."""
    from mmap import ACCESS_READ, mmap

    try:
        with file.open("rb") as opened:
            try:
                return mmap(opened.fileno(), 0, access=ACCESS_READ)
            except (OSError, ValueError):  # a pipe, or empty
                return opened.read()
    except OSError as error:
        raise fail(f"hil: {file}: {error.strerror}", 2) from None


def _content(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise fail(f"hil: {file}: {error.strerror}", 2) from None


def play(
    file: Annotated[Path, typer.Argument(help="A capture.", metavar="FILE")],
    tap: Annotated[str, typer.Argument(help="A tap of the segment to play it on, as in bus0.master.")],
    source: Annotated[
        str | None,
        typer.Option("--source", help="Which of its interfaces. [default: the only one]"),
    ] = None,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Send what a capture has, at its own times, on a segment.

    Example: hil line play bus0.pcapng bus0.master
    """
    from hil.cli.captures.capture_input import records_of_file
    from hil.host.journal import say
    from hil.wire.outside_text import LeftOut
    from hil.wire.pcapng import CaptureError, bursts

    left_out = LeftOut()
    try:
        rows = bursts(records_of_file(_content(file), left_out), source)
    except CaptureError as error:
        raise fail(f"hil: {file}: {error}", 2) from None
    if told := left_out.told():
        say(f"hil: {file}: {told}", sys.stderr)
    answer = bench.ask("play", tap=tap, bursts=rows)
    text = f"{len(rows)} bursts begin now, and take {rows[-1][0] / 1e9:.3f} s"
    return CommandAnswer({**answer, "bursts": len(rows), "takes_s": rows[-1][0] / 1e9}, text)
