"""``hil status``, ``hil reset``, ``hil pin``, ``hil set`` and ``hil zero``: one device."""

import os
import signal
from typing import Annotated, Any

import typer

from hil.cli.boards.axis_sentences import VerbDone, sentence
from hil.cli.framework.ask import ANY_BENCH, BenchOptions, DeviceName, fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.named_bench import with_meaning
from hil.cli.framework.shown_words import shown_number
from hil.vocab.near_words import meant
from hil.vocab.port_programs import is_held
from hil.vocab.typed_numbers import number_problem, typed_number, unit_in

SHARED = "socket://", "rfc2217://"
"""Beginnings of addresses of ports that give each client all that the device says."""


def open_address(bench: BenchOptions, device: str) -> tuple[dict[str, Any], str]:
    """Row of a device, or of another port of one, in `list`, and the address that clients open."""
    rows = port_rows(bench.ask("list")["devices"])
    if device not in rows:
        why = f"no device {device!r}; {meant(device, list(rows))}"
        raise fail(with_meaning(bench.meant().socket, device, why), 2)
    if rows[device]["address"] is None:
        reach = f"; its axis is reached by `hil axis {device}`" if rows[device]["axes"] else ", nor an axis"
        raise fail(f"hil: {device}, a {rows[device]['profile']}, has no serial port{reach}")
    if is_held(rows[device].get("kind", rows[device].get("port"))):
        address = rows[device]["address"]
        raise fail(f"hil: {device} is at the other end of {address}: hil itself has this end open")
    return rows[device], bench.port_of(rows[device]["address"])


def port_rows(devices: list[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """Rows of devices, and of their other ports, in an answer to `list`, by the names that are typed."""
    rows = {row["device"]: row for row in devices}
    return rows | {name: port for row in devices for name, port in row["ports"].items()}


def reset(device: DeviceName, bench: BenchOptions = ANY_BENCH) -> CommandAnswer:
    """Switch a device off and on; its flash stays.

    Example: hil reset m1
    """
    return CommandAnswer(bench.ask("reset", device=device), f"{device}: off and on again")


def pin(
    device: DeviceName,
    name: Annotated[
        str, typer.Argument(help="As in D2 of a Mechaduino, sync of a SAC; a wrong one lists them.")
    ],
    level: Annotated[str, typer.Argument(help="0 or 1.")],
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Drive an input pin of a device.

    Example: hil pin m1 D2 0
    """
    answer = bench.ask("pin", device=device, pin=name, level=typed_number(level))
    return CommandAnswer(answer, f"{device}: {name} is {level}")


def set_field(
    device: DeviceName,
    field: Annotated[str, typer.Argument(help="As load_torque_Nm, diaagc or pKp; a wrong one lists them.")],
    value: Annotated[str, typer.Argument(help="The value, in the unit that the name ends in.")],
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Set the load on a shaft, an encoder register or a gain.

    Example: hil set m1 load_torque_Nm 0.05
    """
    unit, number = unit_in(field), typed_number(value)
    if isinstance(number, str):
        raise fail(f"{field}: {'; '.join(number_problem(number, unit))}", 2)
    answer = bench.ask("set", device=device, field=field, value=number)
    return CommandAnswer(answer, f"{device}: {field} is {shown_number(number)} {unit}".rstrip())


def state(device: DeviceName, bench: BenchOptions = ANY_BENCH) -> CommandAnswer:
    """Show all fields of an axis, with their units.

    Example: hil status m1
    """
    from hil.cli.bench.views import field_lines

    fields = bench.ask("state", device=device)
    return CommandAnswer(fields, "\n".join(field_lines(fields)))


def zero(device: DeviceName, bench: BenchOptions = ANY_BENCH) -> CommandAnswer:
    """Let the angle that hil shows of a shaft be 0 where it is now.

    It is the zero of position_deg, as of a dial at the shaft. Nothing turns. The board knows nothing of it: a
    servo's set-points and move-abs go by the board's own angle. A stepper's board has none: its move-abs and
    its runs count from this zero.

    Example: hil zero m1
    """
    answer = bench.ask("zero", device=device)
    return CommandAnswer(answer, sentence(VerbDone(device, "zero", {}, answer)))


_IGNORED_BY_PYTHON = (signal.SIGPIPE, signal.SIGXFSZ)


def with_lines(
    program: Annotated[list[str], typer.Argument(help="A program, and what it is given.")],
) -> None:
    """Start a program for which pseudo-terminals have modem lines.

    For programs that refuse a port without them, as CuteCom and GTKTerm, or that set DTR and RTS. They read
    DTR and RTS as they set them, and CTS, DSR and carrier as on. The lines end in the program: the board
    does not notice them, nor do other programs.

    It works by a library that the program loads (LD_PRELOAD), and so do the programs that it starts. A
    program that is linked statically, as those in Go, or that runs with the rights of another user (set-id)
    loads none. The exit code is the program's.

    Example: hil with-lines cutecom
    """
    from hil.host.preload import PreloadRefused, find_program, with_library

    try:
        path, env = find_program(program[0], os.environ), with_library(os.environ)
    except PreloadRefused as error:
        raise fail(f"hil: {error}", Exit.MISTAKE) from None
    for number in _IGNORED_BY_PYTHON:
        signal.signal(number, signal.SIG_DFL)
    try:
        os.execve(path, program, env)
    except OSError as error:
        raise fail(f"hil: {path}: {error.strerror}", Exit.MISTAKE) from None
