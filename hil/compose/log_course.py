"""Run of an input log on the virtual clock, which goes as far as it is asked to."""

from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

from hil.compose.build import bench_runtime, make_device
from hil.compose.find import find_catalogue
from hil.config import BenchConfig, Catalogue, from_dict
from hil.config.explain import StrictModel
from hil.sim.bench import BenchHooks, BenchRuntime
from hil.sim.firmware_guard import LoggedStops
from hil.sim.group import Group
from hil.sim.groups_together import SLICE_NS, advance_together
from hil.sim.input_check import input_problem
from hil.sim.input_log import InputLog, ReloadPlace
from hil.sim.inputs import CommitDone, InputLogError, Logged, Stopped
from hil.sim.reloads import Reloaded
from hil.sim.twin import Twin
from hil.vocab.address import address_of, owner_of
from hil.vocab.time import FOREVER, SimTimeNs
from hil.vocab.verbs import VerbRefused

LONGEST_PROBLEM = 1000
"""Maximum characters of a problem; names in a forged log may be of any length."""


class MemoryOptions(StrictModel):
    """Options of the port kind ``memory``, of which there are none."""


Waiting = tuple[Mapping[str, bytes], Callable[[bool], bool]]
"""Commit that waits for its answer: the sections, and whom to tell."""

Heard = Callable[[Twin, str, SimTimeNs, bytes], object]
"""Listener to what devices send: the device, name of its UART or card, when, and the bytes."""


class LoggedStore:
    """Store whose answers are those of the log: each an input, or at once where it was so then.
    ``is_lenient``: of a bench that may commit otherwise than then; where the log has no answer left, a commit
    is done at once."""

    def __init__(self, *, is_lenient: bool) -> None:
        self._answers: dict[str, deque[CommitDone]] = {}
        self._is_lenient = is_lenient
        self.waiting: dict[Twin, deque[Waiting]] = {}
        """Commits that have had no answer yet, of each device."""

    def add(self, logged: Logged) -> None:
        """Take note of an input, if it is an answer."""
        if isinstance(logged.input, CommitDone):
            self._answers.setdefault(logged.device, deque()).append(logged.input)

    def commit(
        self, device: Twin, sections: Mapping[str, bytes], answered: Callable[[bool], bool]
    ) -> bool | None:
        answers = self._answers.get(device.name)
        if not answers and self._is_lenient:
            return True
        if answers and (done := answers.popleft()).at_once:
            return done.durable
        self.waiting.setdefault(device, deque()).append((sections, answered))
        return None

    def came(self, device: Twin) -> None:
        """Note that an answer comes now: of a commit that has not been made, it is at once when it is."""
        if waiting := self.waiting.get(device):
            waiting.popleft()
        elif self._is_lenient and (answers := self._answers.get(device.name)):
            answers[0] = CommitDone(answers[0].durable, at_once=True)


@dataclass(frozen=True)
class LoggedBench:
    """Bench of a log at time 0. ``LogCourse`` tells ``store`` the answers to its commits, and ``stops`` the
    stops of devices by a daemon's guard."""

    config: BenchConfig
    catalogue: Catalogue
    store: LoggedStore
    stops: LoggedStops
    runtime: BenchRuntime


def logged_bench(read: InputLog, *, is_lenient: bool = False) -> LoggedBench:
    """Make the bench of a log. ``is_lenient``: as ``LoggedStore``.

    Raises:
        ConfigError: its configuration does not fit this program.
    """
    config = from_dict(read.config, find_catalogue({"memory": MemoryOptions}))
    catalogue = find_catalogue({"memory": MemoryOptions}, config.profile_path)
    store, stops = LoggedStore(is_lenient=is_lenient), LoggedStops({})
    runtime = bench_runtime(config, catalogue, read.memories, store, BenchHooks(guard=stops))
    return LoggedBench(config, catalogue, store, stops, runtime)


class LogCourse:
    """Bench of a log at time 0, and its way through the log: its groups side by side, each input at its time.

    ``on_problem``: called with the number of an input that the bench cannot take, and why; the default
    raises InputLogError. With it a bench may be another than then: commits that the log does not answer are
    done at once. ``on_refused``: called with the number of a verb that is refused, as it was then. ``bench``:
    the log's, at time 0; None: one is made.

    What was sent is logged with its time on the line, which a paced line reaches later than its group: the
    run ended when the last piece was printed, and not when its last byte would have been on the line.

    Long because the way of the groups and the reloads on it keep the same accounts of them.

    Raises:
        InputLogError: the log's times go back.
        ConfigError: its configuration does not fit this program.
    """

    def __init__(
        self,
        read: InputLog,
        on_problem: Callable[[int, str], None] | None = None,
        on_refused: Callable[[int, VerbRefused], None] = lambda index, refusal: None,
        bench: LoggedBench | None = None,
    ) -> None:
        self.log = read
        self._on_problem, self._on_refused = on_problem or self._refuse, on_refused
        bench = bench or logged_bench(read, is_lenient=on_problem is not None)
        self.config: BenchConfig = bench.config
        self.catalogue = bench.catalogue
        self.stops = bench.stops
        """Stops of devices by a daemon's guard."""
        self._store = bench.store
        self.runtime: BenchRuntime = bench.runtime
        self.listeners: list[Heard] = []
        """Listeners to what devices send, UARTs and cards, up to where the course has gone."""
        for device in self.runtime.devices.values():
            self._listen(device)
        for name, card in self.runtime.cards.items():
            card.listeners.append(partial(self._heard, card.device, address_of(name).part))
        self._order: list[int] = []
        """Numbers of the inputs to come, in the order of their times, behind those that took effect."""
        self._next = 0
        self._of_device = {name: self.runtime.parts.group_of(name) for name in self.runtime.devices}
        self._inputs_ns: dict[Group, deque[SimTimeNs]] = {}
        """Times of inputs to come."""
        self._reloaded = 0
        """Number of reloads that were made."""
        self.extend(0)
        self._missing = Counter[Group]()
        """Numbers of pieces that were sent then, and have not been now."""
        self._last_ns: dict[Group, SimTimeNs] = {}
        """Times of the last pieces."""
        self._pieces = pieces_of_lives(read)
        for name, group in self._of_device.items():
            self._expect((name, 0), group)
        self._ends_ns: dict[Group, SimTimeNs] = {}
        """Ends of groups that have come to them, in ``finish``."""
        self._groups = sorted({*self._of_device.values(), *self._inputs_ns}, key=lambda group: group.id)

    @property
    def end_ns(self) -> SimTimeNs:
        """Time up to which the log describes the run."""
        last_input_ns = self.log.inputs[self._order[-1]].at_ns if self._order else SimTimeNs(0)
        return max(last_input_ns, *self._last_ns.values(), SimTimeNs(self.log.end_ns))

    def extend(self, first: int) -> None:
        """Take the log's inputs from a number on: those that came to it since. Each is of a time to which
        its group has not gone."""
        added = range(first, len(self.log.inputs))
        for logged in self.log.inputs[first:]:
            if isinstance(logged.input, Stopped):
                self.stops.left[logged.device, logged.input.turn] = logged.input
            self._store.add(logged)
        for number in added:
            if self._is_alive(number):
                self._expect_input(number)
        if added:
            left = [*self._order[self._next :], *added]
            self._order[self._next :] = in_order(self.log.inputs, left, self.log.reloads)

    def run_until(self, until_ns: SimTimeNs) -> None:
        """Let the inputs up to and at a time take effect, and all groups go there; never back. Past the log's
        end the bench goes on by itself."""
        while True:
            if place := self._next_reload():
                if place.reload.at_ns > until_ns:
                    break
                self._reload(place.reload, lambda group: SimTimeNs(place.reload.at_ns))
                continue
            if self._next == len(self._order):
                break
            index = self._order[self._next]
            if self.log.inputs[index].at_ns > until_ns:
                break
            self._next += 1
            self._give(index, partial(self._input_or, min(until_ns, self.next_reload_ns())))
        self.runtime.advance(until_ns)

    def finish(self) -> None:
        """Go to the end of the log: each group as far as it is known to have run then."""
        while True:
            if place := self._next_reload():
                self._reload(place.reload, self._limit_ns)
            elif self._next < len(self._order):
                self._next += 1
                self._give(self._order[self._next - 1], self._limit_ns)
            else:
                break
        self._advance(max(self._last_ns.values(), default=SimTimeNs(0)), self._limit_ns)
        for group in self._groups:
            group.advance(self._limit_ns(group))  # one that is there may not have begun

    def note_sent(self, device: str) -> bool:
        """Note that a device sends something, on the way to the end; answers whether it is before the end."""
        group = self._of_device[device]
        if group.now_ns > self._ends_ns.get(group, FOREVER):
            return False
        self._missing[group] -= 1
        if not self._inputs_of(group) and self._missing[group] == 0:
            self._ends_ns[group] = group.now_ns
        return True

    def _listen(self, device: Twin) -> None:
        for port, uart in device.uarts.items():
            uart.listeners.append(partial(self._heard, device, port))

    def _heard(self, device: Twin, port: str, at_ns: SimTimeNs, data: bytes) -> None:
        for listener in self.listeners:
            listener(device, port, at_ns, data)

    def _expect(self, life: "Life", group: Group) -> None:
        """Expect of a group the pieces that a device sent in a life."""
        count, last_ns = self._pieces.get(life, (0, -1))
        if count:
            self._missing[group] += count
            self._last_ns[group] = max(SimTimeNs(last_ns), self._last_ns.get(group, SimTimeNs(0)))

    def _expect_input(self, number: int) -> None:
        logged = self.log.inputs[number]
        with suppress(KeyError):  # of nothing that is there: refused in its turn
            self._inputs_of(self.runtime.parts.group_of(logged.device)).append(logged.at_ns)

    def _life_of(self, device: str) -> int:
        """Number of the life in which a device is now."""
        return sum(device in place.reload.names for place in self.log.reloads[: self._reloaded])

    def _is_alive(self, number: int) -> bool:
        """True if an input is for the device that is there now, and not for a later one of its name."""
        device = owner_of(self.log.inputs[number].device)
        places = [place for place in self.log.reloads if place.inputs <= number]
        return sum(device in place.reload.names for place in places) == self._life_of(device)

    def _next_reload(self) -> ReloadPlace | None:
        """Reload that comes before all other inputs to come; None: there is none."""
        if self._reloaded == len(self.log.reloads):
            return None
        place = self.log.reloads[self._reloaded]
        is_next = self._next == len(self._order) or self._order[self._next] >= place.inputs
        return place if is_next else None

    def next_reload_ns(self) -> SimTimeNs:
        """Time of the next reload; ``FOREVER``: there is none."""
        left = self.log.reloads[self._reloaded :]
        return SimTimeNs(left[0].reload.at_ns) if left else FOREVER

    def _reload(self, reload: Reloaded, limit_ns: Callable[[Group], SimTimeNs]) -> None:
        """Make a reload, as ``hil.live.apply`` made it. ``limit_ns``: how far groups go that end."""
        runtime, at_ns = self.runtime, SimTimeNs(reload.at_ns)
        for name in reload.removed:
            group = self._of_device[name]
            if group.now_ns < (end_ns := limit_ns(group)):
                group.advance(end_ns)
            self._groups.remove(group)
            runtime.remove(name)
            del self._of_device[name]
        self.config = from_dict(dict(reload.config), find_catalogue({"memory": MemoryOptions}))
        begun = []
        log, runtime.log = runtime.log, None  # the listeners here hear it
        for each in reload.begun:
            group, config = runtime.open_group(SimTimeNs(each.opened_ns)), self.config.devices[each.device]
            speed = self.config.speed
            device = make_device(runtime, each.device, config, self.catalogue, {}, each.seed, group, speed)
            device.nvm.update(each.memory)
            begun.append((group, device))
        runtime.log = log
        for group, device in begun:
            runtime.add(group, device)
            self._listen(device)
            self._of_device[device.name] = group
            self._groups.append(group)
        self._groups.sort(key=lambda group: group.id)
        self._reloaded += 1
        for group, device in begun:
            self._expect((device.name, self._life_of(device.name)), group)
            runtime.set_going(device, at_ns)
        for number in self._order[self._next :]:
            if owner_of(self.log.inputs[number].device) in reload.names and self._is_alive(number):
                self._expect_input(number)

    def _refuse(self, index: int, problem: str) -> None:
        said = problem if problem.isprintable() else repr(problem)
        remedy = f"replay it with what wrote it, {self.log.program}"
        raise InputLogError(f"{self.log.where(index)}: {said[:LONGEST_PROBLEM]}; {remedy}")

    def _give(self, index: int, limit_ns: Callable[[Group], SimTimeNs]) -> None:
        """Let an input take effect."""
        logged, runtime = self.log.inputs[index], self.runtime
        if problem := _problem(runtime, logged):
            self._on_problem(index, problem)
            with suppress(KeyError):  # it may be of nothing that is there
                self._inputs_of(runtime.parts.group_of(logged.device)).popleft()
            return
        group = runtime.parts.group_of(logged.device)
        if group.now_ns < logged.at_ns:
            self._advance(SimTimeNs(logged.at_ns + SLICE_NS), limit_ns)
            group.advance(logged.at_ns)
        is_note = isinstance(logged.input, CommitDone) and logged.input.at_once
        if isinstance(logged.input, CommitDone) and not is_note:
            self._store.came(runtime.devices[logged.device])
        if not (is_note or isinstance(logged.input, Stopped)):
            try:
                runtime.apply_input(logged.device, logged.input, logged.at_ns)
            except VerbRefused as refusal:  # it was refused then, too
                self._on_refused(index, refusal)
        self._inputs_of(group).popleft()
        if not self._inputs_of(group) and self._missing[group] <= 0:
            self._ends_ns[group] = group.now_ns

    def _inputs_of(self, group: Group) -> deque[SimTimeNs]:
        return self._inputs_ns.setdefault(group, deque())

    def _advance(self, until_ns: SimTimeNs, limit_ns: Callable[[Group], SimTimeNs]) -> None:
        limits = [(group, limit_ns(group)) for group in self._groups]
        ways = [(group, limit_ns) for group, limit_ns in limits if group.now_ns < limit_ns]
        if ways:
            groups, limits_ns = zip(*ways, strict=True)
            advance_together(self.runtime.core, groups, until_ns, limits_ns)

    def _next_input_ns(self, group: Group) -> SimTimeNs:
        inputs_ns = self._inputs_of(group)
        return inputs_ns[0] if inputs_ns else FOREVER

    def _input_or(self, limit_ns: SimTimeNs, group: Group) -> SimTimeNs:
        return min(self._next_input_ns(group), limit_ns)

    def _limit_ns(self, group: Group) -> SimTimeNs:
        if self._inputs_of(group):
            return self._next_input_ns(group)
        return SimTimeNs(-1) if group in self._ends_ns else self._last_ns.get(group, SimTimeNs(-1))


Life = tuple[str, int]
"""Device's name, and how often another one had been there: reloads begin devices again."""


def pieces_of_lives(log: InputLog) -> dict[Life, tuple[int, int]]:
    """Number of pieces that each device sent in each of its lives, and the time of the last."""
    found: dict[Life, tuple[int, int]] = {}
    lives, places = Counter[str](), deque(log.reloads)
    for number, sent in enumerate(log.sent):
        while places and places[0].sent <= number:
            lives.update(places.popleft().reload.names)
        life = sent.device, lives[sent.device]
        count, last_ns = found.get(life, (0, 0))
        found[life] = count + 1, max(sent.at_ns, last_ns)
    return found


def in_order(inputs: Sequence[Logged], numbers: Iterable[int], reloads: Sequence[ReloadPlace]) -> list[int]:
    """Numbers of inputs as ``in_time``, those before a reload before those behind it."""
    left, ordered = sorted(numbers), list[int]()
    for place in reloads:
        before = [number for number in left if number < place.inputs]
        ordered += in_time(inputs, before)
        left = left[len(before) :]
    return ordered + in_time(inputs, left)


def in_time(inputs: Sequence[Logged], numbers: Iterable[int] | None = None) -> list[int]:
    """Numbers of inputs, by default of all, in the order of their times; those of one target stay in theirs.
    A group that is late has inputs of earlier times after those of others."""
    latest_ns: dict[str, int] = {}
    keys_ns: dict[int, int] = {}
    for number in range(len(inputs)) if numbers is None else sorted(numbers):
        logged = inputs[number]
        latest_ns[logged.device] = max(logged.at_ns, latest_ns.get(logged.device, 0))
        keys_ns[number] = latest_ns[logged.device]
    return sorted(keys_ns, key=keys_ns.__getitem__)


def _problem(runtime: BenchRuntime, logged: Logged) -> str | None:
    if problem := input_problem(runtime, logged.device, logged.input):
        return problem
    reached_ns = runtime.parts.group_of(logged.device).now_ns
    if logged.at_ns < reached_ns:
        return f"time goes back: {logged.at_ns} ns, and {logged.device} was at {reached_ns} ns already"
    return None
