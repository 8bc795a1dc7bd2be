"""Table of the programs that can use each port, for `hil list --programs` and the reference."""

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from hil.cli.framework.shown_view import Grid, Line, ShownView, line
from hil.vocab.port_programs import PORT_USES, PROGRAMS, VERDICTS, PortUse, port_use

HELPS = "Helps"
HINT = "Which programs can use which port, and what helps the others: hil list --programs"


class ListedPort(NamedTuple):
    """Port of a bench. ``use``: None: of a kind that nobody tried programs at."""

    name: str
    address: str
    use: PortUse | None


def listed_ports(listed: dict[str, Any]) -> Iterator[ListedPort]:
    """Ports of a bench, from the answer of the verb ``list``."""
    for row in listed["devices"]:
        rows = {row["device"]: {"kind": row["port"], "address": row["address"]}} | row["ports"]
        for name, port in rows.items():
            if port["address"]:
                yield ListedPort(name, port["address"], port_use(port["kind"], port["address"]))
    for tap in listed["taps"]:
        yield ListedPort(tap["tap"], tap["port"], port_use(tap["kind"], tap["port"]))


def verdict_grid(uses: Iterable[PortUse | None]) -> Grid | None:
    """Table of who can use these ports: a row for each kind of port; None without any."""
    kinds = {use.label: use for use in uses if use}
    heads = ("port", *PROGRAMS)
    rows = [(label, *_verdicts(use)) for label, use in kinds.items()]
    return Grid(heads, heads, rows) if rows else None


def _verdicts(use: PortUse) -> list[str]:
    return [use.uses[name].verdict for name in PROGRAMS]


def as_json(listed: dict[str, Any]) -> dict[str, Any]:
    """Uses of a bench's ports by their names, and by kind of program; null: nobody tried it."""
    return {
        port.name: {name: each._asdict() for name, each in port.use.uses.items()} if port.use else None
        for port in listed_ports(listed)
    }


def program_view(listed: dict[str, Any]) -> ShownView:
    """Table of a bench's kinds of port and kinds of program; below it what is missing, and what helps."""
    ports = list(listed_ports(listed))
    names: dict[str, list[str]] = {}
    kinds = {port.use.label: port.use for port in ports if port.use}
    for port in ports:
        names.setdefault(port.use.label if port.use else "another kind", []).append(port.name)
    blocks = list[Line | Grid]([line(f"bench {listed['bench']} (process {listed['pid']})")])
    if table := verdict_grid(kinds.values()):
        blocks.append(table)
    for label, those in names.items():
        blocks += [line(""), line(f"{label} ({', '.join(those)})", wraps=True)]
        if label in kinds:
            blocks += _reasons(kinds[label])
    return ShownView(*blocks)


def _reasons(use: PortUse) -> Iterator[Line | Grid]:
    if use.is_held:
        yield line(" At the other end: hil itself has this end open.", wraps=True)
    if rows := [(f"{name}:", f"{each.why}. {HELPS}: {each.help}") for name, each in use.shortfalls()]:
        yield Grid(("", ""), ("",), rows, prose=("",))


def verdict_table(programs: Iterable[str] = tuple(PROGRAMS)) -> str:
    """Markdown table of verdicts: a row for each kind of port."""
    rows = [f"| port | {' | '.join(programs)} |", f"|---|{'---|' * len(list(programs))}"]
    for use in PORT_USES.values():
        rows.append(f"| {use.label} | {' | '.join(use.uses[name].verdict for name in programs)} |")
    return "\n".join(rows)


def reasons_table(programs: Iterable[str] = tuple(PROGRAMS)) -> str:
    """Markdown table of what is missing and what helps; kinds of port with the same row share it."""
    labels: dict[tuple[str, Any], list[str]] = {}
    for program in programs:
        for use in PORT_USES.values():
            if (each := use.uses[program]).verdict != "yes":
                labels.setdefault((program, each), []).append(use.label)
    rows = [f"| programs | port | use | why | {HELPS.lower()} |", "|---|---|---|---|---|"]
    for (program, each), kinds in labels.items():
        rows.append(f"| {program} | {', '.join(kinds)} | {each.verdict} | {each.why} | {each.help} |")
    return "\n".join(rows)


def meanings() -> str:
    """Markdown list of what the verdicts mean."""
    return "\n".join(f"- **{verdict}**: {meaning}" for verdict, meaning in VERDICTS.items())


def programs_section() -> str:
    """Section of the reference."""
    parts = [
        "## Programs at ports\n",
        "Which kinds of program can use which kind of port.\n",
        "\n".join(f"- **{name}**: {about}" for name, about in PROGRAMS.items()) + "\n",
        verdict_table() + "\n",
        meanings() + "\n",
        "hil holds the address of a `serial` port open itself: programs are at the other end of its cable.\n",
        reasons_table(),
    ]
    return "\n".join(parts)
