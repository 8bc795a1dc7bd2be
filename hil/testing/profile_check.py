"""Checks that every kind of board has to pass, wherever its folder is: ``hil profile check FOLDER``."""

import re
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from random import Random
from typing import Any

from hil.compose import find_catalogue
from hil.compose.replay import MemoryOptions, replay
from hil.config import ProfileInfo
from hil.core import FIELDS
from hil.discovery.board_places import MAKE_ONE
from hil.sim.bench import BenchHooks
from hil.sim.firmware_guard import FirmwareHung, Unguarded
from hil.sim.input_log import InputLogWriter
from hil.sim.state_checksum import snapshot_text
from hil.testing.bench import Bench
from hil.testing.checks.findings import CheckFailed
from hil.vocab.address import Address
from hil.vocab.parameters import Parameter
from hil.vocab.profile import Example
from hil.vocab.verbs import Verb, VerbRefused

DEVICE = "d"
TURN_S = 5.0
"""Time that one turn of a firmware may take; the daemon's guard allows 0.2 s of CPU time."""
IDLE_MS, GARBAGE_ROUNDS, FLOOD_BYTES = 1000.0, 40, 5_000
ROUNDING_NS = 1000
"""Rounding of characters' times: those of a piece are multiples of a character from its beginning."""
LINE_NS = 100_000_000
"""Time that what is on a line still takes after a reset, before the board's first words."""
UNEVEN_MS = 0.1337
"""Odd running time before a reset, so that it comes at no special moment of the board's."""

_FILE = re.compile(r"\((\w+\.py)(?=:\d+\))")
"""File of a line that raised, as ``hil.sim.firmware_guard.place_of`` has it."""

Heard = dict[str, list[tuple[int, bytes]]]
"""Bytes that a board sent, by its UARTs, with their times."""


def check_profile(folder: str | Path) -> None:
    """Check a board, given as its folder.

    Raises:
        CheckFailed: it does not pass; a line for each check that failed, with what was seen.
    """
    if failures := list(profile_failures(Path(folder))):
        raise CheckFailed(f"the board {Path(folder).name}", failures)


def profile_failures(folder: Path) -> Iterator[str]:
    """Carry out the checks; answers what failed. A board that does not power up fails once."""
    folder = folder.resolve()
    catalogue = find_catalogue({"memory": MemoryOptions}, [folder.parent])
    if problems := catalogue.problems(folder.name):
        yield from (f"it loads: {problem}" for problem in problems)
        return
    if folder.name not in catalogue.profiles:
        yield f"it loads: {folder} is no board: {MAKE_ONE}"
        return
    config = {
        "bench": "check",
        "profile_path": [str(folder.parent)],
        "devices": {DEVICE: {"profile": folder.name}},
    }
    known = FIELDS.keys() | catalogue.profiles[folder.name].fields.keys()
    if strange := [name for name in catalogue.boards[folder.name].shown_first if name not in known]:
        yield f"its shown_first are fields of an axis: there is none named {', '.join(strange)}"
    board = catalogue.boards[folder.name]
    trial = Trial(config, catalogue.profiles[folder.name], board.examples, board.verbs)
    if failed := trial.idle().failed:
        yield f"it powers up: {_placed(failed, folder)}"
        return
    for name, check in CHECKS.items():
        if why := check(trial):
            yield f"{name}: {_placed(why, folder)}"


def _placed(why: str, folder: Path) -> str:
    """Text with the folder before the board's files that it names."""
    return _FILE.sub(lambda m: f"({folder.name}/{m[1]}" if (folder / m[1]).exists() else m[0], why)


@dataclass
class Ran:
    """Board that has run: what it sent, how its axes stand, why it failed, and the log of it."""

    heard: Heard
    stand: Heard
    """State of each axis at the end, as a text."""
    failed: str | None
    log: StringIO


class _Alarm(Unguarded):
    """Guard that stops a firmware which comes to no end; in the main thread, where signals arrive."""

    @contextmanager
    def __call__(self, device: object, /) -> Iterator[None]:
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = signal.signal(signal.SIGALRM, _ring)
        signal.setitimer(signal.ITIMER_REAL, TURN_S)
        try:
            yield
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, before)


def _ring(*_: object) -> None:
    raise FirmwareHung(f"one step took more than {TURN_S:g} s: it has to yield what it waits for")


@dataclass
class Trial:
    """Board under trial: each run is one of a new bench."""

    config: dict[str, Any]
    info: ProfileInfo
    examples: tuple[Example, ...]
    verbs: tuple[Verb, ...]
    bauds: dict[str, int | None] = field(init=False)
    ready_ms: float = field(init=False)

    def __post_init__(self) -> None:
        self.bauds = {name: uart.baud for name, uart in self.info.uarts.items()}
        self.ready_ms = self.info.ready_after_s * 1000 + IDLE_MS

    def run(self, script: Callable[[Bench], None], step_ms: float | None = None) -> Ran:
        """Run a script after power-up, then idle; ``step_ms``: advanced in steps of that length."""
        log = StringIO()
        around = BenchHooks(guard=_Alarm(), log=InputLogWriter(log, "check", self.config, {}))
        with Bench(self.config, around=around) as bench:
            _advance(bench, self.ready_ms, step_ms)
            script(bench)
            _advance(bench, self.ready_ms, step_ms)
            heard = {uart: _joined(bench.port(DEVICE, uart).timeline) for uart in self.bauds}
            states = {axis: bench.axis(str(Address(DEVICE, axis))).snapshot() for axis in self.info.axes}
            stand = {
                axis: [(int(bench.now_ns), snapshot_text(state).encode())] for axis, state in states.items()
            }
            return Ran(heard, stand, bench.device(DEVICE).failed, log)

    def idle(self, step_ms: float | None = None) -> Ran:
        return self.run(lambda bench: None, step_ms)

    def garbage(self, seed: int, *, one_by_one: bool = False) -> Ran:
        """Run with random bytes at all UARTs: at those with a baud in one piece, or byte by byte."""

        def script(bench: Bench) -> None:
            random = Random(seed)
            for _ in range(GARBAGE_ROUNDS):
                for uart, baud in self.bauds.items():
                    data = random.randbytes(random.randint(1, 12))
                    single = one_by_one and baud
                    for piece in [bytes([byte]) for byte in data] if single else [data]:
                        bench.port(DEVICE, uart).write(piece)
                bench.run(ms=random.choice((0.1, 3.0, 40.0, 400.0)))

        return self.run(script)


def _advance(bench: Bench, ms: float, step_ms: float | None) -> None:
    end_ns = bench.now_ns + round(ms * 1e6)
    while step_ms and bench.now_ns + round(step_ms * 1e6) < end_ns:
        bench.run(ms=step_ms)
    bench.run_until(end_ns / 1e6)


def _joined(pieces: list[tuple[Any, bytes]]) -> list[tuple[int, bytes]]:
    joined: list[tuple[int, bytes]] = []
    for at_ns, data in pieces:
        if joined and joined[-1][0] == at_ns:
            data = joined.pop()[1] + data
        joined.append((int(at_ns), data))
    return joined


def _same(one: Heard, other: Heard, within_ns: int = 0) -> str | None:
    """First difference of what was heard, or None. ``within_ns``: times may differ by less."""
    for uart in one:
        first, second = one[uart], other[uart]
        for index in range(max(len(first), len(second))):
            was = first[index] if index < len(first) else None
            now = second[index] if index < len(second) else None
            is_same = was and now and was[1] == now[1] and abs(was[0] - now[0]) <= within_ns
            if not is_same:
                return f"at {uart} once {_told(was)}, once {_told(now)}"
    return None


def _told(piece: tuple[int, bytes] | None) -> str:
    return f"{piece[1][:40]!r} at {piece[0] / 1e6:g} ms" if piece else "nothing"


def _alike(one: Ran, other: Ran) -> str | None:
    """First difference of what was heard, or of where the axes stand in the end; or None."""
    return _same(one.heard, other.heard) or _same(one.stand, other.stand)


def _time(trial: Trial) -> str | None:
    return _alike(trial.idle(), trial.idle(step_ms=7.3))


def _chunks(trial: Trial) -> str | None:
    return _same(trial.garbage(1).heard, trial.garbage(1, one_by_one=True).heard, ROUNDING_NS)


def _repeatable(trial: Trial) -> str | None:
    return _alike(trial.garbage(2), trial.garbage(2))


def _garbage(trial: Trial) -> str | None:
    return next(filter(None, (trial.garbage(seed).failed for seed in range(3, 6))), None)


def _flood(trial: Trial) -> str | None:
    def script(bench: Bench) -> None:
        for uart in trial.bauds:
            bench.port(DEVICE, uart).write(Random(6).randbytes(FLOOD_BYTES))
        times_ms = [FLOOD_BYTES * 10_000 / (baud or FLOOD_BYTES) for baud in trial.bauds.values()]
        bench.run(ms=max(times_ms, default=IDLE_MS))

    return trial.run(script).failed


def _reset(trial: Trial) -> str | None:
    """Check that a board that is switched off and on does what it did at first: what it knew is in its memory
    alone."""
    reset_ns = []

    def script(bench: Bench) -> None:
        bench.run(ms=UNEVEN_MS)
        reset_ns.append(int(bench.now_ns))
        bench.device(DEVICE).reset()

    ran = trial.run(script)
    if ran.failed:
        return ran.failed
    end_ns = round(trial.ready_ms * 1e6) - LINE_NS
    first, after = (
        {
            uart: [(at_ns - start_ns, data) for at_ns, data in pieces if at_ns >= start_ns]
            for uart, pieces in ran.heard.items()
        }
        for start_ns in (0, *reset_ns)
    )
    return _same_until(end_ns, first, after) or _same_until(end_ns, after, first)


def _same_until(end_ns: int, one: Heard, other: Heard) -> str | None:
    """First difference between what ``one`` sent before ``end_ns`` and as much of ``other``, or None."""
    early = {uart: [piece for piece in pieces if piece[0] < end_ns] for uart, pieces in one.items()}
    return _same(early, {uart: pieces[: len(early[uart])] for uart, pieces in other.items()}, LINE_NS)


def _replays(trial: Trial) -> str | None:
    return _difference(trial.garbage(7))


def _difference(ran: Ran) -> str | None:
    """First difference of a run from its replay, or None."""
    return replay(ran.log.getvalue().splitlines(keepends=True)).difference()


def _examples(trial: Trial) -> str | None:
    wrong: list[str] = []

    def script(bench: Bench) -> None:
        for example in trial.examples:
            port = bench.port(DEVICE, example.uart)
            port.read()
            port.write(example.types)
            bench.run(ms=example.within_ms)
            said = b"".join(data for at_ns, data in port.read_complete() if at_ns <= bench.now_ns)
            if example.answer not in said:
                wrong.append(f"{example.types!r} is answered within {example.within_ms:g} ms by {said!r}")
                wrong[-1] += f", in which there is no {example.answer!r}"

    ran, again = trial.run(script), trial.run(script)
    return ran.failed or next(iter(wrong), None) or _same(ran.heard, again.heard) or _difference(ran)


def _verbs(trial: Trial) -> str | None:
    """Check that no verb stops the board, with the least and with the largest of each parameter."""
    wrong: list[str] = []
    verbs = [verb for verb in trial.verbs if verb.run]

    def script(bench: Bench) -> None:
        device = bench.device(DEVICE)
        for verb, is_most in ((verb, is_most) for verb in verbs for is_most in (False, True)):
            with suppress(VerbRefused):  # it may be no time for it
                device.do(verb.name, **{each.name: _extreme(each, is_most) for each in verb.parameters})
            bench.run(ms=UNEVEN_MS)
            if device.failed:
                wrong.append(f"{verb.name}: {device.failed}")
                device.reset()
                bench.run(ms=trial.ready_ms)

    failed = trial.run(script).failed if verbs else None
    return "; ".join(dict.fromkeys(wrong)) or failed


def _extreme(parameter: Parameter, is_most: bool) -> float | str:
    """Least or largest value that a parameter can have."""
    if parameter.choices:
        return parameter.choices[-1 if is_most else 0]
    if parameter.is_text:
        return "x" * min(int(parameter.maximum), 80) if is_most else ""
    value = parameter.maximum if is_most else parameter.minimum
    return int(value) if parameter.is_whole else value


CHECKS: dict[str, Callable[[Trial], str | None]] = {
    "it does the same however time passes": _time,
    "it does the same however its bytes are cut into pieces": _chunks,
    "the same bytes at the same times give the same answers": _repeatable,
    "garbage does not stop it": _garbage,
    "a flood does not stop it": _flood,
    "its verbs do not stop it": _verbs,
    "after off and on it does as at first": _reset,
    "a log of it replays identically": _replays,
    "its examples are answered, each time and in a replay": _examples,
}
