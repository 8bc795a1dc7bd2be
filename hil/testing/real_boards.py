"""Real boards of a configuration, for tests that were written for a bench in memory."""

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hil.config import BenchConfig
from hil.testing.config_reading import read_config
from hil.testing.given import GivenConfig
from hil.testing.live_desk import LiveError
from hil.testing.served_bench import ServedBench
from hil.testing.serving import live
from hil.testing.unsupported import UnsupportedHere
from hil.vocab.address import Address, owner_of

FOUND_S = 3.0
"""Maximum time until a real board's port is open: the daemon tries each second."""
_LOOK_S = 0.05
KIND = "real"


class BoardsAbsent(LiveError):
    """Error of real boards that are not where the configuration says: ``str(error)`` names each with the
    place at which it was looked for, and why it cannot be reached."""


class RealBoards:
    """Configuration whose devices have ``at:``, all or some, from a file.

    Raises:
        ConfigError: with every problem of the configuration, or the file cannot be read.
        ValueError: no device has ``at:``.
    """

    def __init__(self, file: Path | str) -> None:
        self.file = Path(file)
        self.config, _ = read_config(self.file)
        if not self.config.real:
            raise ValueError(
                f"{file}: no device has at:, the place of a real board; --hil=live has twins alone"
            )
        self._is_served = False
        self._absent: dict[str, str] = {}
        """Boards that were not found, with the reasons: they are not looked for again."""

    @contextmanager
    def serve(self, given: GivenConfig | None = None, **options: Any) -> Iterator[ServedBench]:
        """Serve these boards for a block, in place of the bench that a test was written for.

        ``given``: the test's own configuration; ``options``: as ``hil.testing.live``.

        Raises:
            BoardsAbsent: boards that the test needs are not there.
            UnsupportedHere: the test needs devices or faults that there are not here.
            ConfigError: the test's configuration has problems.
            LiveError: the bench does not start.
        """
        __tracebackhide__ = True
        wanted = None if given is None else read_config(given)[0]
        if wanted:
            self._check(wanted)
        if self._is_served:
            raise UnsupportedHere(KIND, "real boards are in one bench at a time, and this test makes two")
        needed = [name for name in self.config.real if wanted is None or name in wanted.devices]
        self._refuse_absent(needed)
        with live(self.file, **options) as bench:
            self._find(bench, needed)
            if wanted:
                names = _names(wanted)
                bench.absent = lambda name: f"{self.file.name} has no {name}" if name in names else ""
                for fault in wanted.faults:
                    bench.fault(fault.fault, fault.target, **(fault.model_extra or {}))
            self._is_served = True
            try:
                yield bench
            finally:
                self._is_served = False

    def _check(self, wanted: BenchConfig) -> None:
        """Check that there are the devices that a test needs. Raises UnsupportedHere: there are not."""
        __tracebackhide__ = True
        here = self.config.devices
        for name, device in wanted.devices.items():
            if name not in here:
                raise UnsupportedHere(
                    KIND, f"{self.file.name} has no device {name}; it has {', '.join(here)}"
                )
            if here[name].profile != device.profile:
                why = f"{name} is a {here[name].profile} in {self.file.name}, not a {device.profile}"
                raise UnsupportedHere(KIND, why)

    def _find(self, bench: ServedBench, needed: list[str]) -> None:
        __tracebackhide__ = True
        until_s = time.monotonic() + FOUND_S
        while (away := _of(bench.away(), needed)) and time.monotonic() < until_s:
            time.sleep(_LOOK_S)
        self._absent |= away
        self._refuse_absent(needed)

    def _refuse_absent(self, needed: list[str]) -> None:
        __tracebackhide__ = True
        if absent := _of(self._absent, needed):
            where = "\n".join(f"{name} is not there: {why}" for name, why in absent.items())
            raise BoardsAbsent(f"{self.file}: {where}")


def _of(reasons: Mapping[str, str], needed: list[str]) -> dict[str, str]:
    return {name: why for name, why in reasons.items() if name in needed}


def _names(config: BenchConfig) -> set[str]:
    """Addresses of wires and taps that a test may name, and its bridges."""
    taps, wires = config.tap_ports(), config.bus_wires()
    stations = {str(Address(name, "network")) for name in config.devices}
    return {*taps, *wires, *stations, *config.bridges, *(owner_of(tap) for tap in taps)}
