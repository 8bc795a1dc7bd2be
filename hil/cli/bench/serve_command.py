"""``hil serve``, and the reader of configurations."""

import json
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from hil.cli.framework.ask import RuntimeDir, fail
from hil.vocab.problem import not_text

Config = Annotated[Path, typer.Argument(help="The bench's configuration (YAML).", show_default=False)]
StateDir = Annotated[
    Path | None,
    typer.Option("--state-dir", help="Folder of memories and recordings. [default: $XDG_STATE_HOME/hil]"),
]


def serve(
    config: Config,
    runtime_dir: RuntimeDir = None,
    state_dir: StateDir = None,
    require_rt: Annotated[
        bool,
        typer.Option("--require-rt", help="Exit with 2 if real-time priority or locked memory is refused."),
    ] = False,
    port_group: Annotated[
        str | None,
        typer.Option("--port-group", help="Group of ptys whose `group:` is null.", metavar="GROUP"),
    ] = None,
    log: Annotated[
        Path | None,
        typer.Option(
            "--log", help="Record the run in this file, packed if it ends in .gz, not in --state-dir."
        ),
    ] = None,
    no_log: Annotated[bool, typer.Option("--no-log", help="Do not record the run.")] = False,
    ready_file: Annotated[
        Path | None,
        typer.Option("--ready-file", help="Write a JSON object to this file when the boards answer."),
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print only this object, when the boards answer.")
    ] = False,
    detached: Annotated[
        bool,
        typer.Option("--detach", help="End when the boards answer; the bench goes on until `hil shutdown`."),
    ] = False,
) -> None:
    """Run a bench until Ctrl-C or SIGTERM.

    The run is recorded in its folder in --state-dir, for `hil recordings`. With --detach it goes on in the
    background, and writes its log into its folder in --state-dir.

    Example: hil serve bench.yaml
    """
    if no_log and log is not None:
        raise fail("hil: --no-log records nothing, --log records in a file: give one", 2)
    if detached:
        given = {
            "--runtime-dir": runtime_dir,
            "--state-dir": state_dir,
            "--port-group": port_group,
            "--log": log,
            "--ready-file": ready_file,
        }
        words = [word for flag, value in given.items() if value is not None for word in (flag, str(value))]
        words += [flag for flag, is_on in {"--require-rt": require_rt, "--no-log": no_log}.items() if is_on]
        _detach(config, words, state_dir, as_json)
        return
    import logging
    import os

    from hil.cli.bench.served_until_stopped import serve_until_stopped
    from hil.daemon import Daemon
    from hil.host.journal import start_log
    from hil.host.notify import Notifier
    from hil.host.paths import log_file, runtime_base, state_base

    writer = start_log(sys.stderr, os.environ)
    notifier = Notifier(os.environ, os.getpid())
    try:
        bench = read_config(config)
    except typer.Exit:
        notifier.status(f"{config} has problems; the log lists them")
        raise
    for problem in bench.written.old_keys:
        logging.getLogger("hil").warning("%s", problem)
    runtime = runtime_base(runtime_dir, bench.runtime_dir, os.environ, bench.bench)
    daemon = Daemon(
        bench,
        config_folder=config.parent,
        config_file=config,
        runtime_base=runtime,
        state_base=state_base(state_dir, bench.state_dir, os.environ, bench.bench),
        input_log=log_file(log, os.environ),
        is_recorded=not no_log,
        require_rt=require_rt,
        port_group=port_group,
        notifier=notifier,
    )
    serve_until_stopped(daemon, runtime, bench.bench, writer, notifier, ready_file, as_json=as_json)


def _detach(config: Path, words: list[str], state_dir: Path | None, as_json: bool) -> None:
    """Start this command again without --detach, with the options ``words``, and tell what it has."""
    import os

    from hil.cli.bench.detached import detach, report_lines
    from hil.host.paths import state_base

    bench = read_config(config)
    state = state_base(state_dir, bench.state_dir, os.environ, bench.bench) / bench.bench
    report = detach([*words, str(config)], state)
    typer.echo(json.dumps(report) if as_json else "\n".join(report_lines(report)))


def read_config(path: Path, *, opens_bridges: bool = True) -> Any:
    """Read a configuration. Raises typer.Exit: it has problems, which were said. ``opens_bridges``: whether
    its bridges are to be opened."""
    from hil.config.document_kinds import OtherKindError

    try:
        return config_of(path, opens_bridges=opens_bridges)
    except OtherKindError as error:
        raise fail(str(error), 2) from None


def config_of(path: Path, *, opens_bridges: bool = True) -> Any:
    """Read a configuration as ``read_config``. Raises OtherKindError: it is a document of another kind."""
    from hil.compose import find_catalogue
    from hil.config import ConfigError, parse
    from hil.config.document_kinds import OtherKindError

    text = ""
    try:
        text = path.read_text("utf-8-sig")  # also from a shell's `<(...)`, which is a pipe
        return parse(text, str(path), find_catalogue(), opens_bridges=opens_bridges)
    except OtherKindError as error:
        error.text = text
        raise
    except ConfigError as error:
        raise fail(str(error), 2, {str(path): text}) from None
    except UnicodeDecodeError as error:
        raise fail(str(not_text(str(path), error)), 2) from None
    except OSError as error:
        raise fail(f"hil: {path}: {error.strerror}", 2) from None
