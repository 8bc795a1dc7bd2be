"""Differences of two recordings, of a recording and a bench of today, or of one and another configuration."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from typing import Any

from hil.compose.build import start_memories
from hil.compose.bundles import UnpackedBundle
from hil.compose.replay import PieceDifference, piece_differences, replay_log
from hil.config import BenchConfig, Catalogue, ConfigError
from hil.config.diff import changed_keys
from hil.recorded.log_beginning import before_reload, beginning
from hil.recorded.parting import RunsApart, parting
from hil.recorded.recorded_run import RecordedRun
from hil.recorded.run_events import input_event
from hil.sim.input_log import InputLog
from hil.sim.inputs import InputLogError, Logged

AROUND = 5
"""Number of inputs before a difference that are told."""
LAST_BYTES = 80
"""Maximum of what a device said before that is told."""
_NO_MATTER = (
    *(
        "bridges",
        "labels",
        "profile_path",
        "runtime_dir",
        "state_dir",
        "cpu",
        "recordings",
        "commands",
        "speed",
        "rate_hz",
    ),
)
"""Keys of a configuration of which nothing in a run on the virtual clock depends."""


@dataclass
class LogDifferences:
    """Differences of two runs, the first and the second. ``config``: lines ``key: old -> new``; ``inputs``:
    the first that differ, with their number; ``pieces``: first difference of each device in what it sent, by
    time; ``apart``: states and bytes where both run today; ``notes``: what could not be compared."""

    program: tuple[str, str] | None = None
    config: Sequence[str] = ()
    memories: list[str] = field(default_factory=list)
    boards: list[str] = field(default_factory=list)
    inputs: tuple[int, Logged | None, Logged | None] | None = None
    pieces: list[PieceDifference] = field(default_factory=list)
    apart: RunsApart = field(default_factory=RunsApart)
    state: dict[str, dict[str, float]] = field(default_factory=dict)
    """Fields of the axes of a device today, where what it sent then differs."""
    inputs_before: list[str] = field(default_factory=list)
    said_before: bytes = b""
    notes: list[str] = field(default_factory=list)

    @property
    def at_ns(self) -> int | None:
        """Time of the first difference in what happened; None: there is none."""
        times = [each.at_ns for each in self.pieces]
        if self.inputs:
            times += [each.at_ns for each in self.inputs[1:] if each]
        if self.apart.first_ns is not None:
            times.append(self.apart.first_ns)
        return min(times, default=None)

    @property
    def differ(self) -> bool:
        """True if there is a difference, of whatever kind but the program's name."""
        return bool(self.config or self.memories or self.boards or self.at_ns is not None)


def compare_logs(one: InputLog, other: InputLog) -> LogDifferences:
    """Compare two recordings."""
    found = LogDifferences()
    if one.program != other.program:
        found.program = one.program, other.program
    found.config = changed_keys(_run_config(one.config), _run_config(other.config))
    found.memories = _memories(one.memories, other.memories)
    found.boards = _boards(one, other)
    found.inputs = _first_input(one, other)
    found.pieces = piece_differences(
        one.sent, other.sent, is_then_cut=bool(one.cut), is_now_cut=bool(other.cut)
    )
    for log in (one, other):
        found.notes += [f"{log.name}: {log.cut}"] if log.cut else []
    if found.differ:
        _around(found, one)
        found.apart = _apart(found, lambda: RecordedRun(one, _ignore), lambda: RecordedRun(other, _ignore))
    return found


def compare_today(log: InputLog) -> LogDifferences:
    """Compare a recording with what the boards of this program make of its inputs, as far as they take
    them.

    Raises:
        ConfigError: its configuration does not fit this program.
    """
    found = LogDifferences(notes=[log.cut] if log.cut else [])
    problems: list[tuple[int, str]] = []
    replayed = replay_log(log, on_problem=lambda index, why: problems.append((index, why)))
    if problems:
        index, why = problems[0]
        found.notes.append(f"{log.where(index)}: {why}; compared up to there")
        log = beginning(log, index, log.inputs[index].at_ns, why)
        replayed = replay_log(log)
    found.pieces = replayed.piece_differences()
    for (name, _), stopped in replayed.stops.left.items():
        found.notes.append(f"{name}: logged as stopped ({stopped.reason}), now not")
    if found.pieces:
        first = found.pieces[0]
        _around(found, log)
        with closing(RecordedRun(log, _ignore)) as run:
            run.run_until(first.at_ns)
            axes = [axis for axis in run.runtime.parts.axes if axis.partition(".")[0] == first.device]
            found.state = {axis: run.runtime.snapshot(axis).as_dict() for axis in axes}
    return found


def compare_config(
    log: InputLog, config: BenchConfig, simulated: dict[str, Any], catalogue: Catalogue
) -> LogDifferences:
    """Compare a recording's run with that of its inputs at a bench of another configuration. ``simulated``:
    the configuration as a log has it.

    Raises:
        ConfigError: a configuration does not fit this program.
    """
    log = before_reload(log)
    started = start_memories(config, catalogue)
    memories = {name: log.memories.get(name, started[name]) for name in started}
    changed = replace(log, config=simulated, memories=memories)
    found = LogDifferences(config=changed_keys(_run_config(log.config), _run_config(simulated)))
    left_out: dict[int, str] = {}
    found.apart = parting(lambda: RecordedRun(log), lambda: RecordedRun(changed, left_out.__setitem__))
    found.notes = [log.cut] if log.cut else []
    found.notes += [f"{log.where(index)}: {why}; left out" for index, why in left_out.items()]
    if found.at_ns is not None:
        _around(found, log)
    return found


def _ignore(index: int, why: str) -> None:
    """Leave out an input that the bench cannot take."""


def _run_config(config: Mapping[str, Any]) -> dict[str, Any]:
    """Part of a configuration of which a run depends, without what is not given, as a bundle has it."""
    kept = {key: value for key, value in config.items() if key not in _NO_MATTER}
    devices = {name: dict(each) for name, each in config["devices"].items() if not each.get("at")}
    for device in devices.values():
        if "/" in str((flash := device.get("flash") or {}).get("table", "")):
            device["flash"] = flash | {"table": "stored"}
    return {key: _given(value) for key, value in (kept | {"devices": devices}).items()}


def _given(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    return {key: _given(each) for key, each in value.items() if each is not None}


def _memories(one: Mapping[str, Mapping[str, bytes]], other: Mapping[str, Mapping[str, bytes]]) -> list[str]:
    names = [
        (device, section)
        for device in {**one, **other}
        for section in {**one.get(device, {}), **other.get(device, {})}
    ]
    return [
        f"{device}: {section or 'its memory'} differs"
        for device, section in names
        if one.get(device, {}).get(section) != other.get(device, {}).get(section)
    ]


def _boards(one: InputLog, other: InputLog) -> list[str]:
    """Boards that differ, of two bundles; a log does not say."""
    if not isinstance(one.unpacked, UnpackedBundle) or not isinstance(other.unpacked, UnpackedBundle):
        return []
    ours, theirs = one.unpacked.manifest.boards, other.unpacked.manifest.boards
    both = [(name, board, theirs[name]) for name, board in ours.items() if name in theirs]
    return [
        f"{name}: {our.sha256[:12]} ({our.origin}), {their.sha256[:12]} ({their.origin})"
        for name, our, their in both
        if our.sha256 != their.sha256
    ]


def _first_input(one: InputLog, other: InputLog) -> tuple[int, Logged | None, Logged | None] | None:
    for index, (ours, theirs) in enumerate(zip_longest(one.inputs, other.inputs)):
        if ours != theirs:
            is_missing = (ours is None and one.cut) or (theirs is None and other.cut)
            return None if is_missing else (index, ours, theirs)
    return None


def _around(found: LogDifferences, log: InputLog) -> None:
    """Tell what was around the first difference."""
    at_ns = found.at_ns
    if at_ns is None:
        return
    before = [each for each in log.inputs if each.at_ns <= at_ns]
    found.inputs_before = [input_event(each).line() for each in before[-AROUND:]]
    device = (
        found.pieces[0].device if found.pieces else (found.apart.sent[0].place if found.apart.sent else "")
    )
    said = b"".join(each.data for each in log.sent if each.device == device and each.at_ns < at_ns)
    found.said_before = said[-LAST_BYTES:]


def _apart(
    found: LogDifferences, one: Callable[[], RecordedRun], other: Callable[[], RecordedRun]
) -> RunsApart:
    try:
        return parting(one, other)
    except (ConfigError, InputLogError) as error:
        found.notes.append(f"states are not compared: {str(error).splitlines()[0]}")
        return RunsApart()
