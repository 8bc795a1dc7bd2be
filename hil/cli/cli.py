"""The command ``hil``. Imports what a command needs when it runs, so that each starts quickly."""

import json
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from hil.cli import arduino_commands as arduino
from hil.cli import (
    axis_command,
    board_commands,
    can_commands,
    draw_commands,
    line_commands,
    profile_commands,
    reload_command,
    run_command,
)
from hil.cli.ask import Bench, DeviceName, RuntimeDir, ask_bench, fail, found, port_of
from hil.cli.serve_command import Config, StateDir, command_line, read_config

app = command_line(board_commands.WithOthers)

AsJson = Annotated[bool, typer.Option("--json", help="JSON for programs.")]


@app.command()
def check(
    config: Config,
    diff: Annotated[
        Path | None,
        typer.Option("--diff", help="An older configuration: say what a reload would do.", metavar="OLD"),
    ] = None,
) -> None:
    """Check a configuration and list all its problems.

    Each comes with file:line:column and a remedy.
    """
    from hil.compose import find_catalogue
    from hil.compose.build import TableFileError, start_sections

    bench = read_config(config)
    problems, boards = [], find_catalogue(path=bench.profile_path).boards
    for name, device in bench.devices.items():
        try:
            start_sections(device, boards[device.profile], {}, config.parent)
        except TableFileError as error:
            problems.append(f"{config}: devices.{name}.flash.table: {error}")
    if problems:
        raise fail("\n".join(problems), 2)
    if diff is None:
        besides = profile_commands.say_what_is_spoilt(bench)
        typer.echo(f"{config}: bench {bench.bench}, {len(bench.devices)} device(s), no problems{besides}")
        return
    from hil.config import diff as difference

    for change in difference(read_config(diff, opens_bridges=False), bench):
        why = f" ({'; '.join(change.why)})" if change.why else ""
        typer.echo(f"{change.action:8}{change.device or 'the whole bench'}{why}")


@app.command()
def schema(
    config: Annotated[
        Path | None, typer.Argument(help="A configuration, whose own boards (profile_path) are known too.")
    ] = None,
) -> None:
    """Print the configuration's JSON Schema, for editors."""
    from hil.compose import find_catalogue
    from hil.config import schema as json_schema

    path = read_config(config).profile_path if config else ()
    typer.echo(json.dumps(json_schema(find_catalogue(path=path)), indent=2))


@app.command("list")
def list_benches(runtime_dir: RuntimeDir = None, as_json: AsJson = False) -> None:
    """List running benches and where their ports are."""
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


@app.command()
def status(
    watch: Annotated[bool, typer.Option("--watch", "-w", help="Redraw twice a second until Ctrl-C.")] = False,
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
    as_json: AsJson = False,
) -> None:
    """Show how a bench does: time, clients, drops.

    Ticks and missed wakes, histograms of wake latency and firmware lag, and the state of each device.
    """
    if as_json:
        typer.echo(json.dumps(ask_bench(bench, runtime_dir, "status")))
        return
    from rich.console import Console

    from hil.cli.views import status_view

    console = Console(soft_wrap=True, markup=False)
    if not watch:
        console.print(status_view(ask_bench(bench, runtime_dir, "status")))
        return
    import time

    from rich.live import Live

    from hil.cli import interrupts as signals

    try:
        with Live(status_view(ask_bench(bench, runtime_dir, "status")), console=console, screen=True) as live:
            while not signals.came:
                time.sleep(0.5)
                live.update(status_view(ask_bench(bench, runtime_dir, "status")))
    except KeyboardInterrupt:
        return


@app.command()
def monitor(device: DeviceName, bench: Bench = None, runtime_dir: RuntimeDir = None) -> None:
    """Talk to a device in this terminal; Ctrl-] ends."""
    from hil.cli.monitor import monitor as run
    from hil.net.port_client import PortUnreachable

    rows = {row["device"]: row for row in ask_bench(bench, runtime_dir, "list")["devices"]}
    rows |= {name: port for row in list(rows.values()) for name, port in row["ports"].items()}
    if device not in rows:
        raise fail(f"hil: no device {device!r}; there are {', '.join(rows)}")
    if rows[device]["address"] is None:
        reach = f"; its axis is reached by `hil axis {device}`" if rows[device]["axes"] else ", nor an axis"
        raise fail(f"hil: {device}, a {rows[device]['profile']}, has no serial port{reach}")
    address = port_of(rows[device]["address"], bench, runtime_dir)
    try:
        with suppress(KeyboardInterrupt):
            run(address)
    except PortUnreachable as error:
        raise fail(f"hil: {error}") from None


@app.command()
def reset(device: DeviceName, bench: Bench = None, runtime_dir: RuntimeDir = None) -> None:
    """Switch a device off and on; its flash stays."""
    ask_bench(bench, runtime_dir, "reset", device=device)


@app.command()
def pin(
    device: DeviceName,
    name: Annotated[str, typer.Argument(help="D0 (dir), D1 (step), D2 (enable, active low) or D3.")],
    level: Annotated[int, typer.Argument(help="0 or 1.")],
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
) -> None:
    """Drive an input pin of a device."""
    ask_bench(bench, runtime_dir, "pin", device=device, pin=name, level=level)


@app.command("set", context_settings={"ignore_unknown_options": True})  # a negative value is no option
def set_field(
    device: DeviceName,
    field: Annotated[str, typer.Argument(help="As load_torque_Nm, diaagc or pKp; a wrong one lists them.")],
    value: Annotated[float, typer.Argument(help="The value, in the unit that the name ends in.")],
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
) -> None:
    """Set the load on a shaft, an encoder register or a gain."""
    ask_bench(bench, runtime_dir, "set", device=device, field=field, value=value)


@app.command()
def replay(log: Annotated[Path, typer.Argument(help="A file that `hil serve --log` wrote.")]) -> None:
    """Run a log again and compare every byte.

    On the virtual clock; exits with 1 if a byte, a time or a state of an axis differs.
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
    typer.echo(f"identical: {replayed.summary()}")


@app.command()
def doctor(
    devices: Annotated[
        int, typer.Option("--devices", min=1, max=512, help="How many the bench is to have.")
    ] = 8,
    runtime_dir: RuntimeDir = None,
    state_dir: StateDir = None,
    as_json: AsJson = False,
) -> None:
    """Say whether this system is fit for real time.

    Tries what a bench needs, and gives what is wrong, what it costs, and the line that mends it. Exits with
    1 if something that matters is wrong.
    """
    import dataclasses
    import os

    from hil.cli.doctor_benches import judge_benches, judge_memories
    from hil.host.doctor import healthy, judge, worst_first
    from hil.host.paths import runtime_base, state_base
    from hil.host.probes import try_all
    from hil.host.system import read_system

    runtime, state = runtime_base(runtime_dir, None, os.environ), state_base(state_dir, None, os.environ)
    findings = judge(read_system(), try_all(devices, runtime, state), devices)
    benches = judge_benches(runtime, runtime_dir is not None)
    findings = worst_first([*findings, *benches, *judge_memories(state)])
    if as_json:
        typer.echo(json.dumps([dataclasses.asdict(finding) for finding in findings]))
    else:
        from rich.console import Console

        from hil.cli.views import doctor_view

        Console(soft_wrap=True, markup=False).print(doctor_view(findings))
    if not healthy(findings):
        raise typer.Exit(1)


@app.command(hidden=True)
def reference(
    man: Annotated[bool, typer.Option("--man", help="The man page instead.")] = False,
) -> None:
    """Print the reference of configuration, commands, control verbs and axis fields as Markdown."""
    from hil.cli.man import man_page
    from hil.cli.reference import reference as text

    typer.echo(man_page(app) if man else text(app), nl=False)


@app.command()
def completion(
    shell: Annotated[str, typer.Argument(help="bash, zsh or fish.", show_default=False)],
) -> None:
    """Print a script with which a shell completes `hil`.

    For bash in ~/.bashrc: source <(hil completion bash)
    """
    from hil.cli.commands import commands
    from hil.cli.completion import SHELLS

    if shell not in SHELLS:
        raise fail(f"hil: there is no completion for {shell!r}; there is for {', '.join(SHELLS)}", 2)
    typer.echo(SHELLS[shell](commands(app)), nl=False)


app.command()(reload_command.reload)
app.command()(draw_commands.plot)
app.command(context_settings={"ignore_unknown_options": True})(draw_commands.step)  # negative degrees
app.command()(draw_commands.drive)
app.add_typer(arduino.app, name="arduino")
app.command(context_settings={"ignore_unknown_options": True})(axis_command.axis)  # negative degrees
app.command()(run_command.run)
app.command()(run_command.benches)
app.add_typer(line_commands.fault_app, name="fault")
app.add_typer(can_commands.can_app, name="can")
app.add_typer(profile_commands.profile_app, name="profile")
app.command()(line_commands.capture)
app.command()(line_commands.decode)
app.command()(line_commands.play)
app.command("arduino-discovery", hidden=True)(arduino.discovery)
app.command("arduino-monitor", hidden=True)(arduino.monitor)
