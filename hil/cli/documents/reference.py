"""The reference of every interface, written from the tables in the code (``docs/reference.md``)."""

import json
import re
from collections.abc import Iterator
from dataclasses import replace

import typer

from hil.cli.bench.port_views import programs_section
from hil.cli.documents.command_tree import HELP, commands
from hil.cli.documents.surroundings import ENVIRONMENT, FILES, READY
from hil.cli.framework.exit_codes import EXIT_CODES
from hil.compose.decoded_item import KEYS
from hil.compose.find import bridge_reference, find_boards, find_catalogue
from hil.config import reference as config_reference
from hil.core import FIELDS
from hil.core import KINDS as KINDS_OF_AXIS
from hil.discovery.named_kinds import find_wire_infos
from hil.gcode.gcode_reference import gcode_reference
from hil.operations.answer_schemas import answer_schema
from hil.operations.control_socket import CONTROL_VERSION
from hil.operations.health import problem_kinds
from hil.operations.metrics import metric_rows
from hil.operations.table import OPERATIONS
from hil.recorded.exports.export_formats import formats_table
from hil.runs.run_document import run_reference
from hil.sim.log_format import log_reference
from hil.sim.twin_info import twin_info
from hil.toolpath.machine import machine_reference
from hil.vocab.desk_protocol import DeviceInfo
from hil.vocab.fault_words import shown_by
from hil.vocab.faults import FAULT_KINDS, TARGETS, TIMING
from hil.vocab.monitoring import FAILED, LATE, LATE_KINDS, STATES
from hil.vocab.verbs import CODES, COMMON, Verb


def reference(app: typer.Typer) -> str:
    """Write Markdown: configuration, commands, control socket, fields of an axis."""
    parts = [
        "# Reference\n\nWritten by `hil reference` from the tables in the code; do not edit.\n",
        re.sub("^#", "##", config_reference(find_catalogue()), flags=re.M),
        programs_section(),
        _commands(app),
        _surroundings(),
        _verbs(),
        _device_verbs(),
        run_reference(),
        gcode_reference(),
        machine_reference(),
        _metrics(),
        *(bridge_reference(kind) for kind in sorted(find_catalogue().bridges)),
        _faults(),
        _fields(),
        log_reference(),
        *(bus.reference(_twins()) for bus in find_catalogue().buses if bus.reference),
    ]
    return "\n".join(part.rstrip("\n") + "\n" for part in parts)


_GRAMMAR = """\
`hil VERB OBJECT`. `--bench` (`-b`), `--runtime-dir` and `--json` stand before the verb or behind it. A
command without `--bench` or `--json` refuses it. `HIL_BENCH` is a bench for all commands. Names of verbs are
taken with - and with _: `move-abs`, `move_abs`. `-h` is `--help`.

With `--json` a command prints one line of JSON on its standard output: what it answers, with the names of the
control socket's answers; or, of one that fails, `{"error": {"message": "...", "exit_code": 2}}`, with the
command's exit code. `error` has `problems` where it lists some, each with `file`, `line`, `column`,
`message` and `remedy`. `capture` and `decode` print a line for each item.
"""


def _commands(app: typer.Typer) -> str:
    rows = ["## Commands\n", _GRAMMAR, "| command | what it does |", "|---|---|"]
    options: dict[tuple[str, str], list[str]] = {}
    for command in (each for each in commands(app).all() if each.path):
        words = " ".join([command.name, *(each.usage for each in command.arguments)])
        rows.append(f"| `hil {words}` | {_cell(command.about)} |")
        for option in (each for each in command.options if each is not HELP):
            flags = ", ".join(f"`{flag}`" for flag in option.flags)
            options.setdefault((flags, _cell(option.about)), []).append(command.name)
    rows += ["", "| option | of | meaning |", "|---|---|---|"]
    for (opts, meaning), names in options.items():
        rows.append(f"| {opts} | {', '.join(f'`{name}`' for name in names)} | {meaning} |")
    return "\n".join(rows)


def _surroundings() -> str:
    rows = ["### Exit codes\n", "| code | meaning |", "|---|---|"]
    rows += [f"| {code} | {_cell(meaning)} |" for code, meaning in EXIT_CODES.items()]
    rows += ["\n### What `hil serve` tells programs\n"]
    rows += ["With `--json` and `--ready-file`, when the boards answer: one JSON object.\n"]
    rows += ["| key | meaning |", "|---|---|"]
    rows += [f"| `{name}` | {_cell(meaning)} |" for name, meaning in READY.items()]
    rows += ["\n### What `hil capture` and `hil decode` tell programs\n"]
    rows += ["With `--json`, for each packet, frame, line of bytes and event: one JSON object in a line.\n"]
    rows += ["| key | meaning |", "|---|---|"]
    rows += [f"| `{name}` | {_cell(meaning)} |" for name, meaning in KEYS.items()]
    rows += ["\n### Formats of `hil export`\n", formats_table()]
    rows += ["\n### Environment\n", "| variable | meaning |", "|---|---|"]
    rows += [f"| `{name}` | {_cell(meaning)} |" for name, meaning in ENVIRONMENT.items()]
    rows += ["\n### Files\n", "| file | what it is |", "|---|---|"]
    rows += [f"| `{name}` | {_cell(about)} |" for name, about in FILES.items()]
    return "\n".join(rows) + "\n"


def _cell(text: str) -> str:
    """Format the text of a table's cell: one line, and no column's end."""
    return " ".join(text.split()).replace("|", r"\|")


def _verbs() -> str:
    rows = [
        f"## Control socket (version {CONTROL_VERSION})\n",
        "`<runtime directory>/<bench>/control.sock`, a unix stream socket of mode 0660. One line of JSON",
        'is a request, `{"verb": "reset", "device": "m1"}`; one line is its answer,',
        '`{"ok": true, "result": ...}` or `{"ok": false, "error": "...", "code": "..."}` (see Codes of',
        "refusals). Programs that can open the socket may do everything; users of bridges may do what their"
        " role allows.\n",
        "| verb | of | parameters | role | what it does |",
        "|---|---|---|---|---|",
    ]
    for operation in OPERATIONS.values():
        if operation.answer is not None:
            of = f"`{argument}`" if (argument := operation.target.argument) else "-"
            taken = "<br>".join(f"`{p.name}`: {_cell(p.described())}" for p in operation.parameters)
            cells = (f"`{operation.name}`", of, taken or "-", operation.role.name.lower(), operation.about)
            rows.append(f"| {' | '.join(cells)} |")
    return "\n".join([*rows, *_answers()])


def _answers() -> Iterator[str]:
    """Lines of the schemas of answers: one JSON object, a line for each verb."""
    yield "\n### Answers\n"
    yield "JSON Schema (draft 2020-12) of each verb's `result`. Objects may have other keys, too.\n"
    schemas = {
        each.name: answer_schema(each.answer) for each in OPERATIONS.values() if each.answer is not None
    }
    yield "```json"
    yield ",\n".join(f'"{name}": {json.dumps(schema)}' for name, schema in schemas.items()).join(("{", "}"))
    yield "```"


def _device_verbs() -> str:
    parts = [
        "## Verbs of devices\n",
        "By `hil axis DEVICE VERB`, the control socket's `do`, the bridges and the client; every twin has"
        " those of all boards. A verb's role is the least that may use it.\n",
    ]
    tables: dict[str, tuple[Verb, ...]] = {"All boards": COMMON}
    tables |= {f"`{name}`": board.verbs for name, board in sorted(find_boards().items()) if board.verbs}
    for title, verbs in tables.items():
        parts.append(f"### {title}\n\n| verb | role | what it does | parameters |\n|---|---|---|---|")
        for verb in verbs:
            taken = "<br>".join(f"`{p.name}`: {_cell(p.described())}" for p in verb.parameters)
            parts.append(f"| `{verb.name}` | {verb.role.name.lower()} | {_cell(verb.about)} | {taken} |")
        parts.append("")
    parts.append("### Codes of refusals\n\n| code | meaning |\n|---|---|")
    parts += [f"| `{code}` | {meaning} |" for code, meaning in CODES.items()]
    return "\n".join(parts)


def _state(kind: str) -> str:
    return LATE if kind in LATE_KINDS else FAILED


def _metrics() -> str:
    rows = [
        "## Health\n",
        "`hil status`, `sim/health` over zenoh and the metrics have one of three states:\n",
        "| state | meaning |",
        "|---|---|",
        *(f"| `{state}` | {meaning} |" for state, meaning in STATES.items()),
        "\nWhat makes a bench late or failed:\n",
        "| kind | state | meaning |",
        "|---|---|---|",
        *(
            f"| `{kind}` | {_state(kind)} | {_cell(meaning)} |"
            for kind, meaning in problem_kinds(find_wire_infos()).items()
        ),
        "\n## Metrics\n",
        "With `bridges: {metrics: {}}`. Names and units follow Prometheus; a histogram has buckets by powers"
        " of two from 1 us to 1 s.\n",
        "| metric | kind | labels | meaning |",
        "|---|---|---|---|",
    ]
    for metric, _ in metric_rows(find_wire_infos()):
        labels = ", ".join(f"`{label}`" for label in metric.labels)
        rows.append(f"| `{metric.name}` | {metric.kind} | {labels} | {_cell(metric.about)} |")
    return "\n".join(rows)


def _faults() -> str:
    rows = [
        "## Faults\n",
        "Kinds for `hil fault inject KIND TARGET name=value ...`, the verb `inject` and the key `faults`.\n",
        "| kind | layer | on | what goes wrong | how it shows | parameters |",
        "|---|---|---|---|---|---|",
    ]
    for kind in FAULT_KINDS.values():
        parameters = [f"`{each.name}`: {each.described()}" for each in kind.parameters]
        said = (TARGETS[kind.target], kind.about, shown_by(kind))
        cells = (f"`{kind.name}`", kind.layer, *said, "; ".join(parameters))
        rows.append("| " + " | ".join(cells) + " |")
    rows += ["", *(f"Every kind takes `{each.name}`: {each.described()}." for each in TIMING)]
    return "\n".join(rows) + "\n"


def _fields() -> str:
    rows = ["## Fields of an axis\n", "A snapshot has them all, in this order.\n"]
    rows += ["| field | type | unit | settable | meaning |", "|---|---|---|---|---|"]
    set_from_outside = {name for kind in KINDS_OF_AXIS.values() for name in kind.settable}
    for field in FIELDS.values():
        settable = "`hil set`" if field.name in set_from_outside else "by firmware" if field.writable else ""
        meaning = _cell(field.meaning)
        rows.append(f"| `{field.name}` | {field.type} | {field.unit or '-'} | {settable} | {meaning} |")
    return "\n".join(rows)


def _twins() -> list[DeviceInfo]:
    """A twin of each kind of board that has one axis."""
    catalogue, twins = find_catalogue(), list[DeviceInfo]()
    for name, profile in sorted(catalogue.profiles.items()):
        if profile.law is not None:
            info = twin_info(name, name, catalogue.boards[name], KINDS_OF_AXIS[profile.law])
            twins.append(replace(info, own_map=catalogue.own_map(None, profile)))
    return twins
