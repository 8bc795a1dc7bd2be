"""``hil reload``."""

import json
from typing import Annotated

import typer

from hil.cli.ask import ANY_BENCH, BenchOptions, fail

RELOAD_S = 60.0


def reload(
    bench: BenchOptions = ANY_BENCH,
    as_json: Annotated[bool, typer.Option("--json", help="JSON for programs.")] = False,
) -> None:
    """Apply the changed configuration to a running bench.

    Devices that did not change go on, with their clients. Exits with 2 if the configuration has problems and
    with 1 if it cannot be had without a restart; nothing has changed then.

    Example: hil reload
    """
    done = bench.ask("reload", timeout_s=RELOAD_S)
    if "problems" in done:
        raise fail(done["problems"], 2)
    if as_json:
        typer.echo(json.dumps(done))
        return
    for word in ("removed", "restarted", "added"):
        if done[word]:
            typer.echo(f"{word}: {', '.join(done[word])}")
    count = len(done["kept"])
    typer.echo(f"{count} device{'' if count == 1 else 's'} went on")
