"""The command that puts a recording into one file, for somebody else."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.command_answers import CommandAnswer, wants_json
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.progress_bars import bar
from hil.cli.recordings.opened import OfBench, named, refusals

if TYPE_CHECKING:
    from hil.host.doctor import Diagnosis
    from hil.recorded.bundling import Bundling

_DEVICES = 8
"""Devices for which the doctor judges this machine, as `hil doctor` does."""


def bundle(
    log: Annotated[
        Path, typer.Argument(help="A recording: its file, or its name in `hil recordings`, as last.")
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="The bundle. [default: the log's name with .hilz, here]"),
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", "-y", help="Do not ask.")] = False,
    bench: OfBench = None,
) -> CommandAnswer:
    """Put a recording into one file, with the boards it needs, versions and the doctor's report.

    `hil replay`, `hil find` and the others take the bundle as they take the log, on any computer. Lists what
    would be in it, and asks. Nothing secret goes in: doors with their users, keys and addresses, real boards,
    folders, names of hosts and users stay; what was typed at the boards goes in.

    Example: hil bundle bench.log -o bug.hilz --yes
    """
    from io import BytesIO

    from hil.host.new_file import write_file
    from hil.recorded.bundling import BundleRefused, bundling

    log = named(log)
    to = output or Path(log.name.removesuffix(".gz")).with_suffix(".hilz")
    with refusals(log):
        try:
            with bar(f"{log.name} is bundled"):
                made = bundling(log, _diagnoses())
        except BundleRefused as error:
            raise fail(f"hil: {error}", Exit.MISTAKE) from None
    if not yes:
        _ask(made, to)
    packed = BytesIO()
    with bar(f"{log.name} is packed"):
        made.write(packed)
    try:
        write_file(to, packed.getvalue())
    except OSError as error:
        raise fail(f"hil: {to}: {error.strerror or error}", Exit.MISTAKE) from None
    answer = {
        "bundle": str(to),
        "bytes": packed.tell(),
        "files": {name: {"bytes": each.size, "about": each.about} for name, each in made.files.items()},
        "boards": made.boards,
        "left_out": made.left_out,
    }
    return CommandAnswer(answer, f"{_listed(made, to)}\n{to}: {packed.tell():,} bytes")


def _ask(made: "Bundling", to: Path) -> None:
    if wants_json() or not sys.stdin.isatty():
        raise fail(
            f"hil: {_listed(made, to)}\nnothing was written: look at this, and give --yes", Exit.MISTAKE
        )
    typer.echo(_listed(made, to))
    if not typer.confirm(f"Write {to}?"):
        raise fail("hil: nothing was written", Exit.FAILED)


def _listed(made: "Bundling", to: Path) -> str:
    width = max(map(len, made.files))
    lines = [f"  {name:{width}}  {each.size:>10,} bytes  {each.about}" for name, each in made.files.items()]
    left_out = [f"Left out: {', '.join(made.left_out)}."] if made.left_out else []
    return "\n".join([f"{to} has:", *lines, *left_out])


def _diagnoses() -> "list[Diagnosis]":
    import os

    from hil.host.doctor import judge
    from hil.host.paths import runtime_base, state_base
    from hil.host.probes import try_all
    from hil.host.system import read_system

    runtime, state = runtime_base(None, None, os.environ), state_base(None, None, os.environ)
    return judge(read_system(), try_all(_DEVICES, runtime, state), _DEVICES)
