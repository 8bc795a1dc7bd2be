"""Runs an input log again on the virtual clock, and compares with what the devices sent then."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

from hil.compose.bundles import Trusts, trusts_nobody
from hil.compose.log_course import LogCourse, MemoryOptions
from hil.compose.log_lines import read_log
from hil.sim.bench import BenchRuntime
from hil.sim.firmware_guard import LoggedStops
from hil.sim.input_log import InputLog, Sent, sent_now
from hil.sim.log_reading import read_input_log
from hil.sim.twin import Twin
from hil.vocab.time import SimTimeNs

__all__ = [
    "MemoryOptions",
    "PieceDifference",
    "Replayed",
    "piece_differences",
    "read_log",
    "replay",
    "replay_log",
]


class PieceDifference(NamedTuple):
    """First piece that a device sent otherwise, by its number; None: there is none."""

    device: str
    number: int
    was: Sent | None
    now: Sent | None

    @property
    def at_ns(self) -> SimTimeNs:
        return min(piece.at_ns for piece in (self.was, self.now) if piece)

    def words(self, was: str = "logged", now: str = "now") -> str:
        """Format for people; ``was`` and ``now``: names of the two runs."""
        said = f"{was} {_shown(self.was, self.now)}, {now} {_shown(self.now, self.was)}"
        return f"{self.device}, piece {self.number}: {said}"


def piece_differences(
    then: Iterable[Sent], now: Iterable[Sent], *, is_then_cut: bool, is_now_cut: bool = False
) -> list[PieceDifference]:
    """First piece of each device in which two runs differ, by time. Of a run that was cut the last pieces may
    be missing."""
    by_device: dict[str, tuple[list[Sent], list[Sent]]] = {}
    for side, pieces in enumerate((then, now)):
        for piece in pieces:
            by_device.setdefault(piece.device, ([], []))[side].append(piece)
    found = []
    for name, sides in by_device.items():
        for index, (was, other) in enumerate(zip_longest(*sides)):
            if _differs(was, other) and _differs(other, was):
                is_missing = (was is None and is_then_cut) or (other is None and is_now_cut)
                found += [] if is_missing else [PieceDifference(name, index, was, other)]
                break
    return sorted(found, key=lambda each: each.at_ns)


@dataclass
class Replayed:
    """Replay of a log: the logged output, and what the devices sent this time."""

    logged: InputLog
    runtime: BenchRuntime
    sent: dict[str, list[Sent]]
    stops: LoggedStops
    """Stops of devices by a daemon's guard."""

    def piece_differences(self) -> list[PieceDifference]:
        """First difference of each device from the log."""
        sent = [piece for name in self.sent for piece in self.sent[name]]
        return piece_differences(self.logged.sent, sent, is_then_cut=bool(self.logged.cut))

    def difference(self) -> str | None:
        """First difference from the log, or None: identical bytes, times and states, where it has them. What
        a device sent after the log's last input counts too, unless the log was cut, or does not say so."""
        if found := self.piece_differences():
            return found[0].words()
        for (name, _), stopped in self.stops.left.items():
            return f"{name}: logged as stopped ({stopped.reason}), now not"
        return None

    def summary(self) -> str:
        """One line for people."""
        cut = self.logged.cut
        return f"{self.counts()}; up to where the log ends: {cut}" if cut else self.counts()

    def counts(self) -> str:
        """Numbers of what was compared, for people."""
        pieces = [sent for device in self.sent.values() for sent in device]
        size = sum(len(sent.data) for sent in pieces)
        states = sum(sent.state is not None for sent in self.logged.sent)
        inputs = len(self.logged.inputs)
        return f"{inputs} inputs, {size} bytes in {len(pieces)} pieces, {states} states of axes"


def _differs(was: Sent | None, now: Sent | None) -> bool:
    if was and now and was.state is None:  # of an interrupt, or not kept
        now = replace(now, state=None)
    return was != now


def _shown(sent: Sent | None, other: Sent | None) -> str:
    """Format a piece with its bytes around the first that differs from the other's."""
    if sent is None:
        return "nothing"
    pairs = zip(sent.data, other.data if other else b"", strict=False)
    same = next((i for i, (byte, others) in enumerate(pairs) if byte != others), 0)
    state = "" if sent.state is None else f", state {sent.state:08x}"
    return f"{sent.data[max(same - 20, 0) : same + 40]!r} at {sent.at_ns} ns{state}"


def replay(
    log: str | Path | Iterable[str], *, strict: bool = True, trusts: Trusts = trusts_nobody
) -> Replayed:
    """Run a log or a bundle again, given as its path, or a log's lines, as far as it goes. ``strict``: a log
    that is damaged is refused; otherwise it is run as far as it is whole. ``trusts``: as ``read_log`` has it.

    Raises:
        InputLogError: it is not an input log, or of another program; says where.
        ConfigError: its configuration does not fit this program.
        OSError: it cannot be read, or is no regular file.
    """
    if isinstance(log, str | Path):
        return replay_log(read_log(Path(log), strict=strict, trusts=trusts))
    return replay_log(read_input_log(log, strict=strict))


def replay_log(
    read: InputLog,
    built: Callable[[BenchRuntime], None] = lambda bench: None,
    on_problem: Callable[[int, str], None] | None = None,
) -> Replayed:
    """Run a log again that was read. ``built``: called with the bench before anything has run;
    ``on_problem``: as ``LogCourse`` has it.

    Raises:
        InputLogError, ConfigError: as ``replay``.
    """
    course = LogCourse(read, on_problem)
    built(course.runtime)
    sent: dict[str, list[Sent]] = {name: [] for name in course.runtime.devices}

    def heard(device: Twin, port: str, at_ns: SimTimeNs, data: bytes) -> None:
        if course.note_sent(device.name):
            sent.setdefault(device.name, []).append(sent_now(device, port, at_ns, data))

    course.listeners.append(heard)
    course.finish()
    return Replayed(read, course.runtime, sent, course.stops)
