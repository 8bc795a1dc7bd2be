"""Health of a bench: problems and remedies, the one answer for ``hil status``, bridges and metrics."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hil.host.process import read_process
from hil.host.real_time import Grant
from hil.live.memory_commits import Commits
from hil.live.places import Places
from hil.live.vitals import Vitals
from hil.operations.wire_reports import wire_problems
from hil.sim.bench import BenchRuntime
from hil.vocab.bridge_protocol import BenchDoor, Bridge
from hil.vocab.device import Device
from hil.vocab.monitoring import FAILED, LATE, LATE_KINDS, OK, HealthProblem
from hil.vocab.wire import WireInfo

MISSED_SHARE = 0.01
LOOP_LATE_NS = 1_000_000_000
"""Event loop lateness within a minute that makes a bench late: a usual time-out of programs that wait for an
answer. On a busy computer less is ordinary."""
ASKED_LOOP_LATE_NS = 250_000_000
"""The same where real time was asked for. The longest work of a healthy bench, a query of the look-up table,
holds the loop for 20 ms."""
KINDS = {
    "real_time": "real time was asked for, and priority, CPU or locked memory was refused, or another bench"
    " has the CPU of `cpu:`, too",
    "wakes": f"real time was asked for, and more than {MISSED_SHARE:.0%} of the core's wakes of the last"
    " minute came too late",
    "loop": f"answers were held up for more than {LOOP_LATE_NS // 1_000_000} ms in the last minute, or for"
    f" more than {ASKED_LOOP_LATE_NS // 1_000_000} ms where real time was asked for",
    "descriptors": "nine of ten file descriptors that the process may have are in use",
    "device": "a device's firmware has stopped",
    "flash": "a device's memory could not be written",
    "port": "a port cannot go on, or a real board or drive is away",
    "segment": "stations of a segment share an address, or have several speeds",
    "name": "another bench has the name of this one",
}
"""Kinds of problems, and the meaning of each; those that wires alone have come behind them."""


def problem_kinds(wires: Mapping[str, WireInfo]) -> dict[str, str]:
    """Kinds of problems of a bench that can have such wires, and the meaning of each."""
    return KINDS | {kind: about for told in wires.values() for kind, about in told.problems}


@dataclass(frozen=True)
class Health:
    """Health of a bench. ``state_dir``: folder of its memories; ``is_service``: it runs as a service."""

    sim: BenchRuntime
    devices: Mapping[str, Device]
    places: Places
    commits: Commits
    vitals: Vitals
    grant: Grant
    state_dir: Path
    is_service: bool
    bridges: Mapping[str, Bridge]

    def problems(self) -> list[HealthProblem]:
        """Present problems, the bench's own first."""
        return [problem for problem in self.pieces() if problem]

    def pieces(self) -> Iterator[HealthProblem | None]:
        """Present problems, and None where others may have their turn."""
        yield from self._of_bench()
        yield from self._of_devices()
        yield from wire_problems(self.sim, self.places)

    def as_dict(self, found: Sequence[HealthProblem]) -> dict[str, Any]:
        """Health for JSON: ``state`` as in ``STATES``, ``late_ms``, the longest time in the last minute that
        answers were held up, and ``problems`` that say why."""
        late_ms = round(self.vitals.loop_worst_ns / 1e6, 1)
        return {
            "state": state_of(found),
            "late_ms": late_ms,
            "problems": [vars(problem) for problem in found],
        }

    def _of_bench(self) -> Iterator[HealthProblem]:
        yield from lateness(self.grant, self.vitals.missed_share, self.vitals.loop_worst_ns)
        for bridge in self.bridges.values():
            if isinstance(bridge, BenchDoor) and (clash := bridge.name_clash()):
                yield HealthProblem("name", "", clash.what, clash.remedy)
        process = read_process()
        if process.open_fds * 10 > process.max_fds * 9:
            what = f"{process.open_fds} of {process.max_fds} file descriptors are in use"
            remedy = f"restart it with LimitNOFILE={4 * process.max_fds}"
            yield HealthProblem("descriptors", "", what, remedy)

    def _of_devices(self) -> Iterator[HealthProblem | None]:
        found = list[HealthProblem]()
        for name in list(self.devices):
            if device := self.devices.get(name):  # a reload may have removed it meanwhile
                found += device.problems(self.is_service)
                yield None
        yield from (each for each in found if each.kind == "device")
        for name, why in self.commits.failures.items():
            remedy = f"it keeps its old content; mend {self.state_dir} and let the board store again"
            yield HealthProblem("flash", name, f"its flash was not written: {why}", remedy)
        yield from (each for each in found if each.kind != "device")
        for tap in (tap for wire in self.sim.wires for tap in self.places.of(wire)):
            if tap.failure:
                yield HealthProblem("port", tap.label, tap.failure, "restart the bench")


def lateness(grant: Grant, missed_share: float, loop_worst_ns: int) -> Iterator[HealthProblem]:
    """Make problems of time. ``missed_share``: missed wakes of the last minute, 0 to 1; ``loop_worst_ns``:
    maximum lateness of the event loop in it."""
    if grant.is_asked:
        for missing, remedy in grant.missing.items():
            yield HealthProblem("real_time", "", f"no {missing}", remedy)
        if grant.claim and grant.claim.is_configured and (shares := grant.shares()):
            yield HealthProblem("real_time", "", shares, "give one of them another `cpu:`, or none")
        if missed_share > MISSED_SHARE:
            what = f"{missed_share:.1%} of the wakes of the last minute came too late"
            again = "`hil doctor` looks for the cause; `hil docs real-time` says what helps"
            yield HealthProblem("wakes", "", what, again)
    if loop_worst_ns > (ASKED_LOOP_LATE_NS if grant.is_asked else LOOP_LATE_NS):
        what = f"answers were held up for {loop_worst_ns / 1e6:.0f} ms in the last minute"
        yield HealthProblem("loop", "", what, "take load off this computer, or devices off this bench")


def state_of(problems: Sequence[HealthProblem]) -> str:
    """State of a bench that has these problems."""
    if any(problem.kind not in LATE_KINDS for problem in problems):
        return FAILED
    return LATE if problems else OK
