"""``hil stop``: the end of a running bench, or the stop of all that moves on a site."""

import os
from contextlib import ExitStack, suppress
from pathlib import Path
from select import select
from typing import Annotated

import typer

from hil.cli.framework.ask import ANY_BENCH, BenchOptions, fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.lab.lab_options import NO_LAB, LabOptions
from hil.cli.lab.site_stop_view import stop_site
from hil.net.control_client import listener

END_S = 60.0
"""Maximum time in which a bench has to end: it writes what its boards have in flash."""


def stop(
    site: Annotated[
        bool,
        typer.Option("--site", help="Stop all that moves on all benches that are joined, and end none."),
    ] = False,
    timeout_s: Annotated[
        float,
        typer.Option(
            "--timeout",
            metavar="S",
            min=0.05,
            max=60,
            help="With --site: seconds to confirm in.",
        ),
    ] = 1.0,
    at_once: Annotated[
        bool,
        typer.Option("--at-once", help="With --site: stop the axes immediately, not on their ramps."),
    ] = False,
    lab: LabOptions = NO_LAB,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """End a running bench as SIGTERM does, and wait until it has ended.

    What its boards keep in flash, and its logs, are written then. With --site no bench ends: on each all runs
    end and all axes stop, as by `hil halt`, and the command lists which benches have confirmed. Its exit code
    is 0 if all have.

    Example: hil stop
    """
    if site:
        return stop_site(bench, lab, timeout_s, "prejudice" if at_once else "grace")
    if lab.are_given or at_once:
        raise fail("hil: --connect, --config and --at-once are of --site; `hil halt` stops this bench", 2)
    here = bench.meant()
    with ExitStack() as stack:
        process = _process(here.socket)
        if process is not None:
            stack.callback(os.close, process)
        bench.ask("stop")
        if process is not None and not select([process], [], [], END_S)[0]:
            raise fail(f"hil: bench {here.name} still runs after {END_S:g} s: {here.line()}")
    return CommandAnswer({"bench": here.name, "stopped": True}, f"bench {here.name} has ended")


def _process(socket: Path) -> int | None:
    """Descriptor of the process behind a control socket; None: it has ended, or is that of a container."""
    with suppress(OSError):
        return os.pidfd_open(listener(socket))
    return None
