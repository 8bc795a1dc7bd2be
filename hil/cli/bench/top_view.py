"""Frame of ``hil top`` as lines of text: a bench's head, its axes, plots of fields, its faults and log."""

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

from hil.cli.bench.braille_plot import COLUMNS, Span, drawn
from hil.cli.framework.shown_words import fixed
from hil.net.axis_states import shown_state
from hil.vocab.shown_text import printable

NS = 1_000_000_000
KEYS = "q ends  p holds  up, down: an axis  Esc: all"
_LABEL = 10
"""Characters of the values beside a plot."""
_LEAST_PLOT = 3
"""Lines of a plot, its title among them."""
_MOST_LOG = 3
_HEALTH = {"ok": "green", "late": "yellow"}
_FLAT = 1e-9

Part = tuple[str, str]
"""Text with its style."""
Frame = list[list[Part]]


@dataclass
class Plot:
    """Plot of a field over the last ``window_ns`` of simulated time."""

    axis: str
    name: str
    unit: str
    window_ns: int
    spans: deque[tuple[int, float, float]] = field(default_factory=deque)
    """Interval, smallest and largest value, the oldest first."""
    interval_ns: int = 1

    def add(self, rows: Sequence[Sequence[float]], column: int) -> None:
        """Add samples: rows of a time and values."""
        for row in rows:
            number, value = int(row[0]) // self.interval_ns, row[column]
            if value != value:  # not told
                continue
            if self.spans and self.spans[-1][0] == number:
                _, low, high = self.spans[-1]
                self.spans[-1] = number, min(low, value), max(high, value)
            else:
                self.spans.append((number, value, value))
        while self.spans and self.spans[0][0] < self.spans[-1][0] - self.window_ns // self.interval_ns:
            self.spans.popleft()

    def columns(self, count: int, now_ns: int) -> list[Span]:
        """Spans of so many columns up to now, the oldest first."""
        made: list[Span] = [None] * count
        first_ns = now_ns - self.window_ns
        for number, low, high in self.spans:
            place = (number * self.interval_ns - first_ns) * count // self.window_ns
            if 0 <= place < count:
                there = made[place]
                made[place] = (min(low, there[0]), max(high, there[1])) if there else (low, high)
        return _held(made)

    def lines(self, width: int, height: int, now_ns: int) -> Iterator[list[Part]]:
        """Title with the value now and the range, then the plot."""
        last = self.spans[-1][2] if self.spans else None
        low = min((each[1] for each in self.spans), default=0.0)
        high = max((each[2] for each in self.spans), default=0.0)
        if high - low <= _FLAT * max(abs(low), abs(high), 1.0):
            low, high = low - 1.0, high + 1.0
        unit = f" {self.unit}" if self.unit else ""
        said = f"{_number(last)}{unit}, {_number(low)} to {_number(high)}" if self.spans else "no value"
        yield [(f"{self.axis}.{self.name}", "bold"), (f"  {said}", "")]
        room = max(width - _LABEL - 1, 4)
        dots = drawn(self.columns(room * COLUMNS, now_ns), height - 1, low, high)
        for number, text in enumerate(dots):
            label = _number(high) if number == 0 else _number(low) if number == len(dots) - 1 else ""
            yield [(f"{label:>{_LABEL}} ", "dim"), (text, "cyan")]


def _held(spans: list[Span]) -> list[Span]:
    """Spans without the gaps between two samples of a slow watch."""
    known = [number for number, span in enumerate(spans) if span]
    for a, b in pairwise(known):
        if b - a <= COLUMNS * 2:
            last = spans[a]
            for number in range(a + 1, b):
                spans[number] = (last[1], last[1]) if last else None
    return spans


def _number(value: float | None) -> str:
    if value is None:
        return "-"
    return fixed(value, 1) if abs(value) >= 1000 else f"{value + 0.0:.4g}"


@dataclass
class TopState:
    """All that a frame shows. ``rates``: bytes a second in and out, by device; ``lag_p99``: of the last
    second, as text; ``waiting``: why there is no bench; ``chosen``: axis."""

    status: Mapping[str, Any] = field(default_factory=dict)
    rates: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    lag_p99: str = "-"
    events: deque[Mapping[str, Any]] = field(default_factory=lambda: deque(maxlen=50))
    plots: list[Plot] = field(default_factory=list)
    now_ns: int = 0
    waiting: str = ""
    is_held: bool = False
    chosen: str | None = None

    def axes(self) -> list[tuple[str, Mapping[str, Any]]]:
        """Axes with their snapshots; a device without one has an empty one."""
        found = list[tuple[str, Mapping[str, Any]]]()
        for row in self.status.get("devices", ()):
            found.append((row["device"], row["snapshot"] or {}))
            found += row["snapshots"].items()
        return found

    def frame(self, width: int, height: int) -> Frame:
        """Make a frame of at most so many characters and lines."""
        head, log = list(self._head()), list(self._log())
        table = list(self._table(max(height // 3, 3), width))
        faults = list(self._faults())[: max(height // 8, 1)]
        room = height - len(head) - len(table) - len(faults) - 1
        if room - len(log) < _LEAST_PLOT + 1:
            log = log[-1:] if room > _LEAST_PLOT + 1 else []
        room -= len(log)
        plots = list(self._plots(width, room))
        filler = [[("", "")]] * max(room - len(plots), 0)
        keys = [[(KEYS if not self.is_held else "held; p goes on", "dim")]]
        lines = [*head, *table, *plots, *filler, *faults, *log]
        return [_cut(line, width) for line in [*lines[: height - 1], *keys]]

    def _head(self) -> Iterator[list[Part]]:
        status = self.status
        if self.waiting:
            yield [(self.waiting, "yellow")]
        if not status:
            return
        pace = "paused" if status.get("is_paused") else f"speed {status['speed']:g}"
        health = status["health"]
        yield [
            (f"bench {status['bench']}", "bold"),
            (f"  {self.now_ns / NS:.1f} s  {pace}  health: ", ""),
            (health["state"], _HEALTH.get(health["state"], "bold red")),
            (f"  lag p99 < {self.lag_p99}", ""),
        ]
        for problem in health["problems"][:2]:
            about = f"{problem['about']}: " if problem["about"] else ""
            yield [(printable(f"  {about}{problem['what']}"), "red")]

    def _table(self, most: int, width: int) -> Iterator[list[Part]]:
        axes = self.axes()
        if not axes:
            return
        names = [name for name, _ in axes]
        longest = min(max(map(len, [*names, "axis"])), max(width - 52, 8))
        yield [
            (f"  {'axis':{longest}} {'deg':>10} {'rpm':>9} {'state':>8} {'in B/s':>8} {'out B/s':>8}", "bold")
        ]
        place = names.index(self.chosen) if self.chosen in names else 0
        first = max(0, min(place - most // 2, len(axes) - most + 1))
        shown = axes[first : first + most - 1] if len(axes) > most - 1 else axes
        for name, shot in shown:
            state = shown_state(shot) if shot else None
            angle = state.shaft_deg(shot) if state else None
            angle = state.board_deg(shot) if state and angle is None else angle
            rates = [f"{rate:.0f}" for rate in self.rates[name]] if name in self.rates else ["", ""]
            is_chosen = name == self.chosen
            yield [
                (
                    f"{'> ' if is_chosen else '  '}{name:{longest}} {fixed(angle, 2):>10}"
                    f" {fixed(shot.get('velocity_rpm'), 1):>9} {state.word(shot) if state else '-':>8}"
                    f" {rates[0]:>8} {rates[1]:>8}",
                    "reverse" if is_chosen else "",
                )
            ]
        if more := len(axes) - len(shown):
            yield [(f"  and {more} more axes", "dim")]

    def _plots(self, width: int, room: int) -> Iterator[list[Part]]:
        if not self.plots or room < _LEAST_PLOT + 1:
            return
        count = min(len(self.plots), max((room - 1) // _LEAST_PLOT, 1))
        each, rest = divmod(room - 1, count)
        for number, plot in enumerate(self.plots[:count]):
            yield from plot.lines(width, each + (number < rest), self.now_ns)
        seconds = self.plots[0].window_ns / NS
        left, right = f"{-seconds:g} s", "now"
        more = f"  {len(self.plots) - count} plots have no room" if len(self.plots) > count else ""
        gap = max(width - _LABEL - 1 - len(left) - len(right) - len(more), 1)
        yield [(f"{'':{_LABEL}} {left}{more}{'':{gap}}{right}", "dim")]

    def _faults(self) -> Iterator[list[Part]]:
        for row in self.status.get("faults", ()):
            yield [(printable(f"fault {row['number']}: {row['kind']} on {row['target']}"), "red")]

    def _log(self) -> Iterator[list[Part]]:
        for event in list(self.events)[-_MOST_LOG:]:
            of = f"{event['of']}: " if event["of"] else ""
            yield [(f"{event['at_ns'] / NS:10.3f} ", "dim"), (printable(f"{of}{event['text']}"), "")]


def _cut(line: list[Part], width: int) -> list[Part]:
    cut, left = list[Part](), width
    for text, style in line:
        cut.append((text[:left], style))
        left -= len(text[:left])
    return cut
