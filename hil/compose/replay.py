"""Runs an input log again on the virtual clock, and compares with what the devices sent then."""

from codecs import BOM_UTF8
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from itertools import count, zip_longest
from pathlib import Path

from hil.compose.build import bench_runtime
from hil.compose.find import find_catalogue
from hil.config import from_dict
from hil.config.explain import StrictModel
from hil.host.regular_file import open_regular
from hil.sim.bench import BenchHooks, BenchRuntime
from hil.sim.firmware_guard import LoggedStops
from hil.sim.group import Group
from hil.sim.groups_together import SLICE_NS, advance_together
from hil.sim.input_check import input_problem
from hil.sim.input_log import REMEDY, InputLog, Sent, place, read_input_log, sent_now
from hil.sim.inputs import CommitDone, InputLogError, Logged, Stopped
from hil.sim.twin import Twin
from hil.vocab.address import address_of
from hil.vocab.time import FOREVER, SimTimeNs
from hil.vocab.verbs import VerbRefused

LONGEST_LINE_BYTES = 64 * 1024 * 1024
"""Maximum length of a line: the longest header, of 512 boards with their tables, has two thirds."""

LONGEST_PROBLEM = 1000
"""Maximum characters of a problem; names in a forged log may be of any length."""


class MemoryOptions(StrictModel):
    """Options of the port kind ``memory``, of which there are none."""


@dataclass
class Replayed:
    """Replay of a log: the logged output, and what the devices sent this time."""

    logged: InputLog
    runtime: BenchRuntime
    sent: dict[str, list[Sent]]
    stops: LoggedStops
    """Stops of devices by a daemon's guard."""

    def difference(self) -> str | None:
        """First difference from the log, or None: identical bytes, times and states, where it has them. What
        a device sent after the log's last input counts too, unless the log was cut, or does not say so."""
        for name in self.sent:
            then = [sent for sent in self.logged.sent if sent.device == name]
            for index, (was, now) in enumerate(zip_longest(then, self.sent[name])):
                if _differs(was, now) and not (was is None and self.logged.cut):
                    return f"{name}, piece {index}: logged {_shown(was, now)}, now {_shown(now, was)}"
        for (name, _), stopped in self.stops.left.items():
            return f"{name}: logged as stopped ({stopped.reason}), now not"
        return None

    def summary(self) -> str:
        """One line for people."""
        pieces = [sent for device in self.sent.values() for sent in device]
        size = sum(len(sent.data) for sent in pieces)
        states = sum(sent.state is not None for sent in self.logged.sent)
        inputs, cut = len(self.logged.inputs), self.logged.cut
        end = f"; up to where the log ends: {cut}" if cut else ""
        return f"{inputs} inputs, {size} bytes in {len(pieces)} pieces, {states} states of axes{end}"


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


class _LoggedStore:
    """Store whose answers are those of the log: each an input, or at once where it was so then."""

    def __init__(self, inputs: Iterable[Logged]) -> None:
        self._answers: dict[str, deque[CommitDone]] = {}
        for logged in inputs:
            if isinstance(logged.input, CommitDone):
                self._answers.setdefault(logged.device, deque()).append(logged.input)

    def commit(
        self, device: Twin, sections: Mapping[str, bytes], answered: Callable[[bool], bool]
    ) -> bool | None:
        answers = self._answers.get(device.name)
        done = answers.popleft() if answers else None
        return done.durable if done and done.at_once else None


def replay(log: str | Path | Iterable[str]) -> Replayed:
    """Run a log again, given as its path or its lines, as far as it goes.

    Raises:
        InputLogError: it is not an input log, or of another program; says where.
        ConfigError: its configuration does not fit this program.
        OSError: it cannot be read, or is no regular file.
    """
    if isinstance(log, str | Path):
        return replay_log(read_input_log(_lines(Path(log)), str(log)))
    return replay_log(read_input_log(log))


def _lines(path: Path) -> Iterator[bytes]:
    with open_regular(path) as file:
        for number in count(1):
            line = file.readline(LONGEST_LINE_BYTES + 1)
            if len(line) > LONGEST_LINE_BYTES:
                raise InputLogError(f"{place(str(path), number)}: a line without end; {REMEDY}")
            if not line:
                return
            yield line.removeprefix(BOM_UTF8) if number == 1 else line  # an editor's mark


def replay_log(read: InputLog, built: Callable[[BenchRuntime], None] = lambda bench: None) -> Replayed:
    """Run a log again that was read. ``built``: called with the bench before anything has run.

    Raises:
        InputLogError, ConfigError: as ``replay``.
    """
    config = from_dict(read.config, find_catalogue({"memory": MemoryOptions}))
    catalogue = find_catalogue({"memory": MemoryOptions}, config.profile_path)
    inputs = [(logged.device, logged.input) for logged in read.inputs]
    stops = LoggedStops({(name, each.turn): each for name, each in inputs if isinstance(each, Stopped)})
    runtime = bench_runtime(
        config, catalogue, read.memories, _LoggedStore(read.inputs), BenchHooks(guard=stops)
    )
    built(runtime)
    replayed = Replayed(read, runtime, {name: [] for name in runtime.devices}, stops)
    course = _Course(read, runtime)

    def heard(device: Twin, port: str, at_ns: SimTimeNs, data: bytes) -> None:
        if course.note_sent(device.name):
            replayed.sent[device.name].append(sent_now(device, port, at_ns, data))

    for device in runtime.devices.values():
        for port, uart in device.uarts.items():
            uart.listeners.append(partial(heard, device, port))
    for name, card in runtime.cards.items():
        card.listeners.append(partial(heard, card.device, address_of(name).part))
    for index, logged in enumerate(read.inputs):
        if problem := _problem(runtime, logged):
            said = problem if problem.isprintable() else repr(problem)
            remedy = f"replay it with what wrote it, {read.program}"
            raise InputLogError(f"{read.where(index)}: {said[:LONGEST_PROBLEM]}; {remedy}")
        group = runtime.parts.group_of(logged.device)
        course.reach(group, logged.at_ns)
        is_note = isinstance(logged.input, CommitDone) and logged.input.at_once
        if not (is_note or isinstance(logged.input, Stopped)):
            with suppress(VerbRefused):  # it was refused then, too
                runtime.apply_input(logged.device, logged.input, logged.at_ns)
        course.note_input(group)
    course.finish()
    return replayed


class _Course:
    """Ways of a bench's groups through a log, side by side. A group goes as far as to its next input, and
    after the last as far as it is known to have run.

    What was sent is logged with its time on the line, which a paced line reaches later than its group: the
    run ended when the last piece was printed, and not when its last byte would have been on the line.
    """

    def __init__(self, read: InputLog, runtime: BenchRuntime) -> None:
        self._core = runtime.core
        self._of_device = {name: runtime.parts.group_of(name) for name in runtime.devices}
        self._inputs_ns: dict[Group, deque[SimTimeNs]] = {}
        """Times of inputs to come."""
        for logged in read.inputs:
            with suppress(KeyError):  # of nothing that is there: refused in its turn
                self._inputs_of(runtime.parts.group_of(logged.device)).append(logged.at_ns)
        self._missing = Counter[Group]()
        """Numbers of pieces that were sent then, and have not been now."""
        self._last_ns: dict[Group, SimTimeNs] = {}
        """Times of the last pieces."""
        for sent in read.sent:
            if group := self._of_device.get(sent.device):
                self._missing[group] += 1
                self._last_ns[group] = max(sent.at_ns, self._last_ns.get(group, SimTimeNs(0)))
        self._ends_ns: dict[Group, SimTimeNs] = {}
        """Ends of groups that have come to them."""
        self._groups = sorted({*self._of_device.values(), *self._inputs_ns}, key=lambda group: group.id)

    def _inputs_of(self, group: Group) -> deque[SimTimeNs]:
        return self._inputs_ns.setdefault(group, deque())

    def note_sent(self, device: str) -> bool:
        """Note that a device sends something; answers whether it is before the end."""
        group = self._of_device[device]
        if group.now_ns > self._ends_ns.get(group, FOREVER):
            return False
        self._missing[group] -= 1
        if not self._inputs_of(group) and self._missing[group] == 0:
            self._ends_ns[group] = group.now_ns
        return True

    def note_input(self, group: Group) -> None:
        """Note that a group has had its next input."""
        self._inputs_of(group).popleft()
        if not self._inputs_of(group) and self._missing[group] <= 0:
            self._ends_ns[group] = group.now_ns

    def reach(self, group: Group, at_ns: SimTimeNs) -> None:
        """Take a group to the time of its next input, and the others on beside it."""
        if group.now_ns < at_ns:
            self._advance(SimTimeNs(at_ns + SLICE_NS))
            group.advance(at_ns)

    def finish(self) -> None:
        """Take all groups to their ends; they have had their inputs."""
        self._advance(max(self._last_ns.values(), default=SimTimeNs(0)))
        for group in self._groups:
            group.advance(self._limit_ns(group))  # one that is there may not have begun

    def _advance(self, until_ns: SimTimeNs) -> None:
        limits = [(group, self._limit_ns(group)) for group in self._groups]
        ways = [(group, limit_ns) for group, limit_ns in limits if group.now_ns < limit_ns]
        if ways:
            groups, limits_ns = zip(*ways, strict=True)
            advance_together(self._core, groups, until_ns, limits_ns)

    def _limit_ns(self, group: Group) -> SimTimeNs:
        if inputs_ns := self._inputs_of(group):
            return inputs_ns[0]
        return SimTimeNs(-1) if group in self._ends_ns else self._last_ns.get(group, SimTimeNs(-1))


def _problem(runtime: BenchRuntime, logged: Logged) -> str | None:
    if problem := input_problem(runtime, logged.device, logged.input):
        return problem
    reached_ns = runtime.parts.group_of(logged.device).now_ns
    if logged.at_ns < reached_ns:
        return f"time goes back: {logged.at_ns} ns, and {logged.device} was at {reached_ns} ns already"
    return None
