"""``hil list``, ``hil status``, ``hil replay`` and ``hil doctor``."""

import json
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

import typer

from hil.cli.ask import Bench, RuntimeDir, ask_bench, fail, found
from hil.cli.serve_command import StateDir
from hil.cli.told import AsJson, CommandAnswer, tell_findings


def list_benches(runtime_dir: RuntimeDir = None, as_json: AsJson = False) -> None:
    """List running benches with their ports.

    Example: hil list
    """
    from hil.net.control_client import ControlError, ask

    benches = []
    for here in found(runtime_dir).benches:
        try:
            benches.append(ask(here.socket, "list"))
        except ControlError:
            continue  # the bench ended just now, or the socket is nobody's
    if as_json:
        typer.echo(json.dumps(benches))
        return
    if not benches:
        typer.echo("No bench is running here.")
        return
    from rich.console import Console

    from hil.cli.views import device_table

    console = Console(soft_wrap=True, markup=False)
    for listed in benches:
        console.print(device_table(listed))


def status(
    watch: Annotated[bool, typer.Option("--watch", "-w", help="Redraw twice a second until Ctrl-C.")] = False,
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
    as_json: AsJson = False,
) -> None:
    """Show the state of a bench: time, clients, lost bytes.

    Ticks and missed wakes, histograms of wake latency and firmware lag, and the state of each device.

    Example: hil status --watch
    """
    import time

    from rich.console import Console
    from rich.live import Live

    from hil.cli import interrupts as signals
    from hil.cli.views import status_view

    def answers() -> Iterator[dict[str, Any]]:
        yield ask_bench(bench, runtime_dir, "status")
        while watch and not signals.came:
            time.sleep(0.5)
            yield ask_bench(bench, runtime_dir, "status")

    console = Console(soft_wrap=True, markup=False)
    with suppress(KeyboardInterrupt):
        if as_json or not watch or not console.is_terminal:
            for answer in answers():
                typer.echo(json.dumps(answer)) if as_json else console.print(status_view(answer))
            return
        views = map(status_view, answers())
        with Live(next(views), console=console, screen=True) as live, suppress(typer.Exit):
            for view in views:
                live.update(view)
        if not signals.came:
            ask_bench(bench, runtime_dir, "status")  # why it has ended, on the screen that stays


def replay(
    log: Annotated[Path, typer.Argument(help="A file that `hil serve --log` wrote.")],
) -> CommandAnswer:
    """Run a log again and compare every byte.

    On the virtual clock; exits with 1 if a byte, a time or a state of an axis differs.

    Example: hil replay bench.log
    """
    from hil.compose.replay import replay as run
    from hil.config import ConfigError
    from hil.sim.inputs import InputLogError

    try:
        replayed = run(log)
    except InputLogError as error:
        raise fail(f"hil: {error}", 2) from None
    except ConfigError as error:
        raise fail(f"hil: {log}:1: the configuration of this log is refused:\n{error}", 2) from None
    except OSError as error:
        raise fail(f"hil: {log}: {error.strerror or error}", 2) from None
    if difference := replayed.difference():
        raise fail(f"different: {difference}")
    return CommandAnswer(
        {"identical": True, "summary": replayed.summary()}, f"identical: {replayed.summary()}"
    )


def doctor(
    devices: Annotated[
        int, typer.Option("--devices", min=1, max=512, help="Number of devices of the bench.")
    ] = 8,
    runtime_dir: RuntimeDir = None,
    state_dir: StateDir = None,
    as_json: AsJson = False,
) -> None:
    """Check whether this system is fit for real time.

    Tries what a bench needs. Prints each problem, its effect, and the line that corrects it. Exits with
    1 if something that matters is wrong.

    Example: hil doctor --devices 20
    """
    import os

    from hil.cli.doctor_benches import judge_benches, judge_memories
    from hil.host.doctor import judge, worst_first
    from hil.host.paths import runtime_base, state_base
    from hil.host.probes import try_all
    from hil.host.system import read_system

    runtime, state = runtime_base(runtime_dir, None, os.environ), state_base(state_dir, None, os.environ)
    findings = judge(read_system(), try_all(devices, runtime, state), devices)
    benches = judge_benches(runtime, runtime_dir is not None)
    findings = worst_first([*findings, *benches, *judge_memories(state)])
    tell_findings(findings, as_json)
