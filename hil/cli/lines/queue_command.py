"""``hil line queue``: a queue's file into many nodes at once, and back from their terminals."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hil.cli.framework.ask import BenchOptions, fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.framework.exit_codes import Exit
from hil.cli.lines.named_lines import (
    ANY_LINE,
    LineOptions,
    NodeNames,
    OneLine,
    addresses,
    exit_of_rows,
    line_of,
    on_lines,
    place_of,
    row_of,
)

if TYPE_CHECKING:
    from hil.master import LinePlace, LiveMaster
    from hil.vocab.line_node import NodeUpload

LOOKS, LOOK_S = 10, 0.1
"""Number of looks whether a terminal is free, and their interval."""
NOT_READ = "nobody read them back: no terminal of this node is free here"


def queue(
    line: OneLine,
    node: NodeNames,
    file: Annotated[Path, typer.Argument(help="The queue's file.", metavar="FILE", show_default=False)],
    steps_per_rev: Annotated[
        int | None, typer.Option("--steps-per-rev", help="Steps of the motors' turn. [default: 200]", min=1)
    ] = None,
    read_back: Annotated[
        bool,
        typer.Option("--read-back/--no-read-back", help="Compare with what terminals of the bench list."),
    ] = True,
    options: LineOptions = ANY_LINE,
) -> CommandAnswer:
    """Write a queue's file into nodes, all at once, and read it back.

    A line cannot list a queue. At a tap of a bench, hil reads it back at the nodes' terminals; elsewhere it
    says that nobody looked. Rows may come twice, so that those without an answer are repeated.

    Example: hil line queue bus0.master 85 moves.txt
    """
    from hil.vocab.dialogue import Refusal

    place = place_of(line, options)
    units = [each for each in addresses(node, place.nodes) if each != place.nodes.to_all]
    if not units:
        raise fail("hil: name the nodes: who is told with all others does not answer", Exit.MISTAKE)
    try:
        upload = place.nodes.queue_upload(file.read_bytes(), str(file), steps_per_rev)
    except OSError as error:
        raise fail(f"hil: {file}: {error.strerror}", Exit.MISTAKE) from None
    except Refusal as error:
        raise fail(str(error), Exit.MISTAKE) from None

    async def work(masters: "Sequence[LiveMaster]") -> list[dict[str, Any]]:
        (live,) = masters
        sent = [live.start(unit, each) for each in upload.commands for unit in units]
        await live.settled(sent)
        return [row_of(line, each) for each in sent]

    rows = on_lines([place], 3, work)
    back = _read_back(place, units, upload, options.bench) if read_back else {}
    return _told(line, units, rows, back)


def _told(
    line: str, units: Sequence[int], rows: Sequence[dict[str, Any]], back: Mapping[int, Sequence[str]]
) -> CommandAnswer:
    answer, lines = [], []
    for unit in units:
        own = [row for row in rows if row["node"] == unit]
        missing = [row for row in own if row["outcome"] != "done"]
        is_read, differs = unit in back, list(back.get(unit, ()))
        answer.append(
            {
                "line": line,
                "node": unit,
                "done": len(own) - len(missing),
                "rows": own,
                "is_read_back": is_read,
                "differences": differs,
            }
        )
        seen = ("read back, and differs" if differs else "read back, as sent") if is_read else NOT_READ
        lines.append(f"{unit}: {len(own) - len(missing)} of {len(own)} rows are there; {seen}")
        lines += [f"  {line_of(row, names_line=False)}" for row in missing]
        lines += [f"  {each}" for each in differs]
    code = exit_of_rows(rows)
    is_wrong = any(each["differences"] for each in answer)
    return CommandAnswer(answer, "\n".join(lines), Exit.FAILED if is_wrong and not code else code)


def _is_free(control: Path, device: str) -> bool:
    """Answer whether nobody has a device's terminal open; one that has just closed it is counted a while.
    Raises ControlError: the bench does not answer."""
    import time

    from hil.net.control_client import ask

    for look in range(LOOKS):
        time.sleep(LOOK_S if look else 0)
        rows = {row["device"]: row for row in ask(control, "list")["devices"]}
        if device in rows and not rows[device]["clients"]:
            return True
    return False


def _read_back(
    place: "LinePlace",
    units: Sequence[int],
    upload: "NodeUpload",
    bench: BenchOptions,
) -> dict[int, Sequence[str]]:
    """Differences by node, of nodes whose terminal the bench has, and nobody else has open."""
    from hil.cli.framework.board_commands import SerialTalk
    from hil.master.line_place import is_address
    from hil.net.control_client import ControlError, ask
    from hil.vocab.dialogue import DialogueError

    if is_address(place.name):
        return {}
    here = bench.meant()
    try:
        listed, segments = ask(here.socket, "list"), ask(here.socket, "segments")
    except ControlError as error:
        typer.echo(f"hil: nothing is read back: {error}", err=True)
        return {}
    of_line = [row["stations"] for row in segments if place.name.startswith(row["segment"] + ".")]
    stations = {name.partition(".")[0] for each in of_line for name in each}
    found: dict[int, Sequence[str]] = {}
    for row in listed["devices"]:
        address = row["address"]
        if address is None or row["device"] not in stations:
            continue
        try:
            if not address.startswith("socket://") and not _is_free(here.socket, row["device"]):
                typer.echo(f"hil: {row['device']}: not read back: another program has it open", err=True)
                continue  # it would get some of the answers
            with SerialTalk(bench.port_of(address), place.baud, place.speed) as talk:
                unit = talk.run(place.nodes.address_at_terminal())
                if unit in units:
                    found[unit] = talk.run(upload.differences())
        except (ControlError, DialogueError) as error:
            typer.echo(f"hil: {row['device']}: not read back: {error}", err=True)
    return found
