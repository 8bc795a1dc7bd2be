"""The one table of formats in which a recorded run is written; the reference is made from it."""

from enum import Enum
from pathlib import PurePath
from typing import NamedTuple

from hil.vocab.near_words import meant


class Named(Enum):
    """Things that an export's names are."""

    FIELDS = "fields of axes: m1.e"
    SIGNALS = "pins and lines: m1.step, s1.rx, bus0"
    SOURCES = "ports and wires: s1, bus0"
    ALL = "fields of axes, ports, wires"


class ExportFormat(NamedTuple):
    """Format of a file. ``ending``: of its name, without the dot; ``opened_by``: programs that read it."""

    ending: str
    named: Named
    about: str
    opened_by: str
    extra: str = ""
    """Extra of hil-motion that it needs."""
    is_text: bool = False

    @property
    def is_picture(self) -> bool:
        return self.extra == "plot"


_PICTURE = "drawn, one panel for each unit, as `hil plot -o` does"
FORMATS = {
    each.ending: each
    for each in (
        ExportFormat(
            "csv",
            Named.FIELDS,
            "one table of all axes: `at_s`, simulated seconds since the run's start, and a column for each"
            " field, with its unit",
            "spreadsheets, pandas, PlotJuggler",
            is_text=True,
        ),
        ExportFormat(
            "mcap",
            Named.ALL,
            "a channel for each axis, each direction of a port, each wire (packets and frames in words),"
            " faults, verbs, other inputs, and a log; JSON with schemas",
            "Foxglove, Lichtblick, PlotJuggler, Rerun",
            "mcap",
        ),
        ExportFormat(
            "vcd",
            Named.SIGNALS,
            "pins, serial lines and buses, each edge at its nanosecond",
            "GTKWave, PulseView, sigrok-cli",
            is_text=True,
        ),
        ExportFormat(
            "pcapng",
            Named.SOURCES,
            "bytes at ports, bursts and frames of wires, as `hil capture -w` writes them",
            "`hil decode`, Wireshark, tshark",
        ),
        ExportFormat("png", Named.FIELDS, _PICTURE, "all", "plot"),
        ExportFormat("svg", Named.FIELDS, _PICTURE, "browsers", "plot"),
        ExportFormat("pdf", Named.FIELDS, _PICTURE, "all", "plot"),
    )
}


class NoSuchFormat(ValueError):
    """Error of a name that says no format: ``str(error)`` says which there are."""


def format_of(file: str, name: str | None = None) -> ExportFormat:
    """Format of a file by the end of its name, or by its own name.

    Raises:
        NoSuchFormat: it is none.
    """
    ending = PurePath(file).suffix.lower().removeprefix(".") if name is None else name.lower()
    if found := FORMATS.get(ending):
        return found
    if name is None and not ending:
        raise NoSuchFormat(
            f"{file}: its name does not say in which format: end it with .{', .'.join(FORMATS)},"
            " or add --format"
        )
    raise NoSuchFormat(f"{name or file}: there is no format {ending!r}; {meant(ending, FORMATS)}")


def formats_table() -> str:
    """Table of the formats as Markdown."""
    lines = ["| format | what is in it | names | opened by | extra |", "|---|---|---|---|---|"]
    for each in FORMATS.values():
        extra = f"`{each.extra}`" if each.extra else ""
        lines.append(f"| `.{each.ending}` | {each.about} | {each.named.value} | {each.opened_by} | {extra} |")
    return "\n".join(lines) + "\n"
