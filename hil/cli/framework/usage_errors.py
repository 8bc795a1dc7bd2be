"""Mistakes of a command line, in the one form of errors: ``hil: what is wrong (given), where; what to do``.

Imported when there is one: commands start without it.
"""

import re
from typing import Any

from hil.cli.framework.usage_words import USAGE_ERROR, placeholder
from hil.vocab.near_words import did_you_mean
from hil.vocab.typed_numbers import is_unit, number_problem, quoted, typed_number, unit_in

_UNEXPECTED = re.compile(r"Got unexpected extra arguments?(?:\(s\))? \((.*)\)")
_LEAST = (
    ("Input should be greater than or equal to ", "write at least "),
    ("Input should be less than or equal to ", "write at most "),
    ("Input should be greater than ", "write more than "),
    ("Input should be less than ", "write less than "),
    ("Input should be ", "write "),
)
"""Words for what pydantic, by way of typer, says of a value."""
_UNITS = {"degrees": "deg", "seconds": "s", "rate_Hz": "Hz", "interval_ms": "ms"}
"""Units of parameters whose names do not end in theirs."""
_KEYS = ("speed", "seed", "rate_hz", "cpu", "devices", "bridges", "bench", "labels")
"""Keys of a configuration that people look for among the options of `hil serve`."""


class WrongUse(USAGE_ERROR):  # type: ignore[misc]
    """Mistake of a command line, which is shown in the form of all errors."""

    def show(self, file: Any = None) -> None:
        """Write it to the standard error."""
        from hil.cli.framework.ask import tell_error

        tell_error(self.message)

    def format_message(self) -> str:
        return str(self.message)


def wrong_use(error: Any, context: Any, near: list[str]) -> Any:
    """Say a mistake that click or typer found in this form. ``near``: words that may be meant. `hil` alone
    shows its help."""
    is_root = context.parent is None and type(error).__name__ == "NoArgsIsHelpError"
    if is_root or isinstance(error, WrongUse):
        return error
    return WrongUse(_said(error, context, near), context)


def _said(error: Any, context: Any, near: list[str]) -> str:
    kind, message = type(error).__name__, str(error.message)
    path = context.command_path
    if kind == "NoArgsIsHelpError":
        return f"`{path}` is one of several commands; write one of those below\n\n{message}"
    if kind == "NoSuchOption":
        return _no_option(error.option_name, context, near)
    if kind == "MissingParameter":
        if error.param.param_type_name == "option":
            return _option_missing(error, context)
        joined = next((str(each) for each in context.params.values() if "=" in str(each or "")), "")
        apart = f"write {joined.replace('=', ' ', 1)!r} apart, " if joined.count("=") == 1 else ""
        return f"{_name(error.param)} is missing{_about(error.param)}; {apart}write `{_usage(context)}`"
    if kind == "BadOptionUsage":
        return _of_option(error.option_name, context, takes_none="does not take" in message)
    if kind == "BadParameter":
        return _of_value(error, message)
    if found := _UNEXPECTED.fullmatch(message.rstrip(".")):
        if is_unit(found[1]):
            return f"{found[1]} is too much for `{path}`; write the number alone, without its unit"
        return (
            f"{found[1]} is too much for `{path}`; {_bench_meant(found[1], context)}write `{_usage(context)}`"
        )
    if message == "Missing command.":
        given = context.params.get("bench")
        taken = f", and --bench took {given!r} as its value" if given else ""
        return f"COMMAND is missing{taken}; write `{path} [OPTION...] COMMAND`, `{path} --help` lists them"
    if message.startswith("No such command"):
        word = message.removeprefix("No such command ").rstrip(".")
        of = f" of `{path}`" if context.parent else ""
        return _with_near(f"there is no command {word}{of}", near, f"`{path} --help` lists them")
    return message


def _option_missing(error: Any, context: Any) -> str:
    """Option that a command needs, and words that it does not take beside it."""
    flag, path = error.param.opts[0], _new_name(context.command_path)
    left = getattr(error, "left", [])
    too_much = f"{' '.join(left)} is too much for `{path}`, and " if left else ""
    value = error.param.metavar or placeholder(error.param.name)
    return f"{too_much}{flag} is missing{_about(error.param)}; write `{path} {flag} {value}`"


def _no_option(flag: str, context: Any, near: list[str]) -> str:
    """Option that a command has not: some say what is meant without it."""
    path = context.command_path
    what, lists = f"there is no option {flag} of `{path}`", f"`{path} --help` lists them"
    optional = [each for each in context.command.params if each.param_type_name == "argument"]
    if flag in ("--all", "-a") and not near and all(not each.required for each in optional):
        return f"{what}; `{path}` alone is for all"
    if (key := flag.strip("-").replace("-", "_")) in _KEYS and path == "hil serve":
        return f"{what}: {key} is a key of the configuration; write `{key}: VALUE` into the file"
    if (name := flag.lstrip("-")) and path == "hil fault inject":
        return f"{what}; parameters of a fault stand without dashes, as {name}=VALUE"
    return _with_near(what, near, lists)


def _bench_meant(word: str, context: Any) -> str:
    """Words for an argument too many that names a bench which runs."""
    from hil.cli.framework.command_answers import asks_a_bench
    from hil.cli.framework.named_bench import is_bench

    if asks_a_bench(context.command) and is_bench(word):
        return f"for the bench of this name write `{context.command_path} -b {word}`, else "
    return ""


def _with_near(what: str, near: list[str], remedy: str) -> str:
    return f"{what}; {' '.join(filter(None, [did_you_mean(*near), remedy]))}"


def _name(parameter: Any) -> str:
    is_argument = parameter.param_type_name == "argument"
    if not is_argument:
        return str(parameter.opts[0])
    return (parameter.metavar or placeholder(parameter.name)).removesuffix("...")


def _about(parameter: Any) -> str:
    about = (getattr(parameter, "help", "") or "").partition(" [")[0].rstrip(".")
    return f" ({about[0].lower()}{about[1:]})" if about else ""


def _usage(context: Any) -> str:
    return " ".join([_new_name(context.command_path), *context.command.collect_usage_pieces(context)])


def _new_name(path: str) -> str:
    """Command in place of an old name, which is not taught any more."""
    from hil.cli.framework.command_table import OLD

    old = OLD.get(path.removeprefix("hil "))
    return f"hil {old.now}" if old else path


def _of_option(flag: str, context: Any, *, takes_none: bool) -> str:
    if takes_none:
        return f"{flag} takes no value; write {flag} alone"
    known = context.command.get_params(context)
    value = next((each.metavar for each in known if flag in each.opts), "VALUE")
    return f"{flag} has no value; write `{flag} {value}`"


def _of_value(error: Any, message: str) -> str:
    """Mistake of a value: of a number with what was given, of others in the words of typer."""
    given, param = _given(error, message), error.param
    name = _name(param) if param is not None else "a value"
    whole = re.match(r"Input should be a valid (integer|int)|.* is not a valid int", message)
    if whole and not isinstance(typed_number(str(given)), str):
        return f"{name}: {given} is not whole; write a whole number"
    if whole or re.match(r"Input should be a valid number|.* is not a valid float", message):
        unit = _UNITS.get(param.name, unit_in(param.name))
        limits = "a whole number" if whole else f"a number, in {unit}" if unit else "a number"
        what, remedy = number_problem(str(given), unit, limits)
        return f"{name}: {what}; {remedy}"
    for begin, words in _LEAST:
        if message.startswith(begin):
            limits = message.replace(begin, words, 1)
            if words == "write ":
                return f"{name}: there is no {quoted(given)}; {limits}"
            return f"{name}: {given} is too {'large' if 'less' in begin else 'small'}; {limits}"
    return f"{name}: {message}"


def _given(error: Any, message: str) -> object:
    """Value that was given, as pydantic notes it, or as click quotes it."""
    found = error.__cause__.errors() if hasattr(error.__cause__, "errors") else []
    if found:
        return found[0].get("input", "")
    quote = re.match(r"'(.*)' is not ", message)
    return quote[1] if quote else ""
