"""Classes of commands and groups: quick to start, with help in one style.

New versions of typer have pydantic check each value, also of options that were not given, and importing it
takes as long as the rest of a small command. Values that need no validation are read here instead. Other
versions leave what is set here alone.
"""

import re
from pathlib import Path
from typing import Any

from typer.core import TyperCommand, TyperGroup

from hil.cli.framework.command_answers import note_names
from hil.cli.framework.usage_words import USAGE_ERROR, placeholder, usage_word
from hil.vocab.near_words import nearest_or_begun


class Quick:
    """Part of a command or a group that starts quickly, and shows placeholders in one style."""

    def get_params(self, ctx: Any) -> list[Any]:
        return with_placeholders(with_plain_values(super().get_params(ctx)))  # type: ignore[misc]

    def parse_args(self, ctx: Any, args: list[str]) -> Any:
        try:
            return super().parse_args(ctx, [*args])  # type: ignore[misc]
        except USAGE_ERROR as error:
            from hil.cli.framework.usage_errors import wrong_use

            params: list[Any] = self.params  # type: ignore[attr-defined]
            if not any(each.param_type_name == "argument" for each in params):
                error.left = _left(params, args)
            raise wrong_use(error, ctx, getattr(error, "possibilities", None) or []) from None

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        self.suggest_commands = False  # in typer's words
        try:
            name, command, rest = super().resolve_command(ctx, args)  # type: ignore[misc]
        except USAGE_ERROR as error:
            from hil.cli.framework.guessed_words import alike, is_slip
            from hil.cli.framework.usage_errors import wrong_use

            known = self.list_commands(ctx)  # type: ignore[attr-defined]
            near = [each for each in nearest_or_begun(args[0], known) if is_slip(args[0], each)]
            if ctx.parent:
                near = near or alike(args[0], known)
            raise wrong_use(error, ctx, near) from None
        return (name, *command.chosen(rest)) if isinstance(command, OrBelow) else (name, command, rest)

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        arguments = [each for each in self.get_params(ctx) if each.param_type_name == "argument"]
        below = ["COMMAND [ARGUMENT...]"] if hasattr(self, "commands") else []
        return ["[OPTION...]", *map(usage_word, arguments), *below]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write arguments and options."""
        rows: dict[str, list[tuple[str, str]]] = {"Arguments": [], "Options": []}
        for each in self.get_params(ctx):
            if record := each.get_help_record(ctx):
                is_argument = each.param_type_name == "argument"
                about = with_limits(
                    record[1].replace("[required]", "" if is_argument else "[required]").rstrip()
                )
                name = usage_word(each) if is_argument else record[0]
                rows["Arguments" if is_argument else "Options"].append((name, about))
        for title, records in rows.items():
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)
        if hasattr(self, "format_commands"):
            self.format_commands(ctx, formatter)


def _left(parameters: list[Any], args: list[str]) -> list[str]:
    """Words of a command line that are no option, and no value of one."""
    valued = {word for each in parameters for word in each.opts if not getattr(each, "is_flag", False)}
    pairs = zip(["", *args], args, strict=False)
    return [word for before, word in pairs if not word.startswith("-") and before not in valued]


_WITHOUT = {"--bench": "asks no running bench; leave out --bench", "--json": "has no --json; leave it out"}
"""Words for a command that such an option is not for. --runtime-dir is for all benches: it does no harm."""


class OneCommand(Quick, TyperCommand):
    """Command. What was said before its name, as in ``hil -b lab --json status``, is an option of it."""

    def parse_args(self, ctx: Any, args: list[str]) -> Any:
        said = _said_before(ctx)
        for flag, why in _WITHOUT.items():
            if flag in said and not _has(self, flag):
                raise USAGE_ERROR(f"`{ctx.command_path}` {why}", ctx)
        rest = super().parse_args(ctx, [*_own_words(self, said), *args])
        note_names(ctx.params)
        return rest


class BeforeProgram(OneCommand):
    """Command with an argument, options, and then a program with options of its own."""

    def parse_args(self, ctx: Any, args: list[str]) -> Any:
        if args and not args[0].startswith("-"):
            flags = {
                word for each in self.get_params(ctx) if getattr(each, "is_flag", False) for word in each.opts
            }
            end = 1
            while end < len(args) and args[end].startswith("-") and args[end] != "--":
                end += 1 if args[end] in flags or "=" in args[end] else 2
            args = [*args[1:end], args[0], *args[end:]]
        return super().parse_args(ctx, args)


class Below(Quick, TyperGroup):
    """Group of commands below one of ``hil``, as `hil fault`. ``hint``: as in its row."""

    hint = ""

    def parse_args(self, ctx: Any, args: list[str]) -> Any:
        return super().parse_args(ctx, [*_own_words(self, _said_before(ctx)), *args])

    def list_commands(self, ctx: Any) -> list[str]:
        # below an old name all are hidden
        return [name for name, each in self.commands.items() if not each.hidden or self.hidden]

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        try:
            return super().resolve_command(ctx, args)
        except USAGE_ERROR as error:
            hint = self.hint.format(args[0]).strip(" .")
            error.message += f"; {hint}" if hint else ""
            raise

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands with their whole summaries."""
        with formatter.section("Commands"):
            formatter.write_dl(
                [(name, summary(self.commands[name].help)) for name in self.list_commands(ctx)]
            )


class OrBelow(OneCommand):
    """Command that has others below it, as `hil run FILE` and `hil run list`: the first word that is no
    option decides. ``group`` has those others."""

    group: Any

    @property
    def commands(self) -> dict[str, Any]:
        """Commands below it by name."""
        below: dict[str, Any] = self.group.commands
        return below

    def list_commands(self, ctx: Any) -> list[str]:
        return list(self.commands)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        return self.commands.get(cmd_name)

    def chosen(self, args: list[str]) -> tuple[Any, list[str]]:
        """Choose the group, with the name of its command first, or this command."""
        valued = {word for each in self.params for word in each.opts if not getattr(each, "is_flag", True)}
        place = 0
        while place < len(args) and args[place].startswith("-") and args[place] != "--":
            place += 2 if args[place] in valued else 1
        if args[place : place + 1] and args[place] in self.commands:
            return self.group, [args[place], *args[:place], *args[place + 1 :]]
        return self, args

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        return super().collect_usage_pieces(ctx)[: 1 + len(self._arguments())]

    def _arguments(self) -> list[Any]:
        return [each for each in self.params if each.param_type_name == "argument"]

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands below it."""
        self.group.format_commands(ctx, formatter)


def _said_before(ctx: Any) -> dict[str, list[str]]:
    """Words of the options that stand before a command's name, by their flags; the nearest ones hold."""
    said: dict[str, list[str]] = {}
    while (ctx := ctx.parent) is not None:
        for each in ctx.command.params:
            source = ctx.get_parameter_source(each.name)
            if source is not None and source.name == "COMMANDLINE":
                flag, value = each.opts[0], ctx.params[each.name]
                said.setdefault(flag, [flag] if value is True else [flag, str(value)])
    return said


def _own_words(command: Any, said: dict[str, list[str]]) -> list[str]:
    return [word for flag, words in said.items() if _has(command, flag) for word in words]


def _has(command: Any, flag: str) -> bool:
    return any(flag in each.opts for each in command.params)


_LIMITS = re.compile(r"(?<=[\[ ])(?:([-\d.e]+)(<=?))?x(?:(<=?|>=?)([-\d.e]+))?\]$")


def with_limits(about: str) -> str:
    """Help of a parameter with its limits in words: `[default: 1.0; 0.05 to 60]`, `[at least 1]`; click has
    them as `0.05<=x<=60`."""

    def in_words(found: re.Match[str]) -> str:
        least, above, sign, limit = found.groups()
        if least and limit:
            return f"{f'more than {least}, at most' if above == '<' else f'{least} to'} {limit}]"
        names = {">=": "at least", ">": "more than", "<=": "at most", "<": "less than"}
        return f"{names[sign]} {limit}]" if sign else found[0]

    return _LIMITS.sub(in_words, about)


def summary(about: str | None) -> str:
    """First paragraph of a command's help, in a line."""
    return " ".join((about or "").partition("\n\n")[0].split())


def with_placeholders(parameters: list[Any]) -> list[Any]:
    """Let options show placeholders of this style in help texts."""
    for parameter in parameters:
        is_option = parameter.param_type_name == "option"
        if is_option and not parameter.is_flag and parameter.metavar is None:
            parameter.metavar = placeholder(parameter.name)
    return parameters


_PLAIN = {str: str, Path: Path}


class PlainValue:
    """Reader of an option's or argument's value, in the place of typer's own, which reads all other kinds."""

    def __init__(self, plain: type) -> None:
        self._plain = plain

    def coerce(self, value: Any, param: Any, ctx: Any) -> Any:
        """Value as the command takes it. Raises what typer's own reader raises."""
        is_repeated = param.multiple or param.nargs == -1
        if value is None:
            return () if is_repeated else None
        if is_repeated and self._plain is str and isinstance(value, tuple | list):
            return list(value)
        if not is_repeated:
            if isinstance(value, self._plain):
                return value
            if self._plain in _PLAIN:
                return _PLAIN[self._plain](value)
        param._runtime_param = None
        return param.get_runtime_param().coerce(value, param, ctx)


def with_plain_values(parameters: list[Any]) -> list[Any]:
    """Let parameters be read that way, where typer has them read by pydantic."""
    for parameter in parameters:
        if getattr(parameter, "_runtime_param", parameters) is None and hasattr(parameter, "type_descriptor"):
            annotation = parameter.type_descriptor.annotation
            if annotation == list[str]:
                annotation = str  # of each
            if isinstance(annotation, type):
                parameter._runtime_param = PlainValue(annotation)
    return parameters
