"""A planned program carried out over the line of its machine, with keys and a bar; and what it says at the
end."""

import asyncio
import os
import sys
import termios
import threading
import tty
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.interrupts import noted
from hil.cli.framework.shown_words import fixed
from hil.cli.gcode.gcode_files import PlannedFile
from hil.cli.lines.named_lines import LineOptions, on_lines, place_of

if TYPE_CHECKING:
    from hil.master import LiveMaster
    from hil.master.sans_io.line_run import LineRun
    from hil.master.sans_io.run_items import RunReport, RunSwitch
    from hil.toolpath.node_phrases import NodePhrases
    from hil.vocab.line_node import LineNodes
    from hil.vocab.path_planning import PathPlanner

KEYS_LOOK_S = 0.05
"""Time between two looks at keys, signals and the progress."""
FEED_STEP, FEED_LEAST, FEED_MOST = 0.1, 0.1, 2.0
KEYS = "p pauses and resumes, s stops, S stops at once, + and - change the {}"


class LineProgram:
    """Program on its way over a line: what keys and signals do to it."""

    def __init__(self, planned: PlannedFile, options: LineOptions, begin: dict[str, int]) -> None:
        self._planned, self._options, self._begin = planned, options, begin
        self._maker: NodePhrases | None = None
        self._line: LiveMaster | None = None
        self._run: LineRun | None = None
        self._goes_on = False
        self.was_ended = False
        """True if a key or a signal has ended it."""

    async def work(self, masters: Sequence["LiveMaster"], planner: "PathPlanner") -> "RunReport":
        """Carry it out. Ends the command before anything moves if a node does not answer."""
        from hil.master import path_run
        from hil.toolpath.node_phrases import NodePhrases

        (line,) = masters
        self._line = line
        machine, plan = self._planned.machine, self._planned.plan
        await self._all_answer(line)
        self._maker = maker = NodePhrases(machine, planner, plan.override)
        run = self._run = path_run(
            line.master, machine, maker.of(plan), begin=self._begin, switched=self._switched
        )
        with noted() as signals, keys() as pressed, _shown(self._planned) as show:
            task = asyncio.ensure_future(line.carry_out(run))
            while not task.done():
                self._signals(signals)
                for key in pressed():
                    self._key(key)
                if self._goes_on and run.state == "paused":
                    self._goes_on = False
                    line.resume_run()
                show(run, line.now_ns(), maker.override)
                await asyncio.wait([task], timeout=KEYS_LOOK_S)
        return await task

    async def _all_answer(self, line: "LiveMaster") -> None:
        nodes = {
            axis.node: axis.letter.upper() for axis in self._planned.machine.axes if axis.node is not None
        }
        there = {row.address for row in await line.scan(list(nodes), tries=3)}
        if silent := [f"{node} ({axis})" for node, axis in nodes.items() if node not in there]:
            raise fail(f"hil: no answer of node {', '.join(silent)}; nothing has moved", Exit.FAILED)

    def _switched(self, switch: "RunSwitch") -> None:
        name, _, state = switch.name.partition(" ")
        text = getattr(self._planned.machine.text.switches, name)
        if text is None or text.pin is None:
            return
        axis, _, pin = text.pin.rpartition(".")
        level = 1 - text.level if state == "off" else text.level
        self._options.bench.ask("pin", device=axis, pin=pin, level=level)

    def _signals(self, signals: list[int]) -> None:
        if signals:
            signals.clear()
            self._stop(is_at_once=self.was_ended)

    def _stop(self, *, is_at_once: bool) -> None:
        assert self._line
        self.was_ended = True
        self._line.stop_run("prejudice" if is_at_once else "grace")

    def _key(self, key: str) -> None:
        assert self._line
        assert self._run
        assert self._maker
        if key == "p":
            self._goes_on = False
            if self._run.state == "paused":
                self._line.resume_run()
            else:
                self._line.pause_run()
        elif key in "sS":
            self._stop(is_at_once=key == "S")
        elif key in "+-":
            feed = self._maker.override + (FEED_STEP if key == "+" else -FEED_STEP)
            self._maker.override = round(min(max(feed, FEED_LEAST), FEED_MOST), 3)
            if self._run.state == "running":
                self._goes_on = True  # it brakes along the path, and goes on at once with the other feed
                self._line.pause_run()


def carried_out(
    planned: PlannedFile, options: LineOptions, at: "dict[str, int]"
) -> tuple[dict[str, Any], Exit]:
    """Carry a program out over the line of its machine; answers the end for JSON, and the exit code."""
    machine = planned.machine
    if machine.text.line is None or not machine.has_nodes:
        raise fail(
            f"hil: the machine {machine.name} has no line: write line: and node: of each axis", Exit.MISTAKE
        )
    place = place_of(machine.text.line, options)
    planner = planner_of(place.nodes)
    program = LineProgram(planned, options, at)
    report = on_lines([place], 3, lambda masters: program.work(masters, planner))
    return _answer(planned, report), _exit_code(report, program.was_ended)


def planner_of(nodes: "LineNodes") -> "PathPlanner":
    """Planner of the kind of board that these nodes are; ends the command if it has none."""
    from hil.compose import find_catalogue

    for board in find_catalogue().boards.values():
        if board.line_nodes is nodes and board.paths is not None:
            return board.paths
    raise fail("hil: the nodes of this line plan no paths", Exit.MISTAKE)


def _exit_code(report: "RunReport", was_ended: bool) -> Exit:
    if not all(axis.is_known for axis in report.axes):
        return Exit.NOT_KNOWN
    if report.state == "ended":
        return Exit.DONE
    return Exit.INTERRUPTED if was_ended and report.state == "stopped" else Exit.RUN_FAILED


def _answer(planned: PlannedFile, report: "RunReport") -> dict[str, Any]:
    axes = {axis.letter: axis for axis in planned.machine.axes}
    rows = []
    for end in report.axes:
        axis = axes[end.axis]
        told = [None if p is None else p / axis.pulses_per_unit for p in (end.pulses, end.about_pulses)]
        rows.append({"axis": end.axis, "node": end.node, "unit": axis.unit, "why": end.why})
        rows[-1] |= {"position": told[0], "about": told[1]}
    return {
        "state": str(report.state),
        "why": report.why,
        "line": report.line,
        "took_s": round(report.took_s, 3),
        "packets": report.packets,
        "axes": rows,
    }


def end_text(file: str, answer: dict[str, Any]) -> str:
    """End of a program, for people."""
    why = f": {answer['why']}" if answer["why"] else ""
    lines = [f"{file}: {answer['state']} in line {answer['line']} after {answer['took_s']:.1f} s{why}"]
    for axis in answer["axes"]:
        name, unit = axis["axis"].upper(), axis["unit"]
        if axis["position"] is not None:
            lines.append(f"  {name} stands at {fixed(axis['position'], 3)} {unit}: {axis['why']}")
        else:
            about = f", about {fixed(axis['about'], 1)} {unit}" if axis["about"] is not None else ""
            lines.append(f"  {name}: where it stands is not known{about}: {axis['why']}")
    return "\n".join(lines)


@contextmanager
def keys() -> Iterator[Callable[[], str]]:
    """Keys that were pressed since the last call, on a terminal; elsewhere none."""
    if not sys.stdin.isatty():
        yield str
        return
    pressed: list[str] = []
    loop = asyncio.get_running_loop()
    number = sys.stdin.fileno()
    before = termios.tcgetattr(number)

    def take() -> str:
        keys = "".join(pressed)
        pressed.clear()
        return keys

    def read() -> None:
        with suppress(OSError):
            pressed.append(os.read(number, 100).decode("latin-1"))

    tty.setcbreak(number, termios.TCSADRAIN)
    loop.add_reader(number, read)
    try:
        yield take
    finally:
        loop.remove_reader(number)
        termios.tcsetattr(number, termios.TCSADRAIN, before)


@contextmanager
def _shown(planned: PlannedFile) -> Iterator[Callable[["LineRun", int, float], None]]:
    """Progress on the standard error: a bar on a terminal, else a line for each tenth."""
    total_s, lines = planned.plan.duration_s, planned.program.line_count
    if sys.stderr.isatty():
        with _bar(max(total_s, 1e-3)) as latest:

            def show_bar(run: "LineRun", now_ns: int, feed: float) -> None:
                now = run.progress(now_ns)
                latest[:] = [(f"{now.state}, line {now.line} of {lines}", now.done_s, f"{feed:.0%}")]

            yield show_bar
        return
    said: set[int] = set()

    def show_line(run: "LineRun", now_ns: int, feed: float) -> None:
        now = run.progress(now_ns)
        tenth = int(10 * now.done_s / total_s) if total_s else 0
        if tenth not in said and 0 < tenth < 10:
            said.add(tenth)
            typer.echo(f"{planned.plan.file}: line {now.line} of {lines}, {tenth * 10} %", err=True)

    yield show_line


@contextmanager
def _bar(total_s: float) -> Iterator[list[tuple[str, float, str]]]:
    """Show what the list has last, from a thread of its own: a terminal that takes nothing holds no motion
    up."""
    from rich.progress import BarColumn, Progress, TextColumn

    from hil.cli.framework.consoles import ShownConsole

    latest: list[tuple[str, float, str]] = []
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[feed]}"))
    is_over = threading.Event()

    def go_on() -> None:
        with Progress(*columns, console=ShownConsole(stderr=True), transient=True, auto_refresh=False) as bar:
            bar.console.print(KEYS.format("feed"), style="dim")
            task = bar.add_task("", total=total_s, feed="")
            while not is_over.wait(KEYS_LOOK_S):
                for what, done_s, feed in latest[-1:]:
                    bar.update(task, description=what, completed=done_s, feed=feed, refresh=True)

    thread = threading.Thread(target=go_on, daemon=True)
    thread.start()
    try:
        yield latest
    finally:
        is_over.set()
        thread.join(1.0)
