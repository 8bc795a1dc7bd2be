"""Commands of profiles that talk to a board, the choice of the board, and the serial port in between; and
commands of bridges.

Functions of ``Profile.commands``, which answer a ``Task``, become ``hil <profile> <command>`` with the
options that say which board. Those of a bridge's ``cli.py`` that have a parameter ``ask``, an ``AskBench``,
have the options that say which bench, and answer what is told: for programs, and as text.
"""

import inspect
import os
import termios
from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from hil.cli.framework.ask import ANY_BENCH, BenchOptions, fail
from hil.cli.framework.command_answers import CommandAnswer, telling
from hil.cli.framework.command_classes import Below, OneCommand
from hil.cli.framework.interrupts import noted
from hil.host.new_file import write_file
from hil.vocab.dialogue import (
    BoardRefusal,
    Dialogue,
    DialogueError,
    Heard,
    Listen,
    Progress,
    Refusal,
    Result,
    Send,
    Task,
)
from hil.vocab.profile import Profile
from hil.vocab.time import SimTimeNs

OnDevice = Annotated[
    str | None, typer.Option("--device", help="A device of a running bench. [default: the only one]")
]
OnPort = Annotated[
    str | None,
    typer.Option("--port", help="A real board's port instead: a path, socket://... or rfc2217://..."),
]
OnBaud = Annotated[
    int | None, typer.Option("--baud", help="Baud of --port. [default: the board's usual one]")
]
BRIDGES = "bridges"
GONE = "it was disconnected"
"""Text in place of pyserial's longer sentence."""


class BoardOptions(NamedTuple):
    """Options that say which board is meant."""

    device: OnDevice = None
    port: OnPort = None
    baud: OnBaud = None
    bench: BenchOptions = ANY_BENCH


@cache
def others() -> Mapping[str, Any]:
    """Commands of boards, and of bridges."""
    from hil.discovery.board_loading import Boards
    from hil.discovery.board_places import find_places

    app, found = typer.Typer(rich_markup_mode=None), find_places()
    boards = Boards(found.places, sorted(found.places))
    for name in boards:
        if name not in found.refused:
            _mount_profile(app, name, boards)
    bridges = {name: of_bridge(name) for name in _with_commands(BRIDGES)}
    return {**typer.main.get_group(app).commands, **bridges}


@cache
def of_bridge(name: str) -> Any:
    """Commands of a bridge, ``app`` of its ``cli.py``; None: there is no such bridge, or it has none."""
    if name not in _with_commands(BRIDGES):
        return None
    app = typer.Typer(rich_markup_mode=None)
    commands = import_module(f"{BRIDGES}.{name}.cli").app
    _mount_bridge(commands)
    app.add_typer(commands, cls=Below)
    return typer.main.get_group(app).commands[name]


def _mount_bridge(commands: typer.Typer) -> None:
    """Give commands of a bridge, and of the groups in it, the classes of ``hil``."""
    for info in commands.registered_commands:
        info.cls = OneCommand
        if info.callback and "ask" in inspect.signature(info.callback).parameters:
            info.callback = _asking(info.callback)
    for group in commands.registered_groups:
        if group.typer_instance:
            group.cls = Below
            _mount_bridge(group.typer_instance)


@cache
def _with_commands(package: str) -> list[str]:
    spec = find_spec(package)
    roots = spec.submodule_search_locations or [] if spec else []
    return [path.parent.name for root in roots for path in sorted(Path(root).glob("*/cli.py"))]


def _mount_profile(app: typer.Typer, name: str, boards: Mapping[str, Profile]) -> None:
    """Add a profile's commands if it has some, or one that says why they cannot be loaded."""
    try:
        if (load := boards[name].commands) is None:
            return
        commands = load()
        group = typer.Typer(cls=Below, help=commands.about, no_args_is_help=True, rich_markup_mode=None)
        for function in commands.functions:
            group.command(cls=OneCommand)(_command(name, function, commands.baud))
    except Exception as error:  # a profile is a plug-in: the other commands live on
        taking_all = {"ignore_unknown_options": True, "allow_extra_args": True}
        app.command(name, help=f"Not usable: {error!r}", context_settings=taking_all)(_broken(name, error))
    else:
        app.add_typer(group, name=name)


def _broken(profile: str, error: Exception) -> Callable[[], None]:
    def say() -> None:
        raise fail(f"hil: the commands of {profile} cannot be loaded: {error!r}")

    return say


def _command(profile: str, function: Callable[..., Task], usual_baud: int) -> Callable[..., None]:
    """Add the options that say which board to a function."""

    def run(which: BoardOptions, **arguments: Any) -> None:
        try:
            _carry_out(function(**arguments), profile, usual_baud, which)
        except Refusal as error:
            raise fail(str(error), 1 if isinstance(error, BoardRefusal) else 2) from None
        except DialogueError as error:
            raise fail(f"hil: {error}") from None

    return _told(run, function, BoardOptions)


def _asking(function: Callable[..., tuple[Any, str]]) -> Callable[..., None]:
    """Add the options that say which bench to a function."""

    def run(which: BenchOptions, **arguments: Any) -> CommandAnswer:
        try:
            return CommandAnswer(*function(ask=which.ask, **arguments))
        except BoardRefusal as error:
            raise fail(f"hil: {error}") from None

    return _told(run, function, BenchOptions)


def _told(run: Callable[..., Any], function: Callable[..., Any], options: type[Any]) -> Callable[..., None]:
    """Make a command that runs a function, whose own parameters it has, and ``options`` as ``which``."""
    own = inspect.signature(function).parameters.values()
    which = inspect.Parameter("which", inspect.Parameter.KEYWORD_ONLY, annotation=options)
    keyword_only = [each.replace(kind=which.kind) for each in own if each.name != "ask"]
    answer = inspect.signature(run).return_annotation
    run.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [*keyword_only, which], return_annotation=answer
    )
    run.__name__, run.__doc__ = function.__name__, function.__doc__
    told: Callable[..., None] = telling(run)
    return told


def _carry_out(task: Task, profile: str, usual_baud: int, which: BoardOptions) -> None:
    port, speed = which.port, 1.0
    if port is None:
        port, speed = _twin(profile, which.device, which.bench)
    elif which.device is not None:
        raise Refusal("choose --device or --port, not both")
    with SerialTalk(port, which.baud or usual_baud, speed) as talk:
        try:
            result = talk.run(task.dialogue)
            if task.file and task.content:
                _write(task.file, task.content(result))
            typer.echo(task.report(result))
        except Interrupted as error:
            said = None
            if task.after_interrupt:
                try:
                    said = talk.run(task.after_interrupt())
                except Interrupted:
                    said = f"{error}; interrupted again, before it had ended in order"
            raise fail(f"hil: {said or error}", 130) from None


def _write(file: Path, data: bytes) -> None:
    try:
        write_file(file, data)
    except OSError as error:
        raise Refusal(f"{file}: {error.strerror}") from None


def _twin(profile: str, device: str | None, bench: BenchOptions) -> tuple[str, float]:
    status = bench.ask("status")
    rows = {row["device"]: row for row in status["devices"] if row["profile"] == profile}
    if device is None and len(rows) != 1:
        which = f"choose one of {', '.join(rows)} with --device" if rows else f"there is no {profile}"
        raise Refusal(f"bench {status['bench']}: {which}")
    name = device or next(iter(rows))
    if name not in rows:
        raise Refusal(
            f"bench {status['bench']} has no {profile} {name!r}; it has {', '.join(rows) or 'none'}"
        )
    row = rows[name]
    if row["address"] is None:
        raise BoardRefusal(f"{name} has no serial port")
    if row["clients"] and not row["address"].startswith("socket://"):
        raise BoardRefusal(
            f"another program has {row['address']} open, and would get some of the answers; close it"
        )
    return bench.port_of(row["address"]), float(status["speed"])


class Interrupted(Exception):
    """Interruption by Ctrl-C or SIGTERM: ``str(error)`` is what the dialogue says of it."""


class SerialTalk:
    """Runner of dialogues over a serial port, on this computer's clock times ``speed``. ``sets_dtr``: a board
    with native USB sends only then; ``is_alone``: no other program may have it open.

    Raises:
        DialogueError: it cannot be opened; or, into a dialogue, it has gone.
    """

    def __init__(
        self, url: str, baud: int, speed: float = 1.0, *, sets_dtr: bool = False, is_alone: bool = False
    ) -> None:
        self._url, self._baud, self._speed = url, baud, speed
        self._sets_dtr, self._is_alone = sets_dtr, is_alone

    def __enter__(self) -> "SerialTalk":
        import serial

        try:
            self._port: Any = serial.serial_for_url(self._url, self._baud, do_not_open=True)
            self._port.dtr = self._sets_dtr  # boards that reset on a change of it start again
            if self._is_alone:
                self._port.exclusive = True
            self._port.open()
        except (OSError, ValueError) as error:
            from hil.net.serial_words import not_opened

            raise DialogueError(f"{self._url}: {not_opened(self._url, error)}") from None
        return self

    def __exit__(self, *_: object) -> None:
        from hil.net.port_client import close_serial

        close_serial(self._port)

    def run(self, dialogue: Dialogue[Result]) -> Result:
        """Run a dialogue; answers its result. Progress goes to standard error.

        Raises:
            DialogueError: as the dialogue says.
            Interrupted: Ctrl-C or SIGTERM, noticed between two steps.
        """
        try:
            with noted() as interrupts, _Bar() as bar:
                answer: Heard | None = None
                step = next(dialogue)
                while True:
                    if interrupts:
                        raise Interrupted(_last_words(dialogue))
                    try:
                        answer = self._do(step, bar)
                    except (OSError, termios.error) as error:
                        step = dialogue.throw(DialogueError(f"{self._url} has gone ({_reason(error)})"))
                        continue
                    step = dialogue.send(answer)
        except StopIteration as done:
            result: Result = done.value
            return result

    def _do(self, step: Send | Listen | Progress, bar: "_Bar") -> Heard | None:
        if isinstance(step, Send):
            self._port.write(step.data)
            self._port.flush()
            return None
        if isinstance(step, Progress):
            bar.show(step)
            return None
        self._set_timeout(step.timeout_ns / 1e9 / self._speed)
        data = self._port.read(1)
        return Heard(self._now_ns(), data + (self._port.read(self._port.in_waiting) if data else b""))

    def _set_timeout(self, timeout_s: float) -> None:
        if self._url.startswith("rfc2217://"):
            # pyserial 3.5 negotiates the whole port again when its time-out is set, which takes 0.1 s.
            self._port._timeout = timeout_s
        else:
            self._port.timeout = timeout_s

    def _now_ns(self) -> SimTimeNs:
        import time

        return SimTimeNs(round(time.monotonic_ns() * self._speed))


class _Bar:
    """Progress bar on a terminal, a line for each tenth elsewhere."""

    def __enter__(self) -> "_Bar":
        self._bar: Any = None
        self._tenth = 0
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar:
            self._bar.stop()

    def show(self, step: Progress) -> None:
        import sys

        from hil.cli.framework.command_answers import wants_json

        if not sys.stderr.isatty() or wants_json():
            if step.done * 10 // step.total > self._tenth:
                self._tenth = step.done * 10 // step.total
                typer.echo(f"{step.about} of {step.total}", err=True)
            return
        if self._bar is None:
            from rich.progress import BarColumn, TaskProgressColumn, TextColumn
            from rich.progress import Progress as Bar

            from hil.cli.framework.consoles import ShownConsole

            columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn())
            self._bar = Bar(*columns, console=ShownConsole(stderr=True), transient=True)
            self._bar.start()
            self._bar.add_task("", total=step.total)
        self._bar.update(self._bar.task_ids[0], completed=step.done, description=step.about)


def _last_words(dialogue: Dialogue[Any]) -> str:
    try:
        dialogue.throw(DialogueError("interrupted"))
    except DialogueError as error:
        return str(error)
    return "interrupted"


def _reason(error: Exception) -> str:
    if isinstance(error, termios.error):
        return str(error.args[-1])
    if isinstance(error, OSError) and error.errno:
        return os.strerror(error.errno)
    return GONE if "readiness to read" in str(error) else str(error)
