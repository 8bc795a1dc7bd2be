"""``hil sketch gdb``: a port at which GDB debugs a program in a running bench."""

import select
import socket
from contextlib import suppress
from typing import Annotated, Any

import typer

from hil.cli.framework.ask import ANY_BENCH, BenchOptions, DeviceName, fail
from hil.cli.framework.exit_codes import Exit

LOOPBACK = "127.0.0.1"
_PIECE = 1 << 16


def gdb(
    device: DeviceName,
    port: Annotated[
        int, typer.Option("--port", help="TCP port of this computer; 0: a free one.", min=0, max=65535)
    ] = 1234,
    once: Annotated[bool, typer.Option("--once", help="End when GDB leaves.")] = False,
    bench: BenchOptions = ANY_BENCH,
) -> None:
    """Let GDB debug the program of a board, by its remote protocol.

    Prints the line that starts GDB. While the program stands, at a breakpoint or between steps, the time of
    the bench stands with it. It goes on when GDB leaves, and when this command ends, with Ctrl-C.

    Example: hil sketch gdb u1 --port 1234 --once
    """
    chip = bench.ask("processor", device=device)
    if not chip["is_running"]:
        raise fail(
            f"hil: {device} runs no compiled program now; `hil sketch load {device} FILE` gives it one",
            Exit.FAILED,
        )
    with _listening(port) as listener, suppress(KeyboardInterrupt):
        number = listener.getsockname()[1]
        typer.echo(f'{device} is there for GDB: avr-gdb -ex "target remote :{number}" PROGRAM.elf')
        typer.echo("Ctrl-C ends; the program goes on then")
        while True:
            client, _ = listener.accept()
            with client:
                _serve(bench, device, client)
            if once:
                return


def _listening(port: int) -> socket.socket:
    try:
        return socket.create_server((LOOPBACK, port), backlog=1)
    except OSError as error:
        from hil.net.listeners import refusal

        why = refusal(error, f"{LOOPBACK}:{port}", LOOPBACK, port)
        raise fail(f"hil: --port: {why}", Exit.MISTAKE) from None


def _serve(bench: BenchOptions, device: str, gdb: socket.socket) -> None:
    """Carry what GDB and the bench say to each other, until one of them leaves."""
    from hil.net.control_client import ControlError, begin

    try:
        daemon, _ = begin(bench.meant().socket, "debug", device=device)
    except ControlError as error:
        typer.echo(f"hil: {error}", err=True)  # a later GDB may have more luck
        return
    with daemon:
        typer.echo(f"GDB has come: {device} stands")
        _relay(gdb, daemon)
    typer.echo("GDB has left")


def _relay(one: socket.socket, other: socket.socket) -> None:
    ways: dict[Any, socket.socket] = {one: other, other: one}
    while True:
        for ready in select.select(list(ways), [], [])[0]:
            try:
                data = ready.recv(_PIECE)
                if not data:
                    return
                ways[ready].sendall(data)
            except ConnectionError:
                return
