"""Log of who did what: every request that is no viewer's reading, with its asker, door and outcome."""

import asyncio
import base64
import logging
import time
from collections.abc import Callable, Mapping
from contextlib import AsyncExitStack
from hashlib import sha256
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from hil import __version__
from hil.config import BenchConfig
from hil.host.day_files import DayFiles, last_line
from hil.operations.event_log import DONE, OUTCOMES, Wish
from hil.sim.bench import BenchRuntime
from hil.vocab.desk_protocol import BenchClock, Proof
from hil.vocab.verbs import VerbRefused
from hil.wire.command_lines import AFTER, BEGINS, COMMANDS, chain_of, chained, command_words

TOGETHER_S = 1.0
"""Time within which requests of a stream are summed: the first has a line at once, the others one."""
EACH = 50
"""Maximum number of requests in that time of which each has its own line; a script has some ten a second."""
KINDS = 500
"""Maximum number of kinds that are summed apart; what is of others is summed together."""
WHY = 240
"""Maximum number of characters of a refusal's text."""
_SHORT = 80
"""Maximum number of characters of a name, and of a text among the parameters; longer ones, as programs, are
left out."""
PROOF_BYTES = 16_384
"""Maximum length of a signed payload that is kept; a longer one has its digest."""

log = logging.getLogger("hil")


class LineKeeper(Protocol):
    """Keeper of the lines of the log, as files are."""

    def keep(self, line: str, wall_ns: int) -> None:
        """Keep a line. ``wall_ns``: its time."""


BYTES_OF_MB = 1_000_000
_Kind = tuple[str, ...]
_OTHERS: _Kind = ()


class _Sum(NamedTuple):
    """Requests of a kind: the latest one's row, their number, and the time of the first."""

    row: dict[str, Any]
    times: int
    from_sim_ns: int


class CommandLog:
    """Log of the requests to one bench. ``times_ns``: simulated time and the wall's, now; ``later``: calls
    back after a time in seconds; ``keeper``: of all lines; ``is_told``: each has a line in the daemon's log,
    too; ``after``: chain of the last line that was kept."""

    def __init__(
        self,
        bench: str,
        times_ns: Callable[[], tuple[int, int]],
        later: Callable[[float, Callable[[], None]], object],
        keeper: LineKeeper | None = None,
        *,
        is_told: bool = False,
        after: str = "",
    ) -> None:
        self._bench, self._times_ns, self._later = bench, times_ns, later
        self._keeper, self._is_told, self._chain = keeper, is_told, after
        self._number = 0
        self._each = 0
        """Number of lines in this time that stand for one request."""
        self._begun = set[_Kind]()
        """Kinds of streams that go on: the next of them is summed."""
        self._sums: dict[_Kind, _Sum] = {}
        self._is_waiting = False
        self.outcomes = dict.fromkeys(OUTCOMES, 0)
        """Number of requests by outcome."""
        self.listeners: list[Callable[[str, Mapping[str, Any]], object]] = []
        """Called with each line, and its content."""

    def begin(self) -> None:
        """Write the line that says which bench begins, and which line it goes on from."""
        sim_ns, wall_ns = self._times_ns()
        about = {BEGINS: f"hil {__version__}", "bench": self._bench, AFTER: self._chain}
        self._write({"sim_ns": sim_ns, "wall_ns": wall_ns, **about})

    def put(self, wish: Wish, outcome: str, refusal: VerbRefused | None = None) -> None:
        """Note a request and its outcome."""
        if outcome == DONE and _is_beat(wish):
            return
        self.outcomes[outcome] += 1
        source, target = wish.asked.source, wish.asked.target
        door, user = source.via or source.name, source.person
        code = refusal.code if refusal else ""
        kind = (user, door, wish.name, target, outcome, code)
        sim_ns, wall_ns = self._times_ns()
        row: dict[str, Any] = {"sim_ns": sim_ns, "wall_ns": wall_ns, "user": user, "door": door}
        row |= {"role": source.role.name.lower(), "operation": wish.name, "target": target[:_SHORT]}
        row |= {"given": _short(wish.given), "outcome": outcome}
        if refusal:
            row |= {"code": code, "why": (str(refusal).splitlines() or [code])[0][:WHY]}
        if source.proof:
            row["proof"] = _proof(source.proof)
        is_stream = wish.streams or wish.kind == "typed"
        if self._each >= EACH or (is_stream and kind in self._begun):
            self._add(kind, row)
        else:
            self._each += 1
            self._put_line(row)
        if is_stream:
            self._begun.add(kind)
        if not self._is_waiting:
            self._is_waiting = True
            self._later(TOGETHER_S, self._look)

    def flush(self) -> None:
        """Write the sums now."""
        sums, self._sums = self._sums, {}
        for each in sums.values():
            self._put_line({**each.row, "count": each.times, "from_sim_ns": each.from_sim_ns})

    def _add(self, kind: _Kind, row: dict[str, Any]) -> None:
        if kind not in self._sums and len(self._sums) >= KINDS:
            kind = _OTHERS
            row = {**row, "user": "", "door": "", "operation": "several", "target": "", "given": {}}
            row.pop("proof", None)
        before = self._sums.get(kind, _Sum(row, 0, row["sim_ns"]))
        self._sums[kind] = _Sum(row, before.times + 1, before.from_sim_ns)

    def _look(self) -> None:
        """Write the sums of this time; looks again while something comes."""
        goes_on = {*self._sums}
        self._is_waiting = bool(goes_on or self._each)
        self.flush()
        self._each, self._begun = 0, goes_on & self._begun
        if self._is_waiting:
            self._later(TOGETHER_S, self._look)

    def _put_line(self, row: dict[str, Any]) -> None:
        self._number += 1
        if self._is_told:
            log.info("command: %s", command_words(row))
        self._write({"number": self._number, **row})

    def _write(self, row: dict[str, Any]) -> None:
        line = chained(row, self._chain)
        self._chain = line.chain
        if self._keeper:
            self._keeper.keep(line.text, row["wall_ns"])
        for listener in tuple(self.listeners):
            listener(line.text, row)


def _is_beat(wish: Wish) -> bool:
    """True for what benches say to each other while a run goes on, twice a second, or before it begins."""
    part = wish.given.get("given") if wish.operation == "part" else None
    return isinstance(part, Mapping) and part.get("do") in ("look", "beat")


def _short(given: Mapping[str, object]) -> dict[str, object]:
    """Parameters that are short: numbers, and texts that are no programs."""
    return {
        str(name)[:_SHORT]: value
        for name, value in given.items()
        if (isinstance(value, int | float) and isfinite(value))
        or (isinstance(value, str) and len(value) <= _SHORT)
    }


def _proof(proof: Proof) -> dict[str, str]:
    told = {"key": proof.key, "attachment": proof.attachment.decode(errors="replace")}
    if len(proof.payload) > PROOF_BYTES:
        return told | {"payload_sha256": sha256(proof.payload).hexdigest()}
    return told | {"payload_base64": base64.b64encode(proof.payload).decode()}


def begin_commands(
    stack: AsyncExitStack,
    config: BenchConfig,
    sim: BenchRuntime,
    clock: BenchClock,
    state_dir: Path,
    is_service: bool,
    *,
    is_live: bool,
) -> CommandLog:
    """Begin the log of a bench's commands, which ``stack`` ends. ``is_live``: its times are the wall's, and
    its lines are kept in the state directory as configured."""
    keep, loop = config.commands, asyncio.get_running_loop()
    if not is_live:
        return CommandLog(config.bench, clock.times_ns, loop.call_later)
    is_told = is_service if keep.journal is None else keep.journal
    files, after = None, ""
    if keep.keep_days:
        folder = state_dir / COMMANDS
        files, after = (
            DayFiles(folder, keep.keep_days, keep.keep_MB * BYTES_OF_MB),
            chain_of(last_line(folder)),
        )
        stack.push_async_callback(files.close)
    commands = CommandLog(
        config.bench,
        lambda: (sim.now_ns, time.time_ns()),
        loop.call_later,
        files,
        is_told=is_told,
        after=after,
    )
    stack.callback(commands.flush)
    commands.begin()
    return commands
