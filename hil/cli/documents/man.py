"""The man page ``hil(1)``, from the definition of the command line and the tables of its surroundings."""

import re
from collections.abc import Mapping

import typer

from hil import __version__
from hil.cli.documents.command_tree import CliCommand, CliParameter, commands
from hil.cli.documents.surroundings import ENVIRONMENT, FILES
from hil.cli.framework.exit_codes import EXIT_CODES

HEAD = """\
.\\" Written by `hil reference --man`; do not edit.
.TH HIL 1 "" "hil {version}" "User Commands"
.SH NAME
hil \\- virtual motion\\-control boards behind real serial ports
.SH SYNOPSIS
.B hil
.I COMMAND
.RI [ OPTION... ]
.RI [ ARGUMENT... ]
.SH DESCRIPTION
"""
ABOUT = (
    "`hil serve` runs a bench: boards that a configuration names, each with its firmware, its control law and"
    " its motor, behind a pseudo-terminal or a TCP socket. A client's bytes are answered as the real board"
    " would answer them, at the time it would. The other commands talk to benches that run, as the same user"
    " on the same computer, or work on files.",
    "Where only one bench runs, it is meant; --bench chooses among several.",
)
_SIGNS = {"\\": "\\e", "-": "\\-", "'": "\\(aq", "^": "\\(ha", "~": "\\(ti"}


def man_page(app: typer.Typer) -> str:
    """Write the page in the language of man(7)."""
    root = commands(app)
    parts = [HEAD.format(version=__version__), "\n.PP\n".join(map(_text, ABOUT)), "\n"]
    parts += [_options(root), ".SH COMMANDS\n"]
    parts += [_command(each) for each in root.all() if each.path]
    parts += [_table("EXIT STATUS", {str(code): meaning for code, meaning in EXIT_CODES.items()})]
    parts += [_table("ENVIRONMENT", ENVIRONMENT), _table("FILES", FILES)]
    parts.append(".SH SEE ALSO\n.BR picocom (1),\n.BR systemctl (1),\n.BR wireshark (1)\n")
    return "".join(parts)


def _command(command: CliCommand) -> str:
    words = [f"hil {command.name}"]
    words += ["[OPTION...]"] * (len(command.options) > 1) + ["COMMAND"] * bool(command.commands)
    words += [each.usage for each in command.arguments]
    paragraphs = command.about.split("\n\n")
    text = "\n.PP\n".join(_text(" ".join(each.split())) for each in paragraphs)
    return f'.SS "{_text(" ".join(words))}"\n{text}\n{_arguments(command)}{_options(command)}'


def _arguments(command: CliCommand) -> str:
    return "".join(f".TP\n.I {_text(each.placeholder)}\n{_about(each)}\n" for each in command.arguments)


def _options(command: CliCommand) -> str:
    text = ""
    for option in command.options:
        if option.name != "help" or not command.path:
            value = f" \\fI{_text(option.placeholder)}\\fR" if option.takes_value else ""
            flags = ", ".join(f"\\fB{_text(flag)}\\fR{value}" for flag in option.flags)
            text += f".TP\n{flags}\n{_about(option)}\n"
    return text


def _about(parameter: CliParameter) -> str:
    told = [parameter.about] if parameter.about else []
    told += [f"[default: {parameter.default}]"] if parameter.default else []
    told += ["Needed."] if parameter.is_required and parameter.flags else []
    return _text(" ".join(told))


def _table(title: str, rows: Mapping[str, str]) -> str:
    return f".SH {title}\n" + "".join(
        f".TP\n.B {_text(name)}\n{_text(about)}\n" for name, about in rows.items()
    )


def _text(text: str) -> str:
    """Format one line of roff; what stands in backquotes is bold."""
    plain = "".join(_SIGNS.get(sign, sign) for sign in text)
    bold = re.sub("`([^`]*)`", r"\\fB\1\\fR", plain).replace("`", "\\(ga")
    return f"\\&{bold}" if bold.startswith((".", "'")) else bold
