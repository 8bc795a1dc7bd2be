"""Capture of a bench in memory, for a part of a test."""

from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hil import __version__
from hil.sim.bench import BenchRuntime
from hil.testing.failures.bench_replay import HeardRecord, listen, wire_records
from hil.testing.failures.bench_traffic import as_pcapng, port_records
from hil.testing.kept_inputs import KeptInputs


class BenchCapture:
    """Capture of all ports and wires for a ``with`` block, written at its end."""

    def __init__(self, kept: KeptInputs, runtime: BenchRuntime, file: Path) -> None:
        self._kept, self._runtime, self._file = kept, runtime, file
        self._since = 0
        self._heard: dict[str, deque[HeardRecord]] = {}
        self._watchers: dict[str, Callable[[Any], None]] = {}

    def __enter__(self) -> "BenchCapture":
        __tracebackhide__ = True
        if not self._file.parent.is_dir():
            raise FileNotFoundError(f"{self._file}: there is no folder {self._file.parent}; make it first")
        self._file.touch()  # a path that cannot be written is told at once
        self._since = len(self._kept.records)
        self._heard = {name: deque() for name in self._runtime.wires}
        self._watchers = {name: listen(wire, self._heard[name]) for name, wire in self._runtime.wires.items()}
        return self

    def __exit__(self, *_: object) -> None:
        for name, watcher in self._watchers.items():
            self._runtime.wires[name].watchers.remove(watcher)
        records = [
            *port_records(self._kept, self._runtime, self._since),
            *wire_records(self._runtime.wires, self._heard),
        ]
        self._file.write_bytes(as_pcapng(records, f"hil {__version__}"))
