"""``hil halt``: the stop of all that moves."""

from typing import Annotated

import typer

from hil.cli.framework.ask import ANY_BENCH, BenchOptions
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.framework.exit_codes import Exit


def halt(
    at_once: Annotated[
        bool, typer.Option("--at-once", help="Stop the axes immediately, not on their ramps.")
    ] = False,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Stop all that moves: end all runs and drawings, stop all axes.

    It comes before all that waits at the bench. Does not wait until the axes stand. The bench goes on; `hil
    stop` ends it.

    Example: hil halt
    """
    answer = bench.ask("halt", how="prejudice" if at_once else "grace")
    lines = [f"{name}: cancelled" for name in answer["runs"]]
    lines += [f"{name}: stops" for name in answer["stopped"]]
    lines += [f"{name}: not stopped: {why}" for name, why in answer["refused"].items()]
    code = Exit.FAILED if answer["refused"] else Exit.DONE
    return CommandAnswer(answer, "\n".join(lines or ["nothing moves"]), code)
