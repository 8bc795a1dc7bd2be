"""``hil fault`` and ``hil capture``: faults, and traffic on lines."""

import sys
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from hil.cli.ask import Bench, RuntimeDir, ask_bench, bench_meant, fail
from hil.cli.command_classes import Below
from hil.cli.interrupts import ended_by
from hil.cli.told import CommandAnswer
from hil.vocab.faults import FAULT_KINDS, TARGETS, TIMING

fault_app = typer.Typer(
    cls=Below, help="Inject, list and clear faults.", no_args_is_help=True, rich_markup_mode=None
)


@fault_app.command()
def kinds() -> CommandAnswer:
    """List what can go wrong, with the parameters.

    Example: hil fault kinds
    """
    rows = [
        {
            "kind": kind.name,
            "about": kind.about,
            "on": TARGETS[kind.target],
            "parameters": {each.name: each.described() for each in (*kind.parameters, *TIMING)},
        }
        for kind in FAULT_KINDS.values()
    ]
    lines = []
    for kind in FAULT_KINDS.values():
        lines.append(f"{kind.name}: {kind.about}; on {TARGETS[kind.target]}")
        lines += [f"  {each.name}: {each.described()}" for each in kind.parameters]
    lines += ["every kind:", *(f"  {each.name}: {each.described()}" for each in TIMING)]
    return CommandAnswer(rows, "\n".join(lines))


@fault_app.command()
def inject(
    fault: Annotated[str, typer.Argument(help="Its kind; `hil fault kinds` lists them.")],
    target: Annotated[str, typer.Argument(help="What it is on, as in s2.")],
    parameters: Annotated[list[str] | None, typer.Argument(help="As in rate=0.01 towards=board.")] = None,
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
) -> CommandAnswer:
    """Inject a fault, which lasts until it is cleared.

    Example: hil fault inject byte_drop m1 rate=0.01
    """
    given: dict[str, Any] = {}
    for name, value in map(_parameter, parameters or []):
        if name in given:
            raise fail(f"hil: {name} is given twice", 2)
        given[name] = value
    answer = ask_bench(bench, runtime_dir, "inject", fault=fault, target=target, parameters=given)
    return CommandAnswer(answer, f"fault {answer['number']}")


def _parameter(text: str) -> tuple[str, Any]:
    name, equals, value = text.partition("=")
    if not equals:
        raise fail(f'hil: "{text}" is no parameter; write it as in rate=0.01', 2)
    try:
        return name, float(value)
    except ValueError:
        return name, value


@fault_app.command()
def clear(
    number: Annotated[
        int | None, typer.Argument(help="Of `hil fault list`; left out: all of them.", show_default=False)
    ] = None,
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
) -> CommandAnswer:
    """Clear a fault, or all.

    Example: hil fault clear 1
    """
    active = ask_bench(bench, runtime_dir, "faults")
    numbers = [number] if number is not None else [row["number"] for row in active]
    for each in numbers:
        ask_bench(bench, runtime_dir, "clear", number=each)
    return CommandAnswer({"cleared": numbers})


@fault_app.command("list")
def list_faults(bench: Bench = None, runtime_dir: RuntimeDir = None) -> CommandAnswer:
    """List the faults that are active.

    Example: hil fault list
    """
    rows = ask_bench(bench, runtime_dir, "faults")
    lines = []
    for row in rows:
        parameters = " ".join(f"{name}={value}" for name, value in row["parameters"].items())
        changed = f", {row['changed_bytes']} bytes" if "changed_bytes" in row else ""
        lines.append(f"{row['number']} {row['kind']} {row['target']} {parameters}{changed}")
    return CommandAnswer(rows, "\n".join(lines) or "no fault is active")


def capture(
    sources: Annotated[
        list[str], typer.Argument(help="Segments, CAN buses and ports by name: bus0, can0, s2, s1.network.")
    ],
    write: Annotated[str, typer.Option("--write", "-w", help="The file; - is the standard output.")],
    rotate_mb: Annotated[
        float | None, typer.Option("--rotate", help="Begin a new file after so many megabytes.", min=0.001)
    ] = None,
    files: Annotated[int, typer.Option("--files", help="How many files to keep with --rotate.", min=1)] = 10,
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
) -> None:
    """Capture what passes on segments, CAN buses and at ports, as pcapng, until Ctrl-C.

    Live in Wireshark: hil capture bus0 -w - | wireshark -k -i -

    Example: hil capture bus0 -w bus0.pcapng

    A file of CAN buses named .log is as candump writes it, .asc and .blf as Vector's tools do.
    """
    from hil.cli.capture_files import is_log
    from hil.net.control_client import ControlError, begin
    from hil.wire.pcapng import CaptureError

    if rotate_mb and (write == "-" or is_log(write)):
        raise fail("hil: --rotate needs a file of pcapng", 2)
    try:
        client, _ = begin(bench_meant(bench, runtime_dir).socket, "capture", ports=sources)
    except ControlError as error:
        raise fail(f"hil: {error}") from None
    with client:
        try:
            with suppress(KeyboardInterrupt, BrokenPipeError), ended_by(partial(_hang_up, client)):
                _copy(client, write, round((rotate_mb or 0) * 1e6), files)
        except OSError as error:
            raise fail(f"hil: {write}: {error.strerror or error}") from None
        except CaptureError as error:
            raise fail(f"hil: {write}: {error}") from None


def _hang_up(client: Any) -> None:
    """Shut the connection down; what has come already can still be read."""
    import socket

    with suppress(OSError):  # the connection has ended by itself
        client.shutdown(socket.SHUT_RDWR)


def _copy(client: Any, write: str, rotate_bytes: int, files: int) -> None:
    from hil.cli.capture_files import blocks_of, capture_file

    file = capture_file(write, rotate_bytes, files)
    try:
        for blocks in blocks_of(client.recv):
            file.take(blocks)
    finally:
        file.close()


def decode(
    file: Annotated[
        Path,
        typer.Argument(
            help="A capture; .log, .asc and .blf are logs of CAN, - is the standard input.", metavar="FILE"
        ),
    ],
    eds: Annotated[
        list[str] | None,
        typer.Option("--eds", help="The EDS of a CANopen node, by its id, as in 5=drive.eds; for each node."),
    ] = None,
) -> None:
    """Print a capture's packets and frames as text: when, where, from whom to whom, what.

    Live: hil capture can0 -w - | hil decode -

    Exits with 1 if the file ends in the middle of a record; what is whole is printed.

    Example: hil decode bus0.pcapng
    """
    import os

    from hil.cli.capture_files import is_log, read_log, records_of
    from hil.cli.decoding import decoded, decoded_log
    from hil.wire.pcapng import CaptureError

    objects = dict(map(_eds, eds or []))
    if file == Path("-"):
        lines = decoded(records_of(partial(os.read, sys.stdin.fileno())), objects)
    elif is_log(file.name):
        lines = decoded_log(read_log(file, _content(file)), objects)
    else:
        lines = decoded(_content(file), objects)
    try:
        with suppress(KeyboardInterrupt):
            for line in lines:
                typer.echo(line)
    except CaptureError as error:
        raise fail(f"hil: {file}: {error}") from None


def _eds(text: str) -> tuple[int, Any]:
    from hil.wire.canopen.eds_names import EdsError, read_eds

    node, equals, name = text.partition("=")
    if not equals or not node.isdecimal() or not 1 <= int(node) <= 127:
        raise fail(f'hil: "{text}": write a node id of 1 to 127 and its file, as in 5=drive.eds', 2)
    try:
        return int(node), read_eds(_content(Path(name)).decode("utf-8", "replace"), int(node))
    except EdsError as error:
        raise fail(f"hil: {name}: {error}", 2) from None


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
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
) -> CommandAnswer:
    """Send what a capture has, at its own times, on a segment.

    Example: hil play bus0.pcapng bus0.master
    """
    from hil.wire.pcapng import CaptureError, bursts

    try:
        rows = bursts(_content(file), source)
    except CaptureError as error:
        raise fail(f"hil: {file}: {error}") from None
    answer = ask_bench(bench, runtime_dir, "play", tap=tap, bursts=rows)
    text = f"{len(rows)} bursts begin now, and take {rows[-1][0] / 1e9:.3f} s"
    return CommandAnswer({**answer, "bursts": len(rows), "takes_s": rows[-1][0] / 1e9}, text)
