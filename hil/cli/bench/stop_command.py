"""``hil stop``: the stop of axes, of all that moves on a bench, or on a site."""

import sys
from typing import Annotated

import typer

from hil.cli.framework.ask import ANY_BENCH, BenchOptions, fail
from hil.cli.framework.command_answers import CommandAnswer, pasteable, wants_json
from hil.cli.framework.exit_codes import Exit
from hil.cli.lab.lab_options import NO_LAB, LabOptions
from hil.cli.lab.site_stop_view import stop_site
from hil.host.journal import say

STOP_S = 15.0
"""Maximum wait for the answer: real boards have five seconds to confirm."""


def stop(
    axes: Annotated[
        list[str] | None,
        typer.Argument(help="Devices, or axes as arm.elbow; left out: all that moves.", show_default=False),
    ] = None,
    at_once: Annotated[
        bool, typer.Option("--at-once", help="Stop the axes immediately, not on their ramps.")
    ] = False,
    site: Annotated[
        bool, typer.Option("--site", help="Stop all that moves on all benches that are joined.")
    ] = False,
    timeout_s: Annotated[
        float,
        typer.Option(
            "--timeout", metavar="SECONDS", min=0.05, max=60, help="With --site: time to confirm in."
        ),
    ] = 1.0,
    lab: LabOptions = NO_LAB,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Stop axes, or all that moves: end its runs and drawings.

    It comes before all that waits at the bench. Does not wait until the axes stand. A run that has one of the
    axes ends, and its other axes stop, too. Exits with 1 if one is not stopped. The bench goes on; `hil
    shutdown` ends it.

    With --site it lists which benches have confirmed. Its exit code is 0 if all have.

    Example: hil stop

    Example: hil stop m1 s1
    """
    how = "prejudice" if at_once else "grace"
    if site:
        if axes:
            raise fail("hil: --site stops all that moves there; leave out the axes", Exit.MISTAKE)
        return stop_site(bench, lab, timeout_s, how)
    if lab.are_given:
        raise fail("hil: --connect and --config are of --site; without them this bench stops", Exit.MISTAKE)
    only = {"axes": axes} if axes else {}
    answer = bench.ask("halt", how=how, timeout_s=STOP_S, **only)
    lines = [f"{name}: cancelled" for name in answer["runs"]]
    lines += [f"{name}: stops" for name in answer["stopped"]]
    lines += [f"{name}: not stopped: {why}" for name, why in answer["refused"].items()]
    if not (axes or wants_json()) and (not lines or sys.stderr.isatty()):  # who typed it may mean the end
        say(pasteable("hil: the bench runs on; `hil shutdown` ends it"), sys.stderr)
    code = Exit.FAILED if answer["refused"] else Exit.DONE
    stands = f"{', '.join(axes)}: nothing moves" if axes else "nothing moves"
    return CommandAnswer(answer, "\n".join(lines or [stands]), code)
