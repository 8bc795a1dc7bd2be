"""The command line as data, read from its definition: for completion and the man page."""

import inspect
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import typer

from hil.cli.framework.command_classes import summary
from hil.cli.framework.command_table import VALUES, ValueRow
from hil.cli.framework.usage_words import placeholder, usage_word


@dataclass(frozen=True)
class CliParameter:
    """Argument, or an option: then it has ``flags``, as in --bench and -b."""

    name: str
    flags: tuple[str, ...]
    about: str
    takes_value: bool
    is_required: bool
    is_repeated: bool
    default: str
    """Default as it is typed; empty: none, or one that ``about`` tells."""
    takes: str
    """Kind of value, one of ``ValueRow.takes``."""
    placeholder: str = ""
    """Name of the value in help texts."""
    usage: str = ""
    """Argument as in a usage line."""


@dataclass(frozen=True)
class CliCommand:
    """Command. ``path``: ("fault", "inject"); of ``hil`` itself (). ``about``: paragraphs, first a line."""

    path: tuple[str, ...]
    about: str
    arguments: tuple[CliParameter, ...]
    options: tuple[CliParameter, ...]
    commands: tuple["CliCommand", ...]

    @property
    def name(self) -> str:
        return " ".join(self.path)

    @property
    def summary(self) -> str:
        return summary(self.about)

    def all(self) -> Iterator["CliCommand"]:
        """Iterate over this command and all below it."""
        yield self
        for command in self.commands:
            yield from command.all()


HELP = CliParameter("help", ("-h", "--help"), "Show a summary and exit.", False, False, False, "", "")


def commands(app: typer.Typer) -> CliCommand:
    """Read ``hil`` with all that is not hidden."""
    return _command(typer.main.get_command(app), ())


def _command(group: Any, path: tuple[str, ...]) -> CliCommand:
    parameters = [_parameter(each, path) for each in group.params]
    names = group.list_commands(None) if hasattr(group, "list_commands") else ()
    below = ((name, group.get_command(None, name)) for name in names)
    return CliCommand(
        path,
        inspect.cleandoc(group.help or ""),
        tuple(each for each in parameters if not each.flags),
        (*(each for each in parameters if each.flags), HELP),
        tuple(_command(each, (*path, name)) for name, each in below if not each.hidden),
    )


def _parameter(given: Any, path: tuple[str, ...]) -> CliParameter:
    is_option = given.param_type_name == "option"
    takes_value = not (is_option and given.is_flag)
    shown = takes_value and given.show_default and given.default not in (None, ())
    row = VALUES.get(" ".join((*path, given.name))) or VALUES.get(given.name, ValueRow(""))
    return CliParameter(
        given.name,
        tuple(given.opts) if is_option else (),
        " ".join((given.help or "").split()),
        takes_value,
        bool(given.required),
        given.nargs == -1 or given.multiple,
        str(given.default) if shown else "",
        row.takes if takes_value else "",
        (given.metavar or placeholder(given.name)).removesuffix("..."),
        "" if is_option else usage_word(given),
    )
