"""``hil monitor``: options of the serial monitor."""

import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hil.cli.boards.board_access import open_address
from hil.cli.framework.ask import ANY_BENCH, BenchOptions, DeviceName, fail, found
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.shown_words import first_keys, line_end, starts_words

if TYPE_CHECKING:
    from hil.cli.monitor.monitor_session import ReceivedLog
    from hil.cli.monitor.port_look import SeenPort
    from hil.cli.monitor.shown_bytes import ByteView

_ENDS = ("cr", "lf", "crlf", "none")


def monitor(
    device: DeviceName,
    wait: Annotated[
        bool | None,
        typer.Option(
            "--wait/--no-wait",
            help="Wait for a bench that is not there yet, or ends: then the end of the standard input ends"
            " nothing. [default: a terminal waits for one that ends]",
            show_default=False,
        ),
    ] = None,
    timestamps: Annotated[
        bool,
        typer.Option("--timestamps", help="Begin each line with the simulated time of its first byte, in s."),
    ] = False,
    as_hex: Annotated[
        bool, typer.Option("--hex", help="Show bytes as hex, with their characters beside.")
    ] = False,
    log: Annotated[
        Path | None,
        typer.Option("--log", help="Write all bytes that come to this file, too, exactly. It is replaced."),
    ] = None,
    enter: Annotated[
        str | None,
        typer.Option(
            "--enter",
            metavar="END",
            help="Bytes that the key Enter sends: cr, lf, crlf or none. [default: the end of line that the"
            " board takes]",
        ),
    ] = None,
    crlf: Annotated[
        bool, typer.Option("--crlf", help="Begin a line at its left edge behind a line feed alone, too.")
    ] = False,
    echo: Annotated[
        bool, typer.Option("--echo", help="Show what is typed: for a board that does not.")
    ] = False,
    macro: Annotated[
        list[str] | None,
        typer.Option(
            "--macro",
            metavar="KEY=KEYS",
            help=r"Let Ctrl-T and this key type a text; \r, \n, \t, \\ and \xHH are one byte each. Again for"
            " each.",
        ),
    ] = None,
    macros: Annotated[
        Path | None, typer.Option("--macros", help="Read macros from this file, in lines KEY: KEYS.")
    ] = None,
    bench: BenchOptions = ANY_BENCH,
) -> None:
    r"""Talk to a device in this terminal; Ctrl-] ends, and Ctrl-T ? lists the other keys.

    Of a port that several programs have open it says what that means. Standard output has what the board
    says, the standard error all else. Where standard input is no terminal, its bytes go to the board as they
    are, and 1 s of silence behind its end ends the monitor; 5 s do, where the board says more all the time.

    Exits with 1 if the log could not be written to its end.

    Example: hil monitor m1

    Example: hil monitor m1 --timestamps --log m1.txt

    Example: hil monitor s1 --macro '1=m3000v150\r' --macro '0=a\r'
    """
    if enter not in (None, *_ENDS):
        raise fail(f"--enter knows no end of line {enter!r}; write {', '.join(_ENDS)}", Exit.MISTAKE)
    if echo and as_hex:
        raise fail("--hex has no place for what is typed; leave out --echo or --hex", Exit.MISTAKE)
    texts = _macros(macro or [], macros)

    from hil.cli.monitor.monitor_session import MonitorSession, shared_words
    from hil.cli.monitor.port_look import NamedPort, PortWatch
    from hil.cli.monitor.typed_keys import LINE_ENDS, KeyReader
    from hil.host.journal import say
    from hil.net.control_client import ControlError
    from hil.net.port_client import PortUnreachable

    is_typed = sys.stdin.isatty()
    port = NamedPort(device, bench)
    row, seen = _seen(port, device, bench, is_awaited=bool(wait))
    greeting = row.get("greeting", "")
    keys = KeyReader(LINE_ENDS[enter] if enter else line_end(greeting), texts)
    view, received = _view(timestamps, as_hex, crlf, is_typed), _log(log)
    waits = is_typed if wait is None else wait
    watch = PortWatch(port.look) if is_typed or waits else None
    session = MonitorSession(device, keys, view, is_typed, waits, echo, received, watch)
    if seen and seen.clients and not is_typed:
        say(f"hil: {shared_words(seen.address)}", sys.stderr)
    try:
        with suppress(KeyboardInterrupt):
            session.run(seen, first_words(device, greeting, seen, int(row.get("ready_in_ns", 0))))
    except (PortUnreachable, ControlError) as error:
        raise fail(str(error)) from None
    finally:
        if watch:
            watch.close()
        if received:
            received.close()
    if received and received.failure:
        raise typer.Exit(Exit.FAILED)


def _seen(
    port: Any, device: str, bench: BenchOptions, *, is_awaited: bool
) -> tuple[dict[str, Any], "SeenPort | None"]:
    """Row and place of the port; none if it is awaited and its bench does not run."""
    from hil.cli.monitor.port_look import SeenPort

    if is_awaited and not found(bench.runtime_dir).meant(bench.bench):
        return {}, None
    here = bench.meant()
    port.is_of(here)
    row, address = open_address(bench, device)
    return row, SeenPort(address, row["clients"], here.socket)


def first_words(device: str, greeting: str, seen: "SeenPort | None", ready_in_ns: int = 0) -> list[str]:
    """Say what somebody who types is told first. ``ready_in_ns``: time until the board answers."""
    from hil.cli.monitor.monitor_session import shared_words

    hints = ["Ctrl-] ends the monitor.", "Ctrl-T ? lists its other keys."]
    if ready_in_ns:
        hints.append(f"{starts_words(device, ready_in_ns)}.")
    elif keys := first_keys(greeting):
        hints.append(f"{device} does not repeat what it said at power-up: {keys} to see it answer.")
    if seen and seen.clients:
        hints.append(f"hil: {shared_words(seen.address)}")
    return hints


def _view(timestamps: bool, as_hex: bool, crlf: bool, is_typed: bool) -> "ByteView":
    from hil.cli.monitor.shown_bytes import HexView, PlainView, TimedView

    is_raw = is_typed and sys.stdout.isatty()
    if as_hex:
        columns = os.get_terminal_size(1).columns if sys.stdout.isatty() else 100
        return HexView(is_raw=is_raw, columns=columns, has_time=timestamps)
    if timestamps:
        return TimedView(is_raw=is_raw, feeds_return=crlf)
    return PlainView(is_raw=is_raw, feeds_return=crlf)


def _log(path: Path | None) -> "ReceivedLog | None":
    from hil.cli.monitor.monitor_session import ReceivedLog

    if path is None:
        return None
    try:
        return ReceivedLog(path)
    except OSError as error:
        raise fail(f"{path}: {error.strerror}", Exit.MISTAKE) from None


def _macros(said: list[str], file: Path | None) -> dict[str, bytes]:
    from hil.cli.monitor.typed_keys import MacroRefused, macro_in, macros_in

    texts: dict[str, bytes] = {}
    if file is not None:
        try:
            lines = file.read_text("latin-1").splitlines()
        except OSError as error:
            raise fail(f"{file}: {error.strerror}", Exit.MISTAKE) from None
        texts, problems = macros_in(lines)
        if problems:
            told = [f"{file}:{line}:{column}: {why}" for line, column, why in problems]
            raise fail("\n".join(told), Exit.MISTAKE)
    for each in said:
        try:
            key, text = macro_in(each)
        except MacroRefused as error:
            raise fail(f"{error}, in --macro; {error.remedy}", Exit.MISTAKE) from None
        texts[key] = text
    return texts
