"""A daemon that serves as long as its command runs."""

import asyncio
import re
from pathlib import Path
from typing import TYPE_CHECKING

from hil.cli.bench.ready import Telling
from hil.cli.bench.started import started
from hil.cli.framework.ask import fail
from hil.daemon import Daemon, Serving
from hil.host.notify import Notifier
from hil.host.process import allow_many_files, give_large_blocks_back
from hil.live.refusals import StartError

if TYPE_CHECKING:
    from hil.host.log_writer import LogWriter


def serve_until_stopped(
    daemon: Daemon,
    runtime: Path,
    bench: str,
    writer: "LogWriter",
    notifier: Notifier,
    ready_file: Path | None,
    *,
    as_json: bool,
) -> None:
    """Run a daemon until it is stopped, and tell what it has. Raises Exit with 2: it cannot start."""
    allow_many_files()
    give_large_blocks_back()
    try:
        telling = Telling(runtime / bench, ready_file, writer if as_json else None)

        def begun(serving: Serving) -> None:
            if not as_json:
                started(serving, writer, runtime)
            telling.begin(serving)

        try:
            asyncio.run(daemon.run(begun))
        finally:
            telling.end()
            writer.close()
    except StartError as error:
        notifier.status(str(error))
        has_place = re.match(r"[^\n:]+:[1-9]\d*:[1-9]\d*: ", str(error))
        raise fail(str(error) if has_place else f"hil: {error}", 2) from None
