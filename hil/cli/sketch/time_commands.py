"""``hil sketch cycles`` and ``hil sketch profile``: where a program's time goes."""

import time
from collections.abc import Iterator
from statistics import median
from typing import Annotated, Any

import typer

from hil.cli.boards.time_given import seconds_of
from hil.cli.framework.ask import ANY_BENCH, BenchOptions, DeviceName, fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.progress_bars import bar
from hil.cli.framework.shown_view import Grid, ShownView, line
from hil.cli.sketch.program_files import Elf, need_symbols
from hil.sketch.function_names import Functions

For = Annotated[str, typer.Option("--for", metavar="TIME", help="Simulated time to look: 1s, 500ms.")]
_LOOK_S = 0.05
_STANDS_S = 5.0
"""Wall time without a cycle after which nobody waits any more."""
LOOP = "loop"
MOST_ROWS = 24


def cycles(
    device: DeviceName, length: For = "1s", elf: Elf = None, bench: BenchOptions = ANY_BENCH
) -> CommandAnswer:
    """Measure how many cycles of the processor a turn of loop() takes: least, median, most.

    From one beginning of loop() to the next, interrupts among it; of the latest 1,024 turns. Needs the
    program's symbols.

    Example: hil sketch cycles u1 --for 200ms
    """
    chip = bench.ask("processor", device=device)
    symbol = next((each for each in need_symbols(chip, elf) if each.name == LOOP), None)
    if symbol is None:
        raise fail(f"hil: the program of {device} has no loop(): was it built with --lto?", Exit.FAILED)
    counted = _counted(bench, chip, [], symbol.address, seconds_of(length, "--for"))
    laps, MHz = counted["laps"], chip["crystal_Hz"] / 1e6
    if not laps:
        raise fail(f"hil: no turn of loop() has ended within {length}: it is longer, or never returns", 1)
    figures = {"least": min(laps), "median": median(laps), "most": max(laps)}
    shown = [f"{name:6}  {value:>12,.0f} cycles  {value / MHz:>14,.2f} us" for name, value in figures.items()]
    answer = figures | {"turns": len(laps), "crystal_Hz": chip["crystal_Hz"]}
    return CommandAnswer(answer, "\n".join([f"{device}: loop(), {len(laps):,} turns", *shown]))


def profile(
    device: DeviceName, length: For = "1s", elf: Elf = None, bench: BenchOptions = ANY_BENCH
) -> CommandAnswer:
    """Show in which functions a program spends its time, with their calls.

    Each cycle is counted, without changing any: a function's own, without those that it calls. Needs the
    program's symbols.

    Example: hil sketch profile u1 --for 200ms
    """
    chip = bench.ask("processor", device=device)
    functions = Functions(need_symbols(chip, elf))
    starts = [0, *(start for start in functions.starts if start)]  # vectors and start-up are no function
    counted = _counted(bench, chip, starts, -1, seconds_of(length, "--for"))
    total = counted["cycles"]
    rows = [
        {"function": functions.name_at(start) or "start-up and vectors", "cycles": spent, "calls": calls}
        for start, (spent, calls) in zip(starts, counted["rows"], strict=False)
        if spent
    ]
    if (asleep := total - sum(row["cycles"] for row in rows)) > 0:
        rows.append({"function": "asleep", "cycles": asleep, "calls": 0})
    rows.sort(key=lambda row: -row["cycles"])
    answer = {"cycles": total, "crystal_Hz": chip["crystal_Hz"], "functions": rows}
    return CommandAnswer(answer, ShownView(*_profile(device, answer)).text())


def _profile(device: str, answer: dict[str, Any]) -> Iterator[Any]:
    total, kHz = answer["cycles"], answer["crystal_Hz"] / 1e3
    yield line(f"{device}: {total:,} cycles, {total / kHz:,.1f} ms")
    columns = ("%", "ms", "calls", "cycles a call", "function")
    rows = answer["functions"]
    yield Grid(columns, ("function",), [_profile_row(row, total, kHz) for row in rows[:MOST_ROWS]])
    if len(rows) > MOST_ROWS:
        yield line(f"and {len(rows) - MOST_ROWS} more; --json has all")


def _profile_row(row: dict[str, Any], total: int, kHz: float) -> tuple[str, ...]:
    spent, calls = row["cycles"], row["calls"]
    a_call = f"{spent / calls:,.1f}" if calls else ""
    share, time_ms = f"{100 * spent / total:.2f}", f"{spent / kHz:,.3f}"
    return share, time_ms, f"{calls:,}" if calls else "", a_call, row["function"]


def _counted(
    bench: BenchOptions, chip: dict[str, Any], starts: list[int], lap_at: int, length_s: float
) -> dict[str, Any]:
    """Count for a simulated time, and end it."""
    device, wanted = chip["device"], round(length_s * chip["crystal_Hz"])
    bench.ask("count", device=device, starts=starts, lap_at=lap_at)
    try:
        counted: dict[str, Any] = {"cycles": -1}
        moved_s = time.monotonic()
        with bar(f"{device} is counted", "s simulated") as shown:
            while True:
                before, counted = counted["cycles"], bench.ask("counted", device=device)
                if counted["cycles"] >= wanted:
                    return counted
                shown.tell(counted["cycles"] / chip["crystal_Hz"], length_s)
                if counted["cycles"] != before:
                    moved_s = time.monotonic()
                elif time.monotonic() - moved_s > _STANDS_S:
                    why = f"hil: {device} stands: is the bench paused, or the program halted by GDB?"
                    raise fail(why, Exit.FAILED)
                time.sleep(_LOOK_S)
    finally:
        bench.ask("count", device=device, starts=[])
