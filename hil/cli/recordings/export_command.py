"""The command that writes a recorded run as files of other programs."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.command_answers import CommandAnswer, wants_json
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.progress_bars import ShownProgress, bar
from hil.cli.recordings.opened import OfBench, Trust, control_step, opened, time_of
from hil.host.journal import say

if TYPE_CHECKING:
    from hil.recorded.exports.export_formats import ExportFormat
    from hil.recorded.recorded_run import RecordedRun
    from hil.telemetry.sampler import Interval
    from hil.vocab.time import SimTimeNs

_TIME = "as 12.5s, 1:02:03.5, 900ms, -10s before the end, or fault-1s before the latest fault"
_DEFAULT_INTERVAL_NS = 10_000_000
_MOST_USB_BAUD = 10_000_000


class Window(NamedTuple):
    """Options of the window that is looked at."""

    since: Annotated[
        str | None, typer.Option("--from", help=f"Where to begin, {_TIME}. [default: 0s]", metavar="TIME")
    ] = None
    to: Annotated[
        str | None, typer.Option("--to", help="Where to end. [default: the run's end]", metavar="TIME")
    ] = None


class Rate(NamedTuple):
    """Options that say how often axes are looked at."""

    every: Annotated[
        str | None,
        typer.Option(
            "--every",
            help="Simulated time between samples, as 10ms; or step: each control step. [default: 10ms]",
            metavar="TIME",
        ),
    ] = None
    rate_Hz: Annotated[
        float | None, typer.Option("--rate", help="Samples a simulated second, instead.", min=1e-3)
    ] = None


def export(
    log: Annotated[
        Path, typer.Argument(help="A recording: a file or bundle, or its name in `hil recordings`, as last.")
    ],
    names: Annotated[
        list[str] | None,
        typer.Argument(
            help="What to write: fields (m1.e, m1.*), axes (m1); of VCD pins and lines (m1.step, s1.tx,"
            " bus0); of pcapng ports and wires. [default: all that is usual]",
            metavar="NAME",
            show_default=False,
        ),
    ] = None,
    output: Annotated[
        str | None,
        typer.Option(
            "--output",
            "-o",
            help="The file; the end of its name says the format: .csv, .mcap, .vcd, .pcapng, .png, .svg,"
            " .pdf. - is the standard output. [default: a drawing in the terminal]",
            metavar="FILE",
        ),
    ] = None,
    form: Annotated[
        str | None, typer.Option("--format", help="The format, whatever the name says.", metavar="FORMAT")
    ] = None,
    window: Window = Window(),  # noqa: B008 - a named tuple does not change
    rate: Rate = Rate(),  # noqa: B008
    usb_baud: Annotated[
        int,
        typer.Option(
            "--usb-baud",
            help="Of VCD: draw ports on USB as lines of this speed; they have none of their own.",
            min=0,
            max=_MOST_USB_BAUD,
        ),
    ] = 0,
    yes: Annotated[bool, typer.Option("--yes", "-y", help="Write it however much it is.")] = False,
    trust: Trust = False,
    bench: OfBench = None,
) -> CommandAnswer:
    """Write what was in a recorded run: fields, pins, lines, bytes, packets, faults, verbs.

    The run is gone through again, so that all of it is there, at any rate. A recording that still grows is
    read up to its last whole second; the bench does not notice.

    Example: hil export bench.log m1.e m1.u -o moves.csv --from 10s --to 12s --every step

    Example: hil export bench.log -o bench.mcap --rate 100

    Example: hil export bench.log m1.step m1.dir bus0 -o lines.vcd
    """
    kind = None if output is None and form is None else _format(output, form)
    to_file = None if kind is None or output in (None, "-") else Path(output or "")
    _check_target(kind, to_file)
    with opened(log) as run:
        _be_polite(run)
        from_ns, to_ns = _window(run, window)
        made = _Export(run, kind, from_ns, to_ns, _interval(run, kind, rate, to_ns - from_ns), usb_baud)
        made.find_names(names or [])
        _check_size(made, yes)
        with bar(f"{log.name} is exported", "s simulated") as shown:
            answer = made.write(to_file, _told_to(shown, from_ns, to_ns))
        cut = run.log.cut
    if cut:
        say(f"hil: {log}: {cut}", sys.stderr)
    return answer


def _format(output: str | None, form: str | None) -> "ExportFormat":
    from hil.recorded.exports.export_formats import FORMATS, NoSuchFormat, format_of

    if output == "-" and form is None:
        raise fail(f"hil: add --format for the standard output: {', '.join(FORMATS)}", Exit.MISTAKE)
    try:
        return format_of(output or "", form)
    except NoSuchFormat as error:
        raise fail(f"hil: {error}", Exit.MISTAKE) from None


def _check_target(kind: "ExportFormat | None", file: Path | None) -> None:
    """Check before the run is gone through that it can be written."""
    if kind is None:
        return
    if file is None and not kind.is_text and sys.stdout.isatty():
        raise fail(f"hil: {kind.ending} is no text for a terminal: name a file with -o", Exit.MISTAKE)
    if file is not None and not file.parent.is_dir():
        raise fail(f"hil: {file}: there is no folder {file.parent}", Exit.MISTAKE)
    if file is not None and file.is_dir():
        raise fail(f"hil: {file}: it is a folder", Exit.MISTAKE)
    if kind.extra and not _has_extra(kind):
        raise fail(
            f"hil: .{kind.ending} needs what is not installed: pip install 'hil-motion[{kind.extra}]',"
            " or choose .csv",
            Exit.MISTAKE,
        )


def _has_extra(kind: "ExportFormat") -> bool:
    from importlib.util import find_spec

    module = {"mcap": "mcap", "plot": "matplotlib"}[kind.extra]
    return find_spec(module) is not None


def _be_polite(run: "RecordedRun") -> None:
    """Leave the processor to the bench that may still write the recording."""
    if run.log.cut:
        from hil.host.process import be_polite

        be_polite()


def _window(run: "RecordedRun", window: Window) -> "tuple[SimTimeNs, SimTimeNs]":
    from hil.recorded.time_words import time_text
    from hil.vocab.time import NS_PER_S, SimTimeNs

    end_ns = run.end_ns
    if run.log.cut and end_ns > NS_PER_S:  # what follows the last whole second may be missing
        end_ns = SimTimeNs(end_ns // NS_PER_S * NS_PER_S)
    from_ns = time_of("--from", window.since or "0s", run)
    to_ns = time_of("--to", window.to, run) if window.to else end_ns
    if from_ns > to_ns:
        text = f"hil: --from {time_text(from_ns)} is behind --to {time_text(to_ns)}; exchange them"
        raise fail(text, Exit.MISTAKE)
    return from_ns, to_ns


def _interval(run: "RecordedRun", kind: "ExportFormat | None", rate: Rate, length_ns: int) -> "Interval":
    from fractions import Fraction

    from hil.recorded.exports.drawn_export import drawn_interval_ns
    from hil.recorded.time_words import NoSuchTime, parse_length
    from hil.telemetry.sampler import interval_problem
    from hil.vocab.time import NS_PER_S

    if rate.every is not None and rate.rate_Hz is not None:
        raise fail("hil: choose one of --every and --rate", Exit.MISTAKE)
    if rate.every == "step":
        return control_step(run)
    interval_ns: Interval = _DEFAULT_INTERVAL_NS
    option = f"--every {rate.every}"
    if rate.rate_Hz is not None:
        option, interval_ns = f"--rate {rate.rate_Hz:g}", Fraction(NS_PER_S) / Fraction(str(rate.rate_Hz))
    elif rate.every is not None:
        try:
            interval_ns = parse_length(rate.every)
        except NoSuchTime:
            text = f"{rate.every!r} is no time; write it as 10ms, 50us, 1s, or step"
            raise fail(f"hil: --every: {text}", Exit.MISTAKE) from None
    elif kind is None or kind.is_picture:
        interval_ns = drawn_interval_ns(length_ns)
    if problem := interval_problem(interval_ns):
        raise fail(f"hil: {option}: {problem}", Exit.MISTAKE)
    return interval_ns


def _check_size(made: "_Export", yes: bool) -> None:
    size = made.size()
    if size is None or not size.is_large or yes:
        return
    remedy = "take less with --from, --to and --every, or add --yes"
    if wants_json() or not (sys.stdin.isatty() and sys.stderr.isatty()):
        raise fail(f"hil: this would be {size.words()}: {remedy}", Exit.MISTAKE)
    if not typer.confirm(f"This would be {size.words()}. Go on?", err=True):
        raise fail(f"hil: nothing was written; {remedy}", Exit.MISTAKE)


def _told_to(shown: ShownProgress, from_ns: int, to_ns: int) -> Callable[[int], object]:
    """Function that tells how far the window is gone through."""
    return lambda now_ns: shown.tell((now_ns - from_ns) / 1e9, (to_ns - from_ns) / 1e9)


class _Export:
    """Export of a run in a format; None: a drawing in the terminal."""

    def __init__(
        self,
        run: "RecordedRun",
        kind: "ExportFormat | None",
        from_ns: "SimTimeNs",
        to_ns: "SimTimeNs",
        interval_ns: "Interval",
        usb_baud: int,
    ) -> None:
        self._run, self._kind = run, kind
        self._window = from_ns, to_ns
        self._interval_ns = interval_ns
        self._usb_baud = usb_baud
        self._fields: list[Any] = []
        self._names: list[str] = []
        self._sources: list[Any] = []

    def find_names(self, names: list[str]) -> None:
        """Find what is meant. Raises Exit with 2: a name is nothing that there is."""
        from hil.recorded.exports import export_names
        from hil.recorded.exports.export_formats import Named
        from hil.recorded.recorded_fields import NoSuchField

        named = self._kind.named if self._kind else Named.FIELDS
        try:
            if named is Named.FIELDS:
                self._fields = export_names.wanted_fields(self._run, names)
            elif named is Named.ALL:
                self._fields, self._names = export_names.wanted_of_all(self._run, names)
            elif named is Named.SOURCES:
                from hil.recorded.exports.run_records import record_sources

                known = [*record_sources(self._run.runtime)]
                self._names = export_names.wanted_of(names, known, "port or wire")
            else:
                self._find_signals(names)
        except (NoSuchField, export_names.NoSuchSignal) as error:
            raise fail(f"hil: {error}", Exit.MISTAKE) from None
        if not self._fields and not self._names:
            raise fail(
                f"hil: this run has nothing for this format: no {named.value.partition(':')[0]}", Exit.MISTAKE
            )

    def _find_signals(self, names: list[str]) -> None:
        from hil.recorded.exports.export_names import NoSuchSignal, wanted_of
        from hil.recorded.exports.signal_sources import signal_sources, usb_ports

        self._sources = signal_sources(self._run, self._usb_baud)
        known = [name for source in self._sources for name in source.names]
        usb = [] if self._usb_baud else usb_ports(self._run.runtime)
        lines = {f"{port}.{way}" for port in usb for way in ("rx", "tx")}
        if asked := lines.intersection(names):
            raise NoSuchSignal(
                f"{', '.join(sorted(asked))}: bytes on USB take no time, so that there is no line;"
                " --usb-baud 115200 draws it as one of that speed"
            )
        self._names = wanted_of(names, known, "pin or line")
        if usb and not names:
            say(
                f"hil: ports on USB ({', '.join(usb)}) have no line and are left out; --usb-baud draws them",
                sys.stderr,
            )

    def size(self) -> Any:
        """Size of its samples, about; None: it has none that are counted before."""
        from hil.recorded.exports.export_formats import FORMATS
        from hil.recorded.exports.export_size import export_size

        if not self._fields:
            return None
        length_ns = self._window[1] - self._window[0]
        return export_size(self._kind or FORMATS["svg"], self._fields, length_ns, self._interval_ns)

    def write(self, file: Path | None, told: Callable[[int], object]) -> CommandAnswer:
        """Write it, whole or not at all. Raises Exit: it cannot be written."""
        from hil.cli.recordings.export_writing import draw_in_terminal, write_drawn, write_stream

        run, (from_ns, to_ns) = self._run, self._window
        if self._kind is None:
            return draw_in_terminal(run, self._fields, from_ns, to_ns, self._interval_ns, told)
        if self._kind.is_picture:
            return write_drawn(self._kind, file, run, self._fields, from_ns, to_ns, self._interval_ns, told)
        return write_stream(self._kind.ending, file, self._writer(told), self._what(), from_ns, to_ns)

    def _what(self) -> str:
        return ", ".join([*map(str, self._fields), *self._names])

    def _writer(self, told: Callable[[int], object]) -> Callable[[Any], int]:
        """Function that writes into a binary file and answers how many rows, messages, edges or records."""
        run, (from_ns, to_ns), interval_ns = self._run, self._window, self._interval_ns
        fields, names, ending = self._fields, self._names, self._kind.ending if self._kind else ""
        if ending == "csv":
            from hil.recorded.exports.csv_table import write_csv

            return lambda file: write_csv(file, run, fields, from_ns, to_ns, interval_ns, told)
        if ending == "mcap":
            from hil.recorded.exports.mcap_export import McapContent, write_mcap

            content = McapContent(fields, names)
            return lambda file: write_mcap(file, run, content, from_ns, to_ns, interval_ns, told)
        if ending == "vcd":
            from hil.recorded.exports.vcd_export import write_vcd

            return lambda file: write_vcd(file, run, self._sources, names, from_ns, to_ns, told)
        from hil.recorded.exports.capture_export import write_capture

        return lambda file: write_capture(file, run, names, from_ns, to_ns, told)
