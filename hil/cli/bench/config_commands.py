"""``hil init``, ``hil check`` and ``hil schema``: configurations."""

import json
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Annotated

import typer

from hil.cli.bench.serve_command import config_of, read_config
from hil.cli.framework.ask import fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.framework.shown_words import counted

_TEXT = """\
# yaml-language-server: $$schema=$SCHEMA
# A bench of hil: virtual boards behind real serial ports. The line above tells editors of the keys.
#   hil check $FILE    lists what is wrong with it
#   hil serve $FILE    runs it until Ctrl-C, and says how its ports are opened
#   hil reload    takes what you have changed here since, while it runs
#   hil docs ports    describes ports; hil docs lists all pages

# The bench's name: commands find it by that, and ports stand in a folder of that name.
bench: $NAME

devices:
  # A Mechaduino, a servo motor with a terminal. Its port is a pseudo-terminal; hil list says where.
  m1:
    profile: mechaduino # hil profile list names all kinds of boards
    flash: {table: identity} # calibrated; without this line it is as new, and c calibrates it in 26 s
    # port: {kind: tcp, listen: 7001} # a TCP port instead, for socket://127.0.0.1:7001
    # axis: {load_torque_Nm: 0.02} # what is at its shaft; hil docs reference has all keys

  # A SAC, a stepper controller with a command line of its own.
  s1:
    profile: sac
    # baud: 38400

# Other programs, and people, reach the axes through bridges: the page, zenoh, Modbus, metrics.
bridges:
  web: {} # a page for the browser; hil serve prints its address
  # modbus: {}

# What goes wrong from the start on; hil fault inject does it in a running bench. hil fault kinds lists all.
# faults:
#   - {fault: byte_drop, target: m1, rate: 0.01}

# Same seed and same inputs, same bytes.
# seed: 0
"""


def first_bench(name: str, file: str, schema: str) -> str:
    """Write a configuration of a bench. ``file``: its name; ``schema``: that of the schema beside it."""
    return Template(_TEXT).substitute(NAME=name, FILE=file, SCHEMA=schema)


if TYPE_CHECKING:
    from hil.config import BenchConfig
    from hil.config.document_kinds import OtherKindError


Checked = Annotated[
    Path,
    typer.Argument(help="A bench's configuration, a run, a machine, or a map of a Modbus drive, in YAML."),
]


def check(
    config: Checked,
    diff: Annotated[
        Path | None,
        typer.Option("--diff", help="An older configuration: say what a reload would do.", metavar="OLD"),
    ] = None,
) -> CommandAnswer:
    """Check a bench's configuration, or another document, and list all its problems.

    Each comes with file:line:column, a remedy, and the line with a caret at the place. A run, a machine and a
    map of a Modbus drive are recognised. What of a run depends on its bench, `hil run --check` compares.

    Example: hil check bench.yaml
    """
    from hil.config.document_kinds import BOARD, OtherKindError

    try:
        bench = config_of(config)
    except OtherKindError as error:
        if diff is not None or error.kind is BOARD:
            raise fail(str(error), 2) from None
        return _other_kind(error, config)
    if problems := _table_problems(bench, config):
        raise fail("\n".join(problems), 2)
    if diff is None:
        from hil.cli.bench.profile_commands import say_what_is_spoilt

        besides, said = say_what_is_spoilt(bench), _what_boards_say(bench)
        text = f"{config}: bench {bench.bench}, {counted(len(bench.devices), 'device')}, no problems{besides}"
        for axis, line in _what_motors_follow(bench).items():
            said.setdefault(axis, []).append(line)
        answer = {"bench": bench.bench, "devices": list(bench.devices), "problems": [], "said": said}
        old = answer["old_keys"] = [str(problem) for problem in bench.written.old_keys]
        said |= _what_lines_say(bench)
        lines = [*old, *(f"{axis}: {line}" for axis, each in said.items() for line in each)]
        return CommandAnswer(answer, "\n".join([text, *lines]))
    from hil.config import diff as difference

    changes = difference(read_config(diff, opens_bridges=False), bench)
    rows = [{"action": each.action, "device": each.device, "why": list(each.why)} for each in changes]
    lines = [
        f"{each.action:8}{each.device or 'the whole bench'}"
        + (f" ({'; '.join(each.why)})" if each.why else "")
        for each in changes
    ]
    return CommandAnswer({"bench": bench.bench, "changes": rows}, "\n".join(lines))


def _other_kind(other: "OtherKindError", file: Path) -> CommandAnswer:
    """Check a document that is no bench's configuration."""
    from hil.compose import find_catalogue
    from hil.config.document_kinds import MACHINE, RUN
    from hil.runs import checked_run
    from hil.toolpath.machine import parse_machine
    from hil.vocab.problem import ConfigError

    kind, text, answer = other.kind, other.text, dict[str, object]()
    try:
        if kind is RUN:
            run = checked_run(text, str(file))
            what = f"run {run.run}, {counted(len(run.steps), 'step')}"
            answer = {"run": run.run, "steps": len(run.steps)}
        elif kind is MACHINE:
            machine = parse_machine(text, str(file))
            letters = [axis.letter.upper() for axis in machine.axes]
            what, answer = f"machine {machine.name}, axes {' '.join(letters)}", {"machine": machine.name}
        else:
            maps = find_catalogue().maps
            assert maps, "a map is a kind of document only with a bus that has maps"
            values = maps.own_map(maps.read(text, str(file), None)).values
            what = f"map of a Modbus drive, {counted(len(values), 'value')}"
            answer = {"modbus_map": list(values)}
    except ConfigError as error:
        raise fail(str(error), 2, {str(file): text}) from None
    return CommandAnswer(answer | {"problems": []}, f"{file}: {what}, no problems")


def _what_boards_say(bench: "BenchConfig") -> dict[str, list[str]]:
    """Lines of boards on what follows from their numbers, by the axis's address."""
    from hil.compose import find_catalogue
    from hil.vocab.address import DeviceParts

    catalogue, said = find_catalogue(path=bench.profile_path), {}
    for name, device in bench.twins.items():
        profile, says = catalogue.profiles[device.profile], catalogue.boards[device.profile].says
        axes = DeviceParts(profile.axes)
        for axis, plan in device.axis_plans(profile, 0).items():
            if lines := [*says(plan), *map(str, profile.warnings)]:
                said[axes.label(name, axis)] = lines
    return said


def _what_motors_follow(bench: "BenchConfig") -> dict[str, str]:
    """Lines on the speeds that motors follow by their figures, by the axis's address: of boards that go at a
    speed whether the motor follows or not, and where the configuration has a motor."""
    from hil.compose import find_catalogue
    from hil.core.followed_speed import followed_speed
    from hil.core.kinds import KINDS
    from hil.core.motor_words import followed_text
    from hil.vocab.address import DeviceParts

    catalogue, said = find_catalogue(path=bench.profile_path), {}
    for name, device in bench.twins.items():
        profile = catalogue.profiles[device.profile]
        axes = DeviceParts(profile.axes)
        for axis, plan in device.axis_plans(profile, 0).items():
            own = device.axis_config(profile, axis).motor
            if own or (plan.law in KINDS and KINDS[plan.law].commanded_rpm):
                motor = own or profile.axes[axis].motor
                of = ", ".join(filter(None, (motor, f"{plan.plant} plant")))
                said[axes.label(name, axis)] = f"{followed_text(followed_speed(plan))} ({of})"
    return said


def _what_lines_say(bench: "BenchConfig") -> dict[str, list[str]]:
    """Notes on the speeds of segments, by their names: those of stations, taps and real adapters."""
    from hil.compose import find_catalogue
    from hil.config.port_kinds import segment_speeds
    from hil.vocab.segment import speed_notes

    profiles = find_catalogue(path=bench.profile_path).profiles
    notes = {name: speed_notes(segment_speeds(bench, name, profiles)) for name in bench.segments}
    return {name: each for name, each in notes.items() if each}


def _table_problems(bench: "BenchConfig", config: Path) -> list[str]:
    """Problems of the files of look-up tables that a configuration names."""
    from hil.config.device_parts_model import BUILT_IN_TABLES

    devices = {name: each for name, each in bench.devices.items() if each.flash.table not in BUILT_IN_TABLES}
    if not devices:
        return []
    from hil.compose import find_catalogue
    from hil.compose.build import TableFileError, start_sections
    from hil.config.document import Finding
    from hil.config.yaml_text import document_from_yaml

    findings, boards = [], find_catalogue(path=bench.profile_path).boards
    for name, device in devices.items():
        try:
            start_sections(device, boards[device.profile], {}, config.parent)
        except TableFileError as error:
            remedy = "give the file of a whole table, or write identity, stored or empty"
            if isinstance(error.__cause__, OSError):
                remedy = "write where it is, from this file on"
            findings.append(Finding(("devices", name, "flash", "table"), str(error), remedy))
    if not findings:
        return []
    document = document_from_yaml(config.read_text("utf-8-sig") if config.is_file() else "", str(config))
    return [*map(str, document.error(findings).problems)]


def schema(
    config: Annotated[
        Path | None,
        typer.Argument(help="A configuration; the schema then has its own boards (profile_path), too."),
    ] = None,
) -> None:
    """Print the configuration's JSON Schema, for editors.

    Example: hil schema > bench.schema.json
    """
    from hil.compose import find_catalogue
    from hil.config import schema as json_schema

    path = read_config(config).profile_path if config else ()
    typer.echo(json.dumps(json_schema(find_catalogue(path=path)), indent=2))


def init(
    file: Annotated[Path, typer.Argument(help="The configuration to write.")] = Path("bench.yaml"),
) -> CommandAnswer:
    """Write a commented configuration, and its schema for editors beside it.

    Files that exist are not changed. The bench has the name of the file; in bench.yaml, that of its folder.

    Example: hil init lab.yaml
    """
    import re
    import shlex

    from hil.compose import find_catalogue
    from hil.config import schema as json_schema
    from hil.host.new_file import write_file

    if file.is_dir():
        raise fail(f"{file}: this is a folder; write a file in it, as {file / 'bench.yaml'}", 2)
    schema_file = file.with_name(f"{file.stem}.schema.json")
    if there := next((each for each in (file, schema_file) if each.exists()), None):
        raise fail(f"hil: {there} is there already; choose another name, or remove it", 2)
    if not file.parent.is_dir():
        raise fail(f"hil: {file}: there is no folder {file.parent}", 2)
    called = file.absolute().parent.name if file.stem == "bench" else file.stem
    name = re.sub("[^a-z0-9_-]", "-", called.lower()).lstrip("0123456789_-")[:32] or "bench"
    try:
        write_file(file, first_bench(name, shlex.quote(file.name), schema_file.name).encode())
        write_file(schema_file, json.dumps(json_schema(find_catalogue()), indent=2).encode() + b"\n")
    except OSError as error:
        raise fail(f"hil: {error.filename or file}: {error.strerror}", 2) from None
    text = f"wrote {file}, and {schema_file.name} for editors"
    text += f"\nTry it: hil check {file}, then hil serve {file}"
    return CommandAnswer({"file": str(file), "schema": str(schema_file)}, text)
