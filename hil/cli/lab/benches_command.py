"""``hil list --joined`` and ``hil list --connect``: benches that are joined to this one, or a lab's."""

import socket
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import typer

from hil.cli.framework.ask import ANY_BENCH, BenchOptions, fail
from hil.cli.framework.command_answers import CommandAnswer, wants_json
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.progress_bars import bar
from hil.cli.framework.shown_view import Grid, ShownView, line
from hil.cli.framework.shown_words import counted
from hil.cli.lab.lab_options import (
    NO_LAB,
    EverySeconds,
    LabelWords,
    LabOptions,
    PrometheusFile,
    wanted_labels,
)
from hil.cli.lab.prometheus_targets import NoTargets, read_targets, targets, write_targets
from hil.cli.runs.run_reports import clock_words
from hil.vocab.bridge_protocol import PROTOCOL_VERSION

LATELY_S = 600
"""Time for which a command makes its asker one who commands."""
_LATER = ("hil", "labels", "host", "commanded by", "lease")
"""Columns that a narrow terminal has below the rows, the first ones first."""
_COLUMNS = ("bench", "health", "devices", "runs", "commanded by", "lease", "hil", "host", "labels")


def benches(
    lab: LabOptions = NO_LAB,
    label: LabelWords = None,
    prometheus: PrometheusFile = None,
    every_s: EverySeconds = None,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """List the benches that are joined to this one, or those of a lab.

    Without --connect and --config: those joined to the bench here, with the offsets of their clocks. With one
    of them, from any computer: health with its reason, runs, who commands, versions, labels.

    Example: hil list --connect tcp/127.0.0.1:7447 --label rig=press
    """
    wanted = wanted_labels(label)
    if (prometheus or every_s) and not (prometheus and lab.are_given):
        raise fail(
            "hil: --prometheus takes --connect or --config, and --every takes --prometheus", Exit.MISTAKE
        )
    if prometheus:
        return _write_targets(prometheus, lab, wanted, every_s)
    if lab.are_given:
        with lab.opened() as session, bar("benches of the lab are asked"):
            rows = session.benches(wanted)
        if not rows and not wants_json():
            typer.echo("no bench there has these labels" if wanted else "no bench is joined there", err=True)
        return CommandAnswer(rows, lab_view(rows, time.time_ns()).text() if rows else "")
    if wanted:
        raise fail("hil: --label: name the lab with --connect or --config", Exit.MISTAKE)
    return _joined_here(bench)


def _joined_here(bench: BenchOptions) -> CommandAnswer:
    rows = bench.ask("benches")
    if not rows and not wants_json():
        typer.echo("no other bench is joined to this one", err=True)
    said = [
        f"{row['bench']}: {row['why'] or 'hil ' + row['version'] + ', ' + clock_words(row)}" for row in rows
    ]
    return CommandAnswer(rows, "\n".join(said))


def _write_targets(
    path: Path, lab: LabOptions, wanted: dict[str, str], every_s: float | None
) -> CommandAnswer:
    """Write the file of targets, once or again and again until the command is ended."""
    told: list[str] | None = None
    try:
        with lab.opened() as session:
            while True:
                before = read_targets(path)
                made = targets(session.benches(wanted), before, socket.gethostname())
                if made.entries != before or not path.exists():
                    write_targets(path, made.entries)
                if told != made.remarks:
                    for remark in made.remarks:
                        typer.echo(f"hil: {remark}", err=True)
                    told = made.remarks
                if every_s is None:
                    return CommandAnswer(made.entries, f"{path}: {counted(len(made.entries), 'target')}")
                time.sleep(every_s)
    except NoTargets as error:
        raise fail(f"hil: {error}", Exit.MISTAKE) from None
    except OSError as error:
        raise fail(f"hil: {path}: {error.strerror}") from None


def lab_view(rows: Sequence[Mapping[str, Any]], wall_ns: int) -> ShownView:
    """Table of the benches of a lab, and below it what is wrong with them. ``wall_ns``: now, since 1970."""
    cells = [_cells(row, wall_ns) for row in rows]
    remarks = [f"{row['bench']}: {why}" for row in rows for why in _remarks(row)]
    return ShownView(Grid(_COLUMNS, _COLUMNS, cells, later=_LATER), *map(line, remarks))


def _cells(row: Mapping[str, Any], wall_ns: int) -> list[str]:
    devices = row["devices"]
    if "health" not in row:
        return [row["bench"], "?", str(len(devices)), *[""] * (len(_COLUMNS) - 3)]
    real = sum(each["is_real"] for each in devices.values())
    lately = [who["who"] for who in row["commanders"] if wall_ns - who["wall_ns"] < LATELY_S * 1e9]
    lease = row["lease"]
    mark = "" if row["protocol"] == PROTOCOL_VERSION else f", protocol {row['protocol']}"
    return [
        row["bench"],
        row["health"]["state"],
        f"{len(devices)}, {real} real" if real else str(len(devices)),
        ", ".join(f"{run['run']} ({run['state']})" for run in row["runs"]),
        ", ".join(lately),
        str(lease["user"]) if lease else "",
        row["version"] + mark,
        row["host"],
        ", ".join(f"{name}={value}" for name, value in row["labels"].items()),
    ]


def _remarks(row: Mapping[str, Any]) -> list[str]:
    found = [row["why"]] if row["why"] else []
    if "health" not in row:
        return found
    if (there := row["protocol"]) != PROTOCOL_VERSION:
        older = "this computer" if there > PROTOCOL_VERSION else "it"
        here = f"hil here {PROTOCOL_VERSION}"
        found.append(f"it speaks protocol {there} between benches, {here}: update {older}")
    for each in row["health"]["problems"]:
        about = f"{each['about']}: " if each["about"] else ""
        found.append(f"{about}{each['what']}; {each['remedy']}")
    if left_out := row["health"]["problems_left_out"]:
        found.append(f"and {counted(left_out, 'problem')} more")
    return found
