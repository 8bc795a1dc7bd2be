"""Samples of an axis of a running bench, for commands that draw them or wait for one."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

import typer

from hil.cli.framework.ask import BenchOptions, fail
from hil.cli.framework.paused_note import told_if_paused

_ROWS_LOOK_S = 0.1


@contextmanager
def watching(
    bench: BenchOptions, device: str, signals: tuple[str, ...], interval_ns: int, points: int = 1
) -> Iterator[tuple[tuple[str, ...], Iterator[list[tuple[float, ...]]]]]:
    """Watch signals: their names, and pieces of samples forever; the watch ends with the block. ``points``
    above 1: of so many looks in each interval two samples have the extremes."""
    opened = bench.ask("watch", device=device, signals=signals, interval_ns=interval_ns, points=points)

    def pieces() -> Iterator[list[tuple[float, ...]]]:
        told = 0
        while True:
            answer = bench.ask("samples", watch=opened["watch"])
            if answer["lost"] > told:
                typer.echo(
                    f"{answer['lost'] - told} samples were lost: the machine or this command is too slow",
                    err=True,
                )
                told = answer["lost"]
            if any(len(row) != 1 + len(opened["signals"]) for row in answer["rows"]):
                raise fail("hil: the bench answers rows that are no samples of what is watched")
            yield [tuple(row) for row in answer["rows"]]
            if not answer["rows"]:
                time.sleep(_ROWS_LOOK_S)

    try:
        with told_if_paused(bench.meant().socket):
            yield tuple(opened["signals"]), pieces()
    finally:
        bench.ask("unwatch", watch=opened["watch"])
