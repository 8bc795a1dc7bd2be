"""``hil shutdown``: the end of a running bench."""

import os
from contextlib import ExitStack, suppress
from pathlib import Path
from select import select

from hil.cli.framework.ask import ANY_BENCH, BenchOptions, fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.net.control_client import listener

END_S = 60.0
"""Maximum time in which a bench has to end: it writes what its boards have in flash."""


def shutdown(bench: BenchOptions = ANY_BENCH) -> CommandAnswer:
    """End a running bench as SIGTERM does, and wait until it has ended.

    What its boards keep in flash, and its logs, are written then. `hil stop` stops what moves, and ends no
    bench.

    Example: hil shutdown
    """
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
