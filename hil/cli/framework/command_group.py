"""The command line: ``hil VERB OBJECT``, from the table, with the commands of boards and bridges."""

import os
import sys
from functools import cache, wraps
from importlib import import_module
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from hil import __version__
from hil.cli.framework.ask import Bench, RuntimeDir
from hil.cli.framework.command_answers import AsJson, asks_a_bench, begin, telling
from hil.cli.framework.command_classes import (
    BeforeProgram,
    Below,
    OneCommand,
    OrBelow,
    Quick,
    summary,
)
from hil.cli.framework.command_table import BOARD, COMMANDS, PANELS, CommandRow, rows_below
from hil.cli.framework.usage_words import USAGE_ERROR

_HELP = {"help_option_names": ["--help", "-h"]}


class AllCommands(Quick, TyperGroup):
    """Group of all commands. Each is imported and made when it is asked for."""

    def list_commands(self, ctx: Any) -> list[str]:
        from hil.cli.framework.board_commands import others

        return [*(name for name, row in COMMANDS.items() if not row.is_hidden), *others()]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        if row := COMMANDS.get(cmd_name):
            return _made(row)
        from hil.cli.framework.board_commands import of_bridge, others

        return of_bridge(cmd_name) or others().get(cmd_name)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        try:
            return super().resolve_command(ctx, args)
        except USAGE_ERROR as error:
            from hil.cli.framework.guessed_words import guessed_line
            from hil.cli.framework.named_bench import is_bench

            if is_bench(args[0]):
                error.message = f"{args[0]!r} is a bench, no command; write `hil -b {args[0]} status`"
            elif line := guessed_line(args, self.list_commands(ctx)):
                error.message = f"there is no command {args[0]!r}; write `hil {line}`"
            raise

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except USAGE_ERROR as error:
            from hil.cli.framework.usage_errors import wrong_use

            if str(error.message) == "Missing command.":
                raise wrong_use(error, ctx, []) from None
            raise

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands of each group below its name, each with its whole summary."""
        commands = {name: self.get_command(ctx, name) for name in self.list_commands(ctx)}
        width = max(map(len, commands))
        for panel in PANELS:
            names = [name for name, of in commands.items() if not of.hidden and panel_of(name) == panel]
            with formatter.section(panel):
                formatter.write_dl([(name.ljust(width), summary(commands[name].help)) for name in names])


def panel_of(name: str) -> str:
    """Group of a command in `hil --help`. A bridge says its own; others are boards'."""
    if row := COMMANDS.get(name):
        return row.panel
    from hil.cli.framework.board_commands import others

    return others()[name].rich_help_panel or BOARD


@cache
def _made(row: CommandRow) -> Any:
    """Make a command, or a group with its commands."""
    if not row.about:
        below = rows_below(row.name)
        made = _alone(row, OrBelow if below else None)
        if below:
            made.group = _group(row._replace(where=""))
        return made
    return _group(row)


def _group(row: CommandRow) -> Any:
    app = typer.Typer(
        name=row.name,
        cls=Below,
        help=row.about,
        no_args_is_help=not row.where,
        invoke_without_command=bool(row.where),
        hidden=row.is_hidden,
        add_completion=False,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
    )
    app.callback()(_function(row) if row.where else lambda: None)
    for each in rows_below(row.name):
        _add(app, each)
    made: Any = typer.main.get_command(app)
    made.hint = row.hint
    return made


def _alone(row: CommandRow, kind: Any = None) -> Any:
    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None)
    _add(app, row, kind)
    return typer.main.get_command(app)


def _add(app: typer.Typer, row: CommandRow, kind: Any = None) -> None:
    settings = {
        "ignore_unknown_options": row.takes_negative,
        "allow_interspersed_args": not row.takes_command,
    }
    kind = kind or (BeforeProgram if row.has_place else OneCommand)
    name = row.name.rpartition(" ")[2]
    app.command(name, cls=kind, hidden=row.is_hidden, context_settings=settings)(_function(row))


def _function(row: CommandRow) -> Any:
    """Import what a command does; one by an old name says the new one first."""
    module, _, name = row.where.partition(":")
    told = telling(getattr(import_module(f"hil.cli.{module}"), name))
    if not row.now:
        return told

    @wraps(told)
    def tell(**given: Any) -> None:
        if (context := given.get("context")) is None or context.invoked_subcommand is None:
            say_renamed(f"hil {row.name}", f"hil {row.now}")
        told(**given)

    return tell


def say_renamed(old: str, new: str) -> None:
    """Say on standard error that a command has a new name."""
    from hil.host.journal import say

    say(f"hil: `{old}` is now `{new}`; the old name goes with the next release", sys.stderr)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"hil {__version__}")
        raise typer.Exit


def _options(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
    as_json: AsJson = False,
) -> None:
    # What was said here are words of the command itself: see `OneCommand`.
    begin(context.command)
    bench = os.environ.get("HIL_BENCH")
    if bench and (name := context.invoked_subcommand):
        command: Any = context.command
        context.default_map = {name: _defaults(command.get_command(context, name), {"bench": bench})}


def _defaults(command: Any, given: dict[str, str]) -> dict[str, Any]:
    """Defaults of a command's options from the environment, and of those below it."""
    below = getattr(command, "commands", {})
    own = given if below or asks_a_bench(command) else {}
    return {**own, **{name: _defaults(each, given) for name, each in below.items()}}


def command_line() -> typer.Typer:
    """Make the command line."""
    made = typer.Typer(
        name="hil",
        cls=AllCommands,
        help="Virtual motion-control boards behind real serial ports.",
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        context_settings=_HELP,
    )
    made.callback()(_options)
    return made


app = command_line()
