"""``hil list``, ``hil status``, ``hil reload`` and ``hil doctor``."""

import json
import sys
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

import typer

from hil.cli.bench.serve_command import StateDir
from hil.cli.framework.ask import ANY_BENCH, Bench, BenchOptions, RuntimeDir, benches_meant, fail, found
from hil.cli.framework.command_answers import AsJson, CommandAnswer, pasteable
from hil.cli.lab.lab_options import NO_LAB, EverySeconds, LabelWords, LabOptions, PrometheusFile

RELOAD_S = 60.0


def list_benches(
    bench: Bench = None,
    programs: Annotated[
        bool, typer.Option("--programs", help="Which programs can use each port, and what helps the others.")
    ] = False,
    joined: Annotated[
        bool, typer.Option("--joined", help="The benches that are joined to this one instead.")
    ] = False,
    lab: LabOptions = NO_LAB,
    label: LabelWords = None,
    prometheus: PrometheusFile = None,
    every_s: EverySeconds = None,
    runtime_dir: RuntimeDir = None,
    as_json: AsJson = False,
) -> None:
    """List running benches with their ports; or those that are joined, or a lab's.

    With --bench that one alone. With --joined: those joined to it, with the offsets of their clocks. With
    --connect or --config, from any computer: health with its reason, runs, who commands, versions, labels.

    Example: hil list

    Example: hil list --connect tcp/127.0.0.1:7447 --label rig=press
    """
    if joined or lab.are_given or label or prometheus or every_s:
        from hil.cli.lab.benches_command import benches as elsewhere

        told = elsewhere(lab, label, prometheus, every_s, BenchOptions(bench, runtime_dir))
        if as_json or told.text:
            typer.echo(json.dumps(told.answer) if as_json else pasteable(told.text))
        return
    _list_here(bench, programs, runtime_dir, as_json)


def _list_here(bench: str | None, programs: bool, runtime_dir: Path | None, as_json: bool) -> None:
    """List the benches that run on this computer."""
    import os

    from hil.cli.bench.port_views import as_json as programs_as_json
    from hil.host.journal import say
    from hil.net.control_client import BenchEnded, ControlError, ask

    here = found(runtime_dir)
    benches, options, silent = [], [], []
    for each in here.benches if bench is None else benches_meant(bench, here):
        try:
            benches.append(ask(each.socket, "list"))
            options.append(here.options(each.folder, runtime_dir, os.environ))
        except BenchEnded:
            continue  # it ended after it was found: it does not run
        except ControlError as error:
            silent.append(f"hil: {error}")
    if silent and not benches:
        raise fail("\n".join(silent))
    for why in silent:
        say(why, sys.stderr)
    if as_json:
        more = [{"programs": programs_as_json(listed)} if programs else {} for listed in benches]
        typer.echo(json.dumps([listed | each for listed, each in zip(benches, more, strict=True)]))
    elif not benches:
        said = here.none_runs()
        typer.echo(f"{said[0].upper()}{said[1:]}.")
    else:
        _tell_benches(benches, options, programs)
    if silent:
        raise typer.Exit(1)


def _tell_benches(benches: list[dict[str, Any]], options: list[list[str]], programs: bool) -> None:
    """Print the answers of benches to ``list``. ``options``: those with which commands ask each."""
    from hil.cli.bench.port_views import HINT, program_view
    from hil.cli.bench.views import device_table
    from hil.cli.framework.command_answers import all_pasteable
    from hil.cli.framework.shown_view import ShownView, line

    if programs:
        for listed in benches:
            program_view(listed).print()
        return
    for listed, words in zip(benches, options, strict=True):
        device_table(all_pasteable(listed, words)).print()
    ShownView(line(HINT, wraps=True)).print()


def status(
    axes: Annotated[
        list[str] | None,
        typer.Argument(help="Show all fields of these axes instead, with their units.", show_default=False),
    ] = None,
    watch: Annotated[bool, typer.Option("--watch", "-w", help="Old name of `hil top`.", hidden=True)] = False,
    bench: BenchOptions = ANY_BENCH,
    as_json: AsJson = False,
) -> None:
    """Show the state of a bench, or all fields of axes.

    Of a bench: time, clients, lost bytes, ticks and missed wakes, histograms of wake latency and firmware
    lag, and the state of each device.

    Example: hil status
    """
    import time

    from hil.cli.bench.views import fields_view, status_view
    from hil.cli.framework import interrupts as signals
    from hil.cli.framework.command_answers import all_pasteable
    from hil.cli.framework.shown_view import is_terminal

    if watch:
        from hil.cli.framework.command_group import say_renamed

        say_renamed("hil status --watch", "hil top")
        if not as_json and is_terminal():
            from hil.cli.bench.top_command import top

            top(None, bench=bench)
            return
    with suppress(KeyboardInterrupt):
        while not signals.came:
            fields = {axis: bench.ask("state", device=axis) for axis in axes or ()}
            answer = fields or bench.ask("status")
            view = fields_view(answer) if axes else status_view(all_pasteable(answer))
            typer.echo(json.dumps(answer)) if as_json else view.print()
            if not watch:
                return
            time.sleep(0.5)


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

    from hil.cli.bench.doctor_benches import judge_benches, judge_memories
    from hil.cli.bench.views import tell_findings
    from hil.cli.framework.progress_bars import bar
    from hil.host.doctor import judge, worst_first
    from hil.host.paths import runtime_base, state_base
    from hil.host.probes import try_all
    from hil.host.system import read_system

    runtime, state = runtime_base(runtime_dir, None, os.environ), state_base(state_dir, None, os.environ)
    with bar("this computer is tried"):
        findings = judge(read_system(), try_all(devices, runtime, state), devices)
        benches = judge_benches(runtime, runtime_dir is not None)
        findings = worst_first([*findings, *benches, *judge_memories(state)])
    tell_findings(findings, as_json)


def pause(bench: BenchOptions = ANY_BENCH) -> CommandAnswer:
    """Let the time of a running bench stand.

    Boards answer nothing, and what programs send to them waits. Verbs and faults take effect, at the time
    that stands. A bench with something real in it cannot stand.

    Example: hil pause
    """
    answer = bench.ask("pause")
    return CommandAnswer(answer, f"paused at {answer['sim_ns'] / 1e9:.9f} s; `hil resume` lets it go on")


def resume(bench: BenchOptions = ANY_BENCH) -> CommandAnswer:
    """Let the time of a paused bench go on from where it stands.

    Example: hil resume
    """
    answer = bench.ask("resume")
    return CommandAnswer(answer, f"goes on from {answer['sim_ns'] / 1e9:.9f} s")


def reload(
    bench: BenchOptions = ANY_BENCH,
    as_json: AsJson = False,
) -> None:
    """Apply the changed configuration to a running bench.

    Devices that did not change go on, with their clients. Exits with 2 if the configuration has problems and
    with 1 if it cannot be had without a restart; nothing has changed then.

    Example: hil reload
    """
    from hil.cli.framework.progress_bars import bar

    with bar("the bench takes the configuration"):
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
