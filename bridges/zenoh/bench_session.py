"""Session of a bench: opened, its keys declared, put away. Zenoh's threads only fill an inbox."""

import asyncio
import logging
import secrets
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from datetime import UTC, datetime
from functools import partial
from time import thread_time
from typing import Any

import zenoh

from bridges.zenoh.command_handler import CommandHandler, Work
from bridges.zenoh.documents import OURS
from bridges.zenoh.gate import Gate
from bridges.zenoh.inbox import Inbox
from bridges.zenoh.keys import COMMAND, KEYS, QUERY, Key, expression, prefix
from bridges.zenoh.not_joined import why_not_joined
from bridges.zenoh.options import Options
from bridges.zenoh.others import Others
from bridges.zenoh.publications import Publications
from bridges.zenoh.readings import Readings
from bridges.zenoh.refused_addresses import first_refused
from bridges.zenoh.sender import Senders
from bridges.zenoh.site_folder import SiteFolder, opened_folder
from bridges.zenoh.site_gate import SiteGate
from bridges.zenoh.users import SecurityError, read_users, refuse_endless
from bridges.zenoh.zenoh_config import opened, password_file, session_config, site_options, site_subjects
from hil.net.listeners import LISTEN
from hil.vocab.address import owner_of
from hil.vocab.bridge_protocol import Answered, BenchGone, BenchProblem, BridgeError
from hil.vocab.desk_protocol import Desk, Source

log = logging.getLogger("hil")

_NOBODY_THERE = "Unable to connect"
LOOK_S = 1.0
"""Time between two looks whether the files of a site were replaced."""
AGAIN_S = 1.0
"""Time between two looks whether the bench's name is free."""
_ANSWERED = {QUERY, COMMAND}


class Joined:
    """Parts of the bridge while a session is open. ``number``: of this bench among others of its name, by
    chance if empty; ``cpu_s``: time that readings have taken."""

    def __init__(
        self,
        session: zenoh.Session,
        gate: Gate | None,
        desk: Desk,
        options: Options,
        senders: Senders,
        work: Work,
        number: str = "",
        cpu_s: Callable[[], float] = thread_time,
    ) -> None:
        here = desk.describe()
        self.session, self.gate = session, gate
        self.others = Others(session, here, gate)
        self.name = OneName(session, here.bench, number)
        self.publications = Publications(session, desk, options)
        self.readings = Readings(desk, self.publications, senders.answers, work.begin, cpu_s)
        self.commands = CommandHandler(
            desk, gate, self.publications, self.readings, senders.acks, work, lambda: self.name.clash
        )
        names = gate.names if gate else ()
        self.inbox = Inbox(senders.acks, senders.answers, self.commands.handle, names, cpu_s)
        self._devices = here.devices
        self._live_prefix = f"{prefix(here.bench)}/@live"
        self._entities: list[Any] = [
            *self.name.entities,
            *(self._taking(key, expression(here.bench, key.pattern)) for key in KEYS if COMMAND in key.way),
            *(
                self._answering(key, expression(here.bench, key.pattern))
                for key in KEYS
                if _ANSWERED & {*key.way}
            ),
            *(self._live(name) for name in ("daemon", *(f"segment/{name}" for name in here.segments))),
        ]
        self._tokens = {name: self._live(f"axis/{name}") for name in here.devices}
        self.publications.start()

    def _taking(self, key: Key, on: str) -> Any:
        """Take the puts that are commands, and no others: what another tells is not answered."""
        took = zenoh.handlers.Callback(partial(self.inbox.on_put, key.pattern), indirect=False)
        return self.session.declare_subscriber(on, took, allowed_origin=zenoh.Locality.REMOTE)

    def _answering(self, key: Key, on: str) -> Any:
        asked = zenoh.handlers.Callback(partial(self.inbox.on_query, key.pattern), indirect=False)
        return self.session.declare_queryable(on, asked, complete=True)

    def _live(self, name: str) -> Any:
        return self.session.liveliness().declare_token(f"{self._live_prefix}/{name}")

    def devices_changed(self, names: Collection[str]) -> None:
        for address in [each for each in self._tokens if owner_of(each) in names]:
            self._tokens.pop(address).undeclare()
        self.publications.devices_changed(names)
        self.readings.refresh()
        begun = [address for address in self._devices if owner_of(address) in names]
        self._tokens |= {address: self._live(f"axis/{address}") for address in begun}

    def undeclare(self) -> None:
        for entity in reversed([*self._entities, *self._tokens.values()]):
            entity.undeclare()


class ZenohBridge:
    """Zenoh bridge, a ``hil.vocab.bridge_protocol.Bridge``."""

    def __init__(self, options: Options, desk: Desk) -> None:
        self._options = options
        self._desk = desk
        self._bench = desk.describe().bench
        self._work = Work()
        self._senders: Senders | None = None
        self._joined: Joined | None = None
        self._is_closed = False
        self._clash: BenchProblem | None = None
        """Clash that keeps this bench from joining."""
        self._site: SiteFolder | None = None
        self._why = ""
        """Reason in the log why no router lets this bench in."""

    async def open(self) -> None:
        self._senders = Senders()
        try:
            if self._options.site:
                self._site = opened_folder(self._options.site)
                self._site.member(self._bench)
                self._options = site_options(self._options, self._site)
                self._work.begin(self._watch(self._site, self._senders))
            opened = await self._open_first()
        except SecurityError as error:
            raise BridgeError(str(error)) from None
        except zenoh.ZError as error:
            if refused := await first_refused(self._options.listen):
                raise BridgeError(str(refused[1]), (*LISTEN, refused[0])) from None
            if self._options.listen or not str(error).startswith(_NOBODY_THERE):
                raise BridgeError(
                    f"{first_line(error)}; choose another address, or [] for none", LISTEN
                ) from None
            await self._say_why()
            self._work.begin(self._join(self._senders))
        else:
            if opened is None:
                self._work.begin(self._join(self._senders))
                return
            self._joined = Joined(*opened, self._desk, self._options, self._senders, self._work)

    async def _open_session(self) -> tuple[zenoh.Session, Gate | None]:
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(None, open_session, self._options, self._bench, self._site)

    @property
    def _where(self) -> str:
        return ", ".join(self._options.connect or self._options.listen)

    async def _open_first(self) -> tuple[zenoh.Session, Gate | None] | None:
        """Open a session, if no other bench of this name is joined there. None: there is one."""
        opened = await self._open_session()
        if self._options.listen or not self._options.connect:
            return opened  # it is the router itself, and joins others later
        loop = asyncio.get_running_loop()
        if not await loop.run_in_executor(None, is_taken, opened[0], self._bench):
            if self._clash:
                log.info("zenoh: the other bench %s has gone", self._bench)
            self._clash = None
            return opened
        await loop.run_in_executor(None, opened[0].close)
        if self._clash is None:
            self._clash = stands_aside(self._bench, self._where)
            log.error("zenoh: %s; %s", self._clash.what, self._clash.remedy)
        return None

    async def _say_why(self) -> None:
        """Say in the log why no router lets this bench in, when that is something else than before."""
        ask = partial(why_not_joined, self._options, self._bench, self._site is not None)
        why = await asyncio.get_running_loop().run_in_executor(None, ask)
        if why != self._why:
            log.warning("zenoh: not joined, tried again each second: %s", why)
        self._why = why

    async def _join(self, senders: Senders) -> None:
        """Join the router that was away at the start."""
        while self._joined is None:
            try:
                opened = await self._open_first()
            except zenoh.ZError:
                await self._say_why()
                continue  # it took a second
            if opened is None:
                await asyncio.sleep(AGAIN_S)
                continue
            if self._is_closed:
                await asyncio.get_running_loop().run_in_executor(None, opened[0].close)
                return
            self._joined = Joined(*opened, self._desk, self._options, senders, self._work)
            log.info("zenoh: joined %s", self._where)

    async def _watch(self, site: SiteFolder, senders: Senders) -> None:
        """Take new lists and certificates of the site as they are copied into its folder."""
        taken, allowed = site.version, site_subjects(site.list, self._bench)
        self._compare_labels(site)
        while True:
            await asyncio.sleep(LOOK_S)
            try:
                site.refresh(datetime.now(UTC))
                if site.version == taken:
                    continue
                taken = site.version
                site.member(self._bench)
                log.info("zenoh: took list %d of the site %s", site.list.number, site.list.site)
                self._compare_labels(site)
            except (SecurityError, OSError) as error:
                log.error("zenoh: %s", error)
            joined = self._joined
            if joined is None or not isinstance(joined.gate, SiteGate):
                continue
            joined.gate.list_changed()
            # Zenoh's access control of a door of its own is fixed while it is open.
            if self._options.listen and (now := site_subjects(site.list, self._bench)) != allowed:
                allowed = now
                await self._put_away()
                self._work.begin(self._join(senders))

    def _compare_labels(self, site: SiteFolder) -> None:
        """Say in the log where the configuration has other labels than the site, by which roles go."""
        configured = self._desk.ask(OURS, "about", "", {})["labels"]
        for name, value in site.member(self._bench).labels.items():
            if configured.get(name, value) != value:
                log.warning(
                    "zenoh: the site labels this bench %s=%s, its configuration %s=%s; roles go by"
                    " the site's",
                    *(name, value, name, configured[name]),
                )

    async def devices_changed(self, names: Collection[str]) -> None:
        if self._joined is None:
            return
        try:
            self._joined.devices_changed(names)
        except zenoh.ZError as error:
            raise BridgeError(first_line(error)) from None

    async def _put_away(self) -> None:
        """Close the session, for another; what waits for a motion's end loses its answer."""
        if joined := self._joined:
            self._joined = None
            joined.inbox.close()
            await joined.publications.stop()
            await _end(joined)

    async def close(self) -> None:
        self._is_closed = True
        joined = self._joined
        if joined:
            joined.inbox.close()
            await joined.publications.stop()
        await self._work.close()
        if self._senders:
            await asyncio.get_running_loop().run_in_executor(None, self._senders.close)
        if joined and self._joined:
            self._joined = None
            await _end(joined)

    async def ask_bench(
        self, source: Source, bench: str, rest: str, given: Mapping[str, Any], timeout_s: float
    ) -> Answered:
        if self._joined is None:
            raise BenchGone(f"the bench {bench} cannot be reached: this one is not joined yet")
        return await self._joined.others.ask(source, bench, rest, given, timeout_s)

    async def stop_others(self, source: Source, how: str, timeout_s: float) -> Sequence[dict[str, Any]]:
        return await self._joined.others.stop_others(source, how, timeout_s) if self._joined else ()

    async def benches(self) -> Sequence[str]:
        return await self._joined.others.benches() if self._joined else []

    def name_clash(self) -> BenchProblem | None:
        return self._joined.name.clash if self._joined else self._clash

    def status(self) -> Mapping[str, Any]:
        counters = {"links": 0, "commands": 0, "rejected": 0, "busy": 0, "dropped": 0}
        if self._senders:
            counters["dropped"] = self._senders.dropped
        if joined := self._joined:
            counters["links"] = len(list(joined.session.info.links()))
            counters["commands"] = joined.commands.carried_out
            counters["rejected"] = joined.publications.rejections
            counters["busy"] = joined.inbox.refused
            counters["dropped"] += joined.inbox.dropped + joined.publications.dropped
        return {
            "root": prefix(self._bench),
            "listen": list(self._options.listen),
            "connect": list(self._options.connect),
            **counters,
            "waiting": self._work.waiting,
            "insecure": self._options.insecure,
        }


async def _end(joined: Joined) -> None:
    joined.undeclare()
    await asyncio.get_running_loop().run_in_executor(None, joined.session.close)


def first_line(error: Exception) -> str:
    """First line of a zenoh error, which ends in a path of its sources."""
    return str(error).partition(" at /")[0].partition("\n")[0]


def open_session(
    options: Options, bench: str, site: SiteFolder | None = None
) -> tuple[zenoh.Session, Gate | None]:
    """Open a daemon's session; answers it with the gate that checks its commands, None where there are no
    users and everybody may do all. ``site``: what ``options.site`` has; ``options`` are then those of
    ``site_options``.

    Raises:
        SecurityError: strangers could reach the bench, or the users' file is wrong.
        zenoh.ZError: an address is taken, a certificate cannot be read.
    """
    if site:
        gate = SiteGate(site, bench, time.time_ns())
        return opened(session_config(options, bench, (), "", site.list)), gate
    users = read_users(options.users) if options.users else []
    for path in (options.tls.ca, options.tls.certificate, options.tls.key) if options.tls else ():
        try:
            refuse_endless(path)
            path.open("rb").close()  # zenoh would only say that nobody is there
        except OSError as error:
            why = f"cannot be read: {error.strerror}"
            raise SecurityError(f"tls: {path} {why}; `hil zenoh keys` makes such files") from None
    with password_file(users) as dictionary:
        entries = session_config(options, bench, users, dictionary)
        return opened(entries), Gate(users, time.time_ns()) if users else None


ASK_S = 1.0
_REMEDY = "end one of them, or give it another name (`bench:`)"


def is_taken(session: zenoh.Session, bench: str) -> bool:
    """True if a bench of this name is joined; asked before this one is."""
    tokens = session.liveliness().get(f"{prefix(bench)}/@live/daemon", timeout=ASK_S)
    return any(token.ok for token in tokens)


def stands_aside(bench: str, where: str) -> BenchProblem:
    """Clash of a bench that does not join, as it came second."""
    what = f"another bench {bench} is joined at {where}; this one is not, and tries again each second"
    return BenchProblem(bench, what, _REMEDY)


class OneName:
    """Watch for others of a bench's name. Each bench has a token with a number of its own: tokens of one key
    cannot be told apart."""

    def __init__(self, session: zenoh.Session, bench: str, number: str = "") -> None:
        self._bench = bench
        head = f"{prefix(bench)}/@one"
        self._own = f"{head}/{number or secrets.token_hex(8)}"
        self._others: set[str] = set()
        live = session.liveliness()
        noted = zenoh.handlers.Callback(self._note, indirect=False)
        self.entities: list[Any] = [
            live.declare_token(self._own),
            live.declare_subscriber(f"{head}/*", noted, history=True),
        ]

    def _note(self, sample: zenoh.Sample) -> None:
        """Note a token, in a thread of zenoh."""
        key = str(sample.key_expr)
        if sample.kind == zenoh.SampleKind.DELETE:
            self._others.discard(key)
        elif key != self._own:
            self._others.add(key)

    @property
    def clash(self) -> BenchProblem | None:
        """Clash with others that are joined too; None: there are none."""
        if not (count := len(self._others)):
            return None
        what = f"{count} more joined as {self._bench}: commands, except stop, are refused here"
        return BenchProblem(self._bench, what, _REMEDY)
