"""``hil fault`` and ``hil capture``: what happens on lines."""

import json
from typing import Annotated, Any

import typer

from hil.daemon.ask import Bench, RuntimeDir, ask_bench, control_path, fail
from hil.vocab.faults import FAULT_KINDS

fault_app = typer.Typer(
    help="Make things go wrong, and well again.", no_args_is_help=True, rich_markup_mode=None
)


@fault_app.command()
def kinds() -> None:
    """List what can go wrong, with the parameters."""
    for kind in FAULT_KINDS.values():
        typer.echo(f"{kind.name}: {kind.about} (on a {kind.targets})")
        for parameter in kind.parameters:
            values = " or ".join(parameter.choices) or f"{parameter.minimum:g} to {parameter.maximum:g}"
            unit = f" {parameter.unit}" if parameter.unit else ""
            default = "needed" if parameter.default is None else f"default {parameter.default}"
            typer.echo(f"  {parameter.name}: {parameter.about}, {values}{unit}, {default}")


@fault_app.command()
def inject(
    fault: Annotated[str, typer.Argument(help="Its kind; `hil fault kinds` lists them.")],
    target: Annotated[str, typer.Argument(help="What it is on, as in s2.")],
    parameters: Annotated[list[str] | None, typer.Argument(help="As in rate=0.01 towards=board.")] = None,
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
) -> None:
    """Make something go wrong, until it is cleared."""
    given = dict(_parameter(text) for text in parameters or [])
    answer = ask_bench(bench, runtime_dir, "inject", fault=fault, target=target, parameters=given)
    typer.echo(f"fault {answer['number']}")


def _parameter(text: str) -> tuple[str, Any]:
    name, equals, value = text.partition("=")
    if not equals:
        raise fail(f'hil: "{text}" is no parameter; write it as in rate=0.01', 2)
    try:
        return name, json.loads(value)
    except ValueError:
        return name, value


@fault_app.command()
def clear(
    number: Annotated[
        int | None, typer.Argument(help="Of `hil fault list`; left out: all of them.", show_default=False)
    ] = None,
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
) -> None:
    """Take a fault away, or all."""
    active = ask_bench(bench, runtime_dir, "faults")
    for each in [number] if number is not None else [row["number"] for row in active]:
        ask_bench(bench, runtime_dir, "clear", number=each)


@fault_app.command("list")
def list_faults(bench: Bench = None, runtime_dir: RuntimeDir = None) -> None:
    """List the faults that are active."""
    rows = ask_bench(bench, runtime_dir, "faults")
    for row in rows:
        parameters = " ".join(f"{name}={value}" for name, value in row["parameters"].items())
        typer.echo(
            f"{row['number']}: {row['kind']} {row['target']} {parameters}, {row['changed_bytes']} bytes"
        )
    if not rows:
        typer.echo("no fault is active")


def capture(
    ports: Annotated[list[str], typer.Argument(help="Ports by name, as in s2 or s1.network.")],
    write: Annotated[str, typer.Option("--write", "-w", help="The file; - is the standard output.")],
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
) -> None:
    """Capture what passes at ports, as pcapng, until Ctrl-C.

    Live in Wireshark: hil capture s2 -w - | wireshark -k -i -
    """
    import socket
    import sys
    from contextlib import suppress

    path = control_path(bench, runtime_dir)
    with socket.socket(socket.AF_UNIX) as client:
        client.connect(str(path))
        client.sendall(json.dumps({"verb": "capture", "ports": ports}).encode() + b"\n")
        stream = client.makefile("rb", buffering=0)
        line = b""
        while not line.endswith(b"\n") and (byte := stream.read(1)):
            line += byte
        answer = json.loads(line)
        if not answer["ok"]:
            raise fail(f"hil: {answer['error']}")
        try:
            out = sys.stdout.buffer if write == "-" else open(write, "wb")  # noqa: SIM115
        except OSError as error:
            raise fail(f"hil: {write}: {error.strerror}") from None
        with suppress(KeyboardInterrupt, BrokenPipeError):
            while data := client.recv(65536):
                out.write(data)
                out.flush()
