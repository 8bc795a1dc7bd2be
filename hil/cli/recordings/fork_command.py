"""``hil replay --serve``: a bench that goes on from a recording."""

import re
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from hil.cli.bench.serve_command import StateDir
from hil.cli.framework.ask import RuntimeDir, fail
from hil.cli.framework.command_answers import wants_json
from hil.cli.recordings.opened import named, opened, refusals, time_of

if TYPE_CHECKING:
    from hil.live.fork import Fork
    from hil.recorded.log_changes import LogChanges
    from hil.recorded.recorded_run import RecordedRun

_LONGEST_NAME = 32


class ForkOptions(NamedTuple):
    """Options of a bench that goes on from a recording."""

    serve: Annotated[
        bool,
        typer.Option(
            "--serve",
            help="Go on from --until, or from the end, as a bench with its ports, doors and own recording.",
        ),
    ] = False
    paused: Annotated[
        bool, typer.Option("--pause", help="With --serve: its time stands until `hil resume`.")
    ] = False
    name: Annotated[
        str | None,
        typer.Option(
            "--name", help="With --serve: name of the bench. [default: the recorded one's with -replay]"
        ),
    ] = None
    page: Annotated[
        bool, typer.Option("--page", help="With --serve: open the page, also if the recorded bench did not.")
    ] = False
    runtime_dir: RuntimeDir = None
    state_dir: StateDir = None
    own_log: Annotated[Path | None, typer.Option("--log", help="With --serve: record it in this file.")] = (
        None
    )
    ready_file: Annotated[
        Path | None,
        typer.Option("--ready-file", help="With --serve: write a JSON object to this file when it serves."),
    ] = None

    @property
    def unused(self) -> str | None:
        """An option that is given without --serve, or None."""
        given = {
            "--pause": self.paused,
            "--name": self.name,
            "--page": self.page,
            "--log": self.own_log,
            "--ready-file": self.ready_file,
        }
        return None if self.serve else next((flag for flag, value in given.items() if value), None)


def serve_fork(
    log: Path, options: ForkOptions, until: str | None, changes: "Callable[[RecordedRun], LogChanges]"
) -> None:
    """Serve a bench that goes on from a recording, until it is stopped. ``changes``: what is changed in it.
    Raises Exit with 2: it cannot be had."""
    import os

    from hil.cli.bench.served_until_stopped import serve_until_stopped
    from hil.daemon import Daemon
    from hil.host.journal import start_log
    from hil.host.notify import Notifier
    from hil.host.paths import log_file, runtime_base, state_base
    from hil.live.fork import Fork, fork_config
    from hil.recorded.time_words import time_text

    log = named(log, options.state_dir)
    with opened(log) as run:
        at_ns = run.end_ns if until is None else time_of("--until", until, run)
        reloads = run.log.reloads
        if reloads and at_ns >= (reload_ns := reloads[0].reload.at_ns):
            said = f"the bench was reloaded at {time_text(reload_ns)}; a fork begins before that"
            raise fail(f"hil: {said}: give an earlier --until", 2)
        asked = changes(run)
        source = f"{log} at {time_text(at_ns)}"
        absent = {name: str(device.at) for name, device in run.config.real.items()}
        is_changed, recorded = bool(asked.is_changed), run.config.bench
    left_out: dict[int, str] = {}
    fork = Fork(
        asked.log, at_ns, source, absent, options.paused, left_out.__setitem__ if is_changed else None
    )
    with refusals(log):
        base = runtime_base(options.runtime_dir, run.config.runtime_dir, os.environ)
        name = options.name or _free_name(recorded, base)
        config = fork_config(asked.log, name, with_page=options.page)
    writer = start_log(sys.stderr, os.environ)
    daemon = Daemon(
        config,
        config_folder=log.parent,
        runtime_base=base,
        state_base=state_base(options.state_dir, config.state_dir, os.environ, name),
        input_log=log_file(options.own_log, os.environ),
        fork=fork,
    )
    if not wants_json():
        for line in _head(fork):
            typer.echo(line)
    serve_until_stopped(daemon, base, name, writer, Notifier({}, 0), options.ready_file, as_json=wants_json())


def _head(fork: "Fork") -> "Iterator[str]":
    yield f"a fork of {fork.source}; what the recording has after that is not given to the boards"
    if fork.stands:
        yield "its time stands; `hil resume` lets it go on"
    yield from (each for each in (fork.log.damage, fork.log.cut) if each)
    for name, at in fork.absent.items():
        yield f"{name} is missing: it is a real board at {at}"


def _free_name(recorded: str, runtime: Path) -> str:
    """Name of a fork, of which none runs."""
    from hil.net.control_client import listener
    from hil.vocab.address import CONTROL_SOCKET

    stem = re.sub(r"-replay\d*$", "", recorded)[: _LONGEST_NAME - len("-replay99")]
    for number in range(1, 100):
        name = f"{stem}-replay{number if number > 1 else ''}"
        with suppress(OSError):
            if listener(runtime / name / CONTROL_SOCKET):
                continue
        return name
    raise fail("hil: 99 forks of this bench run already; give one a --name, or stop some", 2)
