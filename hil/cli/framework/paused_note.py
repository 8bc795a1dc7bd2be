"""Word for people who wait in simulated time at a bench whose time stands."""

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_AFTER_S = 1.5
"""Time after which somebody who waits wonders why."""
_PATIENCE_S = 2.0


@contextmanager
def told_if_paused(socket: Path) -> Iterator[None]:
    """Say on the standard error that the bench is paused, if it is when the block takes long."""
    ended = threading.Event()
    threading.Thread(target=_tell, args=(socket, ended), daemon=True).start()
    try:
        yield
    finally:
        ended.set()


def _tell(socket: Path, ended: threading.Event) -> None:
    from hil.cli.framework.command_answers import pasteable
    from hil.host.journal import say
    from hil.net.control_client import ControlError, ask

    if ended.wait(_AFTER_S):
        return
    try:
        is_paused = ask(socket, "status", timeout_s=_PATIENCE_S).get("is_paused")
    except ControlError:
        return
    if is_paused and not ended.is_set():
        name = socket.parent.name
        say(pasteable(f"hil: bench {name} is paused, and nothing goes on; `hil resume` lets it"), sys.stderr)
