"""Report of ``hil serve`` for programs: one JSON object when the boards answer, in a file or as its output.

Real boards and drives are not waited for: they may be away.
"""

import asyncio
import json
import logging
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

from hil import __version__
from hil.daemon import Serving
from hil.host.journal import STDOUT
from hil.host.log_writer import LogWriter
from hil.host.new_file import write_file
from hil.live.live_bench import LiveBench
from hil.live.refusals import StartError
from hil.vocab.address import CONTROL_SOCKET, address_of

log = logging.getLogger("hil")

SETTLE_NS = 50_000_000
"""Simulated time after a board's start in which the last of its boot text leaves."""
BOOT_LOOK_S = 0.002
LONGEST_LOOK_S = 0.5


class Telling:
    """Tells once, when all twins answer or have stopped. ``runtime``: the bench's folder; ``file``: it comes
    whole, and goes with the bench; ``writer``: for the standard output, or None.

    Raises:
        StartError: the file could not be written.
    """

    def __init__(self, runtime: Path, file: Path | None, writer: LogWriter | None) -> None:
        self._control, self._file, self._writer = runtime / CONTROL_SOCKET, file, writer
        self._task: asyncio.Task[None] | None = None
        if file is not None:
            try:
                self._remove_file()  # one that a killed bench left behind
                write_file(file.with_name(f"{file.name}.begun"), b"")
                file.with_name(f"{file.name}.begun").unlink()
            except OSError as error:
                raise StartError(f"--ready-file {file}: {error.strerror}") from None

    def begin(self, serving: Serving) -> None:
        """Begin to wait, in the daemon's loop."""
        if self._file or self._writer:
            self._task = asyncio.get_running_loop().create_task(self._when_ready(serving.live))

    def end(self) -> None:
        """Take the file away: nobody answers any more."""
        with suppress(OSError):
            self._remove_file()

    def _remove_file(self) -> None:
        if self._file and self._file.is_file():  # a pipe stays
            self._file.unlink()

    async def _when_ready(self, live: LiveBench) -> None:
        while (left_ns := _left_ns(live)) > 0:
            left_s = left_ns / 1e9 / live.configured.config.speed
            await asyncio.sleep(min(max(left_s, BOOT_LOOK_S), LONGEST_LOOK_S))
        text = json.dumps(_ready(live, self._control)) + "\n"
        if self._writer:
            self._writer.write(STDOUT, text)
        if self._file:
            try:
                write_file(self._file, text.encode())
            except OSError as error:
                log.error("--ready-file %s: %s", self._file, error.strerror)


def _ready(live: LiveBench, control: Path) -> dict[str, Any]:
    """The object, as ``ready_keys.READY`` says."""
    config = live.configured.config
    return {
        "bench": config.bench,
        "pid": os.getpid(),
        "version": __version__,
        "control": str(control),
        "speed": config.speed,
        "sim_ns": live.sim.now_ns,
        "ports": dict(live.places.addresses()),
        "bauds": _bauds(live),
        "bridges": {kind: list(each.status()["listen"]) for kind, each in live.bridges.items()},
        "failed": {name: each.failed for name, each in live.sim.devices.items() if each.failed},
    }


def _bauds(live: LiveBench) -> dict[str, int | None]:
    config, profiles = live.configured.config, live.configured.catalogue.profiles
    bauds: dict[str, int | None] = {}
    for label in live.places:
        name, uart = address_of(label)
        if (device := config.devices.get(name)) is None:
            line = live.sim.segments.get(name)
            bauds[label] = line.baud if line else None
        elif device.at is None:
            profile = profiles[device.profile]
            bauds[label] = device.uart_bauds(profile)[uart or profile.first_uart]
        else:
            bauds[label] = device.baud
    return bauds


def _left_ns(live: LiveBench) -> int:
    """Simulated time until the last twin answers; not above 0: all do. A board's own clock counts: on a busy
    computer it is behind the bench's."""
    left_ns = 0
    for name, device in live.sim.devices.items():
        if not device.failed:
            profile = live.configured.catalogue.profiles[live.configured.config.devices[name].profile]
            at_ns = device.axes[""].published().at_ns if device.axes else live.sim.now_ns
            left_ns = max(left_ns, round(profile.ready_after_s * 1e9) + SETTLE_NS - at_ns)
    return left_ns
