"""``hil top``: a bench as it goes on, with plots of fields."""

import os
import select
import sys
import termios
import time
import tty
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hil.cli.bench.top_view import NS, Plot, TopState
from hil.cli.framework import interrupts
from hil.cli.framework.ask import ANY_BENCH, BenchOptions, fail

if TYPE_CHECKING:
    from hil.net.benches_here import Here

WINDOW_S = 30.0
FRAME_S = 0.25
"""Time between two frames."""
_STATUS_FRAMES = 4
"""Frames between two looks at the status, which is more work for the bench than samples."""
_AGAIN_S = 1.0
"""Time between two looks for a bench that has ended."""
_INTERVALS = 240
"""Intervals of a plot's window."""
_LOOKS = 20
"""Looks in an interval, of which it has the extremes."""
_MOST_PLOTS = 8
_LEAST_INTERVAL_NS = 1_000_000
_ONE_FRAME_S = 1.0
"""Time in which samples come for the one frame where no terminal is."""
_PATIENCE_S = 3.0
_WIDTH, _HEIGHT = 80, 24
"""Size of a frame where no terminal is."""
_ESCAPE_S = 0.05


def top(
    fields: Annotated[
        list[str] | None,
        typer.Argument(
            help="Fields to plot, as m1.position_deg s1.velocity_rpm. [default: the angle of each axis]",
            metavar="AXIS.FIELD",
            show_default=False,
        ),
    ] = None,
    seconds: Annotated[
        float, typer.Option("--seconds", help="Simulated time that the plots show.", min=0.5, max=86_400)
    ] = WINDOW_S,
    bench: BenchOptions = ANY_BENCH,
) -> None:
    """Show a bench as it goes on: health, lag, axes, bytes at ports, faults, the log's end, plots of fields.

    Keys: q ends, p holds the picture, up and down choose an axis to plot, Esc shows all again. It waits for a
    bench that ends, and goes on with its next run. Where the output is no terminal it prints one frame.

    Example: hil top m1.position_deg
    """
    wanted = [_field(text) for text in fields or ()]
    here = bench.meant()
    looker = _Looker(here, bench.runtime_dir, wanted, seconds)
    looker.begin()
    try:
        if sys.stdout.isatty() and sys.stdin.isatty():
            with suppress(KeyboardInterrupt):
                _live(looker)
        else:
            _one_frame(looker)
    finally:
        looker.end()


def _field(text: str) -> tuple[str, str]:
    axis, dot, name = text.rpartition(".")
    if not dot or not axis or not name:
        raise fail(f'hil: "{text}" is no field of an axis; write AXIS.FIELD, as in m1.position_deg', 2)
    return axis, name


class _Looker:
    """Asker of a bench, which fills a state; waits for a bench that has ended."""

    def __init__(
        self, here: "Here", runtime_dir: Path | None, wanted: list[tuple[str, str]], seconds: float
    ) -> None:
        self.state = TopState()
        self._here, self._runtime_dir, self._wanted = here, runtime_dir, wanted
        self._window_ns = round(seconds * NS)
        self._watches = list[tuple[int, list[tuple[Plot, int]]]]()
        self._revision = self._frames = 0
        self._counts: dict[str, tuple[int, int]] = {}
        self._lag = list[int]()
        self._status_ns = 0
        self._look_again_s = 0.0

    def _ask(self, verb: str, **arguments: Any) -> Any:
        from hil.net.control_client import ask

        return ask(self._here.socket, verb, timeout_s=_PATIENCE_S, **arguments)

    def begin(self) -> None:
        """Look first. Raises Exit: the bench has none of the fields."""
        from hil.cli.framework.exit_codes import exit_of
        from hil.net.control_client import ControlError

        try:
            self._look_at_status()
            self._choose()
        except ControlError as error:
            raise fail(f"hil: {error}", exit_of(error)) from None

    def end(self) -> None:
        """End what the bench samples."""
        from hil.net.control_client import ControlError

        with suppress(ControlError):
            for number, _ in self._watches:
                self._ask("unwatch", watch=number)
        self._watches = []

    def choose(self, step: int) -> None:
        """Choose the next axis or the one before, with plots of its main fields; 0: all axes again."""
        names = [name for name, shot in self.state.axes() if shot]
        if step == 0:
            self.state.chosen = None
        elif names:
            place = names.index(self.state.chosen) if self.state.chosen in names else -1 if step > 0 else 0
            self.state.chosen = names[(place + step) % len(names)]
        self.end()
        self._choose()

    def _choose(self) -> None:
        """Watch what is to be plotted."""
        chosen, axes = self.state.chosen, self.state.axes()
        wanted: dict[str, list[str]] = {}
        if chosen:
            wanted = {chosen: []}
        elif self._wanted:
            for axis, name in self._wanted:
                wanted.setdefault(axis, []).append(name)
        else:
            seen = [(name, shot) for name, shot in axes if "position_deg" in shot]
            wanted = {name: ["position_deg"] for name, _ in seen[:_MOST_PLOTS]}
        self.state.plots = []
        interval_ns = max(self._window_ns // _INTERVALS, _LEAST_INTERVAL_NS)
        for axis, names in wanted.items():
            opened = self._ask("watch", device=axis, signals=names, interval_ns=interval_ns, points=_LOOKS)
            signals = opened["signals"][:4] if not names else opened["signals"]
            plots = [
                (Plot(axis, name, _unit(name), self._window_ns, interval_ns=interval_ns), column)
                for column, name in enumerate(opened["signals"], 1)
                if name in signals
            ]
            self._watches.append((opened["watch"], plots))
            self.state.plots += [plot for plot, _ in plots]

    def look(self) -> None:
        """Look once more; where the bench does not answer, for it."""
        from hil.net.control_client import ControlError

        if self.state.waiting:
            self._look_for_it()
            return
        try:
            for number, plots in self._watches:
                answer = self._ask("samples", watch=number)
                self.state.now_ns = max(self.state.now_ns, int(answer.get("sim_ns", 0)))
                for plot, column in plots:
                    plot.add(answer["rows"], column)
            if self._frames % _STATUS_FRAMES == 0:
                self._look_at_status()
            self._frames += 1
        except ControlError as error:
            if error.code == "not_now":  # a watch that was forgotten, as after a stop of this command
                self._watches = []
                self._choose_again()
                return
            self._watches = []
            self.state.waiting = f"waits for {self._here.name}: {str(error).splitlines()[0]}"

    def _choose_again(self) -> None:
        from hil.net.control_client import ControlError

        try:
            self._choose()
        except ControlError as error:  # an axis that is not there any more
            self.state.chosen = None
            self.state.waiting = f"waits for {self._here.name}: {str(error).splitlines()[0]}"

    def _look_for_it(self) -> None:
        from hil.net.benches_here import find
        from hil.net.control_client import ControlError

        if time.monotonic() < self._look_again_s:
            return
        self._look_again_s = time.monotonic() + _AGAIN_S
        there = [
            each
            for each in find(self._runtime_dir, os.environ).running().benches
            if each.folder == self._here.folder
        ]
        if not there:
            return
        self._here = there[0]
        self._revision, self._counts, self._lag = 0, {}, []
        with suppress(ControlError):
            self.state.now_ns = 0
            self.state.events.clear()
            self._look_at_status()
            self._choose()
            self.state.waiting = ""

    def _look_at_status(self) -> None:
        from hil.cli.bench.views import duration, percentile

        state, before_ns = self.state, self._status_ns
        state.status = status = self._ask("status")
        state.now_ns = self._status_ns = status["sim_ns"]
        passed_s = (self._status_ns - before_ns) / NS
        rates, counts = {}, {}
        for row in status["devices"]:
            counts[row["device"]] = now = row["rx_bytes"], row["tx_bytes"]
            if row["address"] and passed_s > 0 and (was := self._counts.get(row["device"])):
                rates[row["device"]] = ((now[0] - was[0]) / passed_s, (now[1] - was[1]) / passed_s)
        self._counts, state.rates = counts, rates
        lag = [now - was for now, was in zip(status["lag"], self._lag or [0] * 99, strict=False)]
        if any(lag):
            state.lag_p99 = duration(percentile(lag, 0.99))
        self._lag = status["lag"]
        told = self._ask("events", after=self._revision)
        self._revision = told["revision"]
        for event in told["events"]:
            if state.events and state.events[-1]["number"] == event["number"]:
                state.events.pop()
            state.events.append(event)


def _unit(name: str) -> str:
    from hil.core.fields import described

    unit = described(name).unit
    return unit if unit != "-" else ""


def _one_frame(looker: _Looker) -> None:
    until_s = time.monotonic() + _ONE_FRAME_S
    while time.monotonic() < until_s and not interrupts.came:
        time.sleep(FRAME_S)
        looker.look()
    for line in looker.state.frame(_WIDTH, _HEIGHT)[:-1]:
        typer.echo("".join(text for text, _ in line).rstrip())


def _live(looker: _Looker) -> None:
    from rich.live import Live
    from rich.text import Text

    from hil.cli.framework.consoles import ShownConsole

    console = ShownConsole(markup=False)

    def frame() -> Text:
        width, height = console.size
        lines = [Text.assemble(*line) for line in looker.state.frame(width, height)]
        return Text("\n", no_wrap=True, overflow="crop").join(lines)

    with _keys(), Live(frame(), console=console, screen=True, auto_refresh=False) as live:
        while not interrupts.came:
            key = _pressed(FRAME_S)
            if key in ("q", "\x03", "\x04"):
                return
            if key in ("p", " "):
                looker.state.is_held = not looker.state.is_held
            elif key in ("up", "down", "esc") and not looker.state.waiting:
                looker.choose({"up": -1, "down": 1, "esc": 0}[key])
            looker.look()
            if not looker.state.is_held or key:
                live.update(frame(), refresh=True)


@contextmanager
def _keys() -> Iterator[None]:
    """Let keys come one by one, without an echo."""
    before = termios.tcgetattr(sys.stdin)
    try:
        tty.setcbreak(sys.stdin)
        yield
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)


def _pressed(most_s: float) -> str:
    """Wait for a key; empty: none came."""
    fd = sys.stdin.fileno()
    until_s = time.monotonic() + most_s
    if not select.select([fd], [], [], most_s)[0]:
        return ""
    typed = os.read(fd, 16).decode(errors="replace")
    if typed == "\x1b" and select.select([fd], [], [], _ESCAPE_S)[0]:
        typed += os.read(fd, 16).decode(errors="replace")
    key = {"\x1b[A": "up", "\x1b[B": "down", "\x1bOA": "up", "\x1bOB": "down", "k": "up", "j": "down"}.get(
        typed
    )
    if typed == "\x1b":
        key = "esc"
    if not key and not typed:  # the terminal has gone
        time.sleep(max(until_s - time.monotonic(), 0))
    return key or typed[:1] or "q"
