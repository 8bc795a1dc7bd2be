"""The reference of every interface, written from the tables in the code (``docs/reference.md``)."""

import typer

from hil.compose import find_catalogue
from hil.config import reference as config_reference
from hil.core import FIELDS
from hil.daemon.control import CONTROL_VERSION, VERBS


def reference(app: typer.Typer) -> str:
    """Markdown: configuration, commands, control socket, fields of an axis."""
    parts = [
        "# Reference\n\nWritten by `hil reference` from the tables in the code; do not edit.\n",
        config_reference(find_catalogue()),
        _commands(app),
        _verbs(),
        _fields(),
    ]
    return "\n".join(part.rstrip("\n") + "\n" for part in parts)


def _commands(app: typer.Typer) -> str:
    group = typer.main.get_command(app)
    rows = ["## Commands\n", "| command | what it does |", "|---|---|"]
    for name, command in getattr(group, "commands", {}).items():
        if not command.hidden:
            arguments = " ".join(p.name.upper() for p in command.params if p.param_type_name == "argument")
            rows.append(f"| `hil {name}{' ' + arguments if arguments else ''}` | {command.help} |")
    return "\n".join(rows)


def _verbs() -> str:
    rows = [
        f"## Control socket (version {CONTROL_VERSION})\n",
        "`<runtime directory>/<bench>/control.sock`, a unix stream socket of mode 0660. One line of JSON",
        'is a request, `{"verb": "reset", "device": "m1"}`; one line is its answer,',
        '`{"ok": true, "result": ...}` or `{"ok": false, "error": "..."}`.\n',
        "| verb | arguments | what it does |",
        "|---|---|---|",
    ]
    rows += [f"| `{name}` | {', '.join(v.arguments) or '-'} | {v.meaning} |" for name, v in VERBS.items()]
    return "\n".join(rows)


def _fields() -> str:
    rows = ["## Fields of an axis\n", "A snapshot has them all, in this order.\n"]
    rows += ["| field | type | unit | settable | meaning |", "|---|---|---|---|---|"]
    for field in FIELDS.values():
        settable = "by firmware" if field.writable else ""
        rows.append(f"| `{field.name}` | {field.type} | {field.unit or '-'} | {settable} | {field.meaning} |")
    return "\n".join(rows)
