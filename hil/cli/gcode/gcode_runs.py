"""A program carried out by runs of a bench, with keys and a bar; and what it says at the end."""

import asyncio
import sys
from typing import TYPE_CHECKING, Any

import typer

from hil.cli.framework.ask import BenchOptions, fail
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.interrupts import noted
from hil.cli.gcode.gcode_line import KEYS, keys
from hil.cli.runs.run_command import run_named
from hil.cli.runs.run_reports import EXIT_OF, is_under_way, run_report, shown

if TYPE_CHECKING:
    from hil.cli.gcode.gcode_files import PlannedFile

PROGRESS_LOOK_S = 0.1
PLAN_S = 120.0
"""Maximum wait for the bench's plan of a program."""
PACE_STEP, LEAST_PACE = 0.1, 0.1


class RunsProgram:
    """Program on its way through the runs of a bench: what keys and signals do to it."""

    def __init__(self, bench: BenchOptions, *, is_quiet: bool) -> None:
        self._bench = bench
        self._is_quiet = is_quiet
        self._pace, self._is_paused = 1.0, False
        self.was_ended = False
        """True if a key or a signal has ended it."""

    def ask(self, verb: str, **given: Any) -> Any:
        return self._bench.ask(verb, **given)

    async def carry_out(self, parts: list[dict[str, Any]]) -> list[dict[str, Any]]:
        """Carry parts out one after the other; answers the reports of their runs."""
        reports: list[dict[str, Any]] = []
        with noted() as signals, keys() as pressed:
            for part in parts:
                report = await self._part(part, signals, pressed)
                reports.append(report)
                if report["state"] != "done":
                    break
                if part["pause_line"] is not None and not await self._go_on(part, signals, pressed):
                    break
        return reports

    async def _part(self, part: dict[str, Any], signals: list[int], pressed: Any) -> dict[str, Any]:
        progress = self.ask("run", timeout_s=PLAN_S, text=part["text"], file="drawing", fresh=True)
        if "problems" in progress:
            raise fail(progress["problems"], Exit.FAILED)
        name = progress["run"]
        with shown(is_quiet=self._is_quiet) as show:
            while is_under_way(progress):
                show(progress)
                self._signals(name, signals)
                for key in pressed():
                    self._key(name, key)
                await asyncio.sleep(PROGRESS_LOOK_S)
                progress = run_named(self._bench, name)
        return dict(progress)

    async def _go_on(self, part: dict[str, Any], signals: list[int], pressed: Any) -> bool:
        """Wait at a pause of the program; False: it was ended there."""
        what = f"the program waits at line {part['pause_line']}"
        if not sys.stdin.isatty():
            typer.echo(f"hil: {what}, and goes on: there is no terminal", err=True)
            return True
        typer.echo(f"hil: {what}; p goes on, s ends it", err=True)
        while True:
            typed = pressed()
            if signals or "s" in typed or "S" in typed:
                self.was_ended = True
                return False
            if "p" in typed or "\n" in typed:
                return True
            await asyncio.sleep(PROGRESS_LOOK_S)

    def _signals(self, name: str, signals: list[int]) -> None:
        if signals:
            signals.clear()
            self._stop(name, is_at_once=self.was_ended)

    def _stop(self, name: str, *, is_at_once: bool) -> None:
        self.was_ended = True
        self.ask("cancel_run", name=name, how="prejudice" if is_at_once else "grace")

    def _key(self, name: str, key: str) -> None:
        if key in "sS":
            self._stop(name, is_at_once=key == "S")
            return
        if key == "p":
            self._is_paused = not self._is_paused
        elif key in "+-":
            pace = self._pace + (PACE_STEP if key == "+" else -PACE_STEP)
            self._pace = round(min(max(pace, LEAST_PACE), 1.0), 3)
        else:
            return
        self.ask("pace_run", name=name, pace=0.0 if self._is_paused else self._pace)


def carried_by_runs(
    planned: "PlannedFile",
    texts: tuple[str, str],
    files: tuple[str, str],
    feed_percent: float,
    program: RunsProgram,
) -> tuple[dict[str, Any], Exit]:
    """Carry a program out by runs of a bench, from where its axes stand; answers the end for JSON, and the
    exit code. ``texts`` and ``files``: of the program and the machine."""
    given = {"text": texts[0], "machine": texts[1], "file": files[0], "machine_file": files[1]}
    drawing = program.ask("drawing", timeout_s=PLAN_S, **given, feed_percent=feed_percent)
    if drawing["problems"]:
        raise fail("\n".join(drawing["problems"]), Exit.MISTAKE)
    if sys.stderr.isatty():
        typer.echo(KEYS.format("pace"), err=True)
    reports = asyncio.run(program.carry_out(drawing["runs"]))
    last = reports[-1] if reports else None
    code = EXIT_OF.get(last["state"], Exit.DONE) if last else Exit.DONE
    if program.was_ended and code in (Exit.RUN_CANCELLED, Exit.DONE):
        code = Exit.INTERRUPTED
    return {"path": drawing["path"], "axes": drawing["axes"], "runs": reports}, code


def runs_text(end: dict[str, Any]) -> str:
    """End of a program, for people."""
    return "\n".join(run_report(report) for report in end["runs"])
