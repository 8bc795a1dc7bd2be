"""A reload: the bench becomes what the configuration says now, and what did not change goes on.

``plan.py`` says what is to be done. Then everything that can fail is done beside the running bench: new
boards and ports are made, memories read. If something fails, it is all taken away again, and nothing has
changed. Then the new takes the old's place in one step, which cannot fail; at last what has gone is closed.
"""

import asyncio
import errno
import logging
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hil.compose import axis_seed, make_device, make_port, serial_port_config, start_sections
from hil.config import ConfigError, DeviceConfig, PortConfig
from hil.live.board_end import BoardEnd
from hil.live.changes import Changed
from hil.live.joint import Joint
from hil.live.reload_plan import Plan, ReloadRefused, make_plan, problems_of
from hil.live.sim_ends import UartEnd
from hil.live.store import StoreError, belongs_to
from hil.sim.device import Device
from hil.sim.group import Group
from hil.vocab.faults import FaultRefused
from hil.vocab.firmware import MAIN, NETWORK
from hil.vocab.ports import Port, PortError, PortHost, port_label

if TYPE_CHECKING:
    from hil.daemon import Daemon

log = logging.getLogger("hil")

COMMIT_S = 5.0
"""How long a reload waits for boards that are writing their memories."""
_POLL_S = 0.01


@dataclass
class Staged:
    """What is made beside the running bench. ``ports``: those that are open already, and new."""

    twins: dict[str, tuple[Group, Device]] = field(default_factory=dict)
    joints: dict[str, Joint[UartEnd]] = field(default_factory=dict)
    real: dict[str, Joint[BoardEnd]] = field(default_factory=dict)
    boards: dict[str, Port] = field(default_factory=dict)
    memories: dict[str, tuple[int, dict[str, bytes], str | None]] = field(default_factory=dict)
    """Of twins that do not go on with their own: commits counted, sections, and a note for the operator."""
    unfit: dict[str, str] = field(default_factory=dict)
    """Of twins whose file on disk is another board's: why it is kept aside."""
    seeds: dict[str, int] = field(default_factory=dict)
    ports: list[Port] = field(default_factory=list)


class Reloader:
    """Of one daemon, one reload at a time."""

    def __init__(self, daemon: "Daemon") -> None:
        self._daemon = daemon
        self._lock = asyncio.Lock()
        self._requested: set[asyncio.Task[None]] = set()
        self._seeds = {name: n for n, name in enumerate(daemon.config.twins)}
        """Which of the bench's seeds a twin's axis has."""
        self.is_open = False
        """The bench serves, and can be reloaded."""

    def request(self) -> None:
        """Somebody wants a reload and no answer: SIGHUP."""
        task = asyncio.get_running_loop().create_task(self._quietly())
        self._requested.add(task)
        task.add_done_callback(self._requested.discard)

    async def _quietly(self) -> None:
        with suppress(ConfigError, ReloadRefused):  # the log has it
            await self.reload()

    async def close(self) -> None:
        """The daemon ends: a reload that has begun is finished, none begins any more."""
        self.is_open = False
        async with self._lock:
            pass

    async def reload(self) -> dict[str, Any]:
        """Names of devices that were kept, restarted, added and removed.

        Raises:
            ConfigError: the file has problems; nothing has changed.
            ReloadRefused: it cannot be done; nothing has changed.
        """
        async with self._lock:
            if not self.is_open:
                raise ReloadRefused("the daemon is starting or ending")
            trouble = ""
            self._daemon.changes.tell_begun()
            try:
                return await self._reload()
            except (ConfigError, ReloadRefused) as error:
                trouble = problems_of(error)
                log.error("reload refused, nothing has changed:\n%s", error)
                raise
            except Exception:  # ours: who asked may not be there to see it
                log.exception("the reload failed")
                raise
            finally:
                self._daemon.changes.tell_ended(trouble)

    async def _reload(self) -> dict[str, Any]:
        daemon = self._daemon
        if daemon.config_file is None:
            raise ReloadRefused("this bench has no configuration file")
        plan = await asyncio.to_thread(
            make_plan, daemon.config_file, daemon.config_folder, daemon.catalogue, daemon.config
        )
        if plan.named("add", "remove", "restart"):
            self._check(plan)
            await self._carry_out(plan)
        words = {"keep": "kept", "restart": "restarted", "add": "added", "remove": "removed"}
        done = {word: plan.named(action) for action, word in words.items()}
        names = [
            f"{word} {', '.join(done[word])}" for word in ("removed", "restarted", "added") if done[word]
        ]
        log.info("reloaded: %s", "; ".join([*names, f"{len(done['kept'])} went on"]))
        return done

    def _check(self, plan: Plan) -> None:
        """What only the running bench knows."""
        daemon = self._daemon
        problems = self._in_use(plan)
        if daemon.bench.log:
            problems.append("the run is being logged (--log), and a log holds one bench from its start")
        core = daemon.bench.core.native
        needed = sum(plan.has_twin(name) for name in plan.named("add", "restart"))
        if needed > (free := core.max_axes - len(daemon.bench.devices)):
            problems.append(
                f"{needed} boards begin, and the core has room for {free} beside those that run: change fewer"
                " at a time, or restart the daemon"
            )
        if problems:
            raise ReloadRefused("\n".join(problems))

    def _in_use(self, plan: Plan) -> list[str]:
        """Devices that somebody needs as they are."""
        return self._daemon.holds.problems(plan.named("remove", "restart"))

    async def _carry_out(self, plan: Plan) -> None:
        staged = Staged()
        try:
            await self._stage(plan, staged)
            await self._until_stored(plan)
            if problems := self._in_use(plan):
                raise ReloadRefused("\n".join(problems))
            self._keep_aside(staged)
        except BaseException:
            for port in staged.ports:
                await port.close()
            for group, _ in staged.twins.values():
                self._daemon.bench.discard(group)
            raise
        ports = self._swap(plan, staged)
        for port in ports:
            await port.close()
        for name, board in staged.boards.items():
            await board.open(self._daemon.places.boards()[name].end.from_board)
        await self._daemon.changes.tell_afterwards(_changed(plan))

    # ---- beside the running bench ----

    async def _stage(self, plan: Plan, staged: Staged) -> None:
        problems = []
        for name in plan.named("restart", "add"):
            try:
                await (self._stage_twin if plan.has_twin(name) else self._stage_real)(plan, staged, name)
            except (PortError, StoreError, MemoryError) as error:
                problems.append(str(error))
        if problems:
            raise ReloadRefused("\n".join(problems))

    async def _stage_twin(self, plan: Plan, staged: Staged, name: str) -> None:
        daemon, config = self._daemon, plan.config.devices[name]
        profile = daemon.catalogue.profiles[config.profile]
        staged.seeds[name] = self._seed_index(plan, staged, name)
        seed = axis_seed(plan.config, staged.seeds[name])
        group = daemon.bench.open_group()
        device = make_device(daemon.bench, name, config, profile, {}, seed, group)
        staged.twins[name] = group, device
        for uart, port_config in ((MAIN, config.port), (NETWORK, config.network)):
            label = port_label(name, uart)
            if port_config is None or self._keeps_port(plan, name, uart):
                continue
            port = make_port(port_config, daemon.port_context(label))
            joint = Joint[UartEnd](label, port)
            await self._open(port, joint, port_config, label)
            staged.ports.append(port)
            staged.joints[label] = joint
        old = daemon.config.twins.get(name)
        if old is None:
            loaded = await asyncio.to_thread(daemon.files.look, name, config.profile)
            content = loaded.content
            staged.memories[name] = content.counter, dict(content.sections), loaded.note
            if loaded.unfit:
                staged.unfit[name] = loaded.unfit
        elif old.profile != config.profile:  # whose board may still write it
            staged.memories[name] = 0, {}, None
            staged.unfit[name] = belongs_to(old.profile, config.profile)

    def _seed_index(self, plan: Plan, staged: Staged, name: str) -> int:
        """A twin keeps its number, a new one gets the first that is free."""
        if name in self._seeds:
            return self._seeds[name]
        taken = {n for other, n in self._seeds.items() if plan.has_twin(other)}
        taken |= set(staged.seeds.values())
        return next(n for n in range(len(taken) + 1) if n not in taken)

    def _keeps_port(self, plan: Plan, name: str, uart: str) -> bool:
        """Whether a changed twin's port stays as it is, with its clients."""
        old = self._daemon.config.twins.get(name)
        return old is not None and _ports(old)[uart] == _ports(plan.config.devices[name])[uart]

    async def _stage_real(self, plan: Plan, staged: Staged, name: str) -> None:
        config, old = plan.config.devices[name], self._daemon.config.real.get(name)
        context = self._daemon.port_context(name)
        staged.boards[name] = make_port(serial_port_config(config), context)
        if old is None or old.port != config.port:
            staged.real[name] = joint = Joint[BoardEnd](name, make_port(config.port, context))
            await self._open(joint.port, joint, config.port, name)
            staged.ports.append(joint.port)

    async def _open(self, port: Port, host: PortHost, config: PortConfig, label: str) -> None:
        """Open a port beside those that run, and if one of them is in its way, say so.

        Raises:
            PortError: it cannot be opened.
        """
        try:
            await port.open(host)
        except PortError as error:
            if getattr(error.__cause__, "errno", None) != errno.EADDRINUSE:
                raise
            end = f":{getattr(config.options, 'port', None)}"
            addresses = self._daemon.addresses()
            holders = [name for name, address in addresses if "://" in address and address.endswith(end)]
            if not holders:
                raise
            holder = f"{label} itself" if label in holders else holders[0]
            raise PortError(
                f"{error}; {holder} has this number, and a reload opens new ports before it closes old ones:"
                " take another number, or restart the daemon"
            ) from error

    async def _until_stored(self, plan: Plan) -> None:
        """A board whose memory is being written has to know what became of it."""
        bench, loop = self._daemon.bench, asyncio.get_running_loop()
        twins = [bench.devices[name] for name in plan.named("remove", "restart") if name in bench.devices]
        until_s = loop.time() + COMMIT_S
        while writing := [device.name for device in twins if device.is_committing]:
            if loop.time() > until_s:
                raise ReloadRefused(f"{', '.join(writing)}: the memory is still being written; try again")
            await asyncio.sleep(_POLL_S)

    # ---- in one step ----

    def _keep_aside(self, staged: Staged) -> None:
        """Put away the files of other boards; all of them, or none.

        Not in a thread: between the old board's last commit and its end nothing else may come.

        Raises:
            ReloadRefused: one cannot be put away.
        """
        files, done = self._daemon.files, []
        try:
            for name, reason in staged.unfit.items():
                kept = files.keep_aside(name, reason)
                if kept:
                    done.append(kept)
                    counter, sections, _ = staged.memories[name]
                    staged.memories[name] = counter, sections, kept.note
        except StoreError as error:
            for kept in done:
                files.put_back(kept)
            raise ReloadRefused(str(error)) from error

    def _swap(self, plan: Plan, staged: Staged) -> list[Port]:
        """Put the new in the old's place; the ports that have gone, still open."""
        daemon = self._daemon
        gone: list[Port] = []
        memories = {
            name: dict(daemon.bench.devices[name].nvm)
            for name in plan.named("restart")
            if name in daemon.bench.devices
        }
        for name in plan.named("remove", "restart"):
            gone += self._take_away(plan, staged, name)
        daemon.configured.config = plan.config
        self._seeds = {n: i for n, i in (self._seeds | staged.seeds).items() if plan.has_twin(n)}
        for name, (group, device) in staged.twins.items():
            if name in staged.memories:
                counter, memories[name], note = staged.memories[name]
                daemon.commits.begin(name, counter)
                if note:
                    daemon.notes[name] = note
                    log.warning("%s: %s", name, note)
            config = plan.config.devices[name]
            device.nvm.update(_memory(config, memories[name], plan.tables[name]))
            daemon.bench.add(group, device)
            self._occupy(staged, name, device)
            daemon.bench.set_going(device)
            self._inject(plan, name)
        for name, board in staged.boards.items():
            if name in staged.real:
                daemon.places.boards()[name] = staged.real[name]
            joint = daemon.places.boards()[name]
            joint.occupy(BoardEnd(joint, board))
            self._inject(plan, name)
        daemon.changes.tell_at_once(_changed(plan))
        return gone

    def _take_away(self, plan: Plan, staged: Staged, name: str) -> list[Port]:
        """What leaves of a device; ports that the new one goes on with are only vacated."""
        daemon = self._daemon
        gone: list[Port] = []
        daemon.faults.forget(name)
        if name in daemon.places.boards():
            joint = daemon.places.boards()[name]
            gone.append(joint.end.line)
            joint.vacate()
            if name in staged.boards and name not in staged.real:
                return gone  # another board at the same port
            del daemon.places.boards()[name]
            if name in staged.real:
                staged.real[name].listeners = joint.listeners
            return [joint.port, *gone]
        daemon.bench.remove(name)
        daemon.notes.pop(name, None)  # of the start that ends here
        if not plan.has_twin(name):
            daemon.commits.failures.pop(name, None)
        for uart in (MAIN, NETWORK):
            label = port_label(name, uart)
            uart_joint = daemon.places.uarts().get(label)
            if uart_joint is None:
                continue
            uart_joint.vacate()
            if plan.has_twin(name) and self._keeps_port(plan, name, uart):
                continue
            gone.append(daemon.places.uarts().pop(label).port)
            if label in staged.joints:
                staged.joints[label].listeners = uart_joint.listeners
        return gone

    def _occupy(self, staged: Staged, name: str, device: Device) -> None:
        daemon, uarts = self._daemon, self._daemon.places.uarts()
        native_usb = daemon.catalogue.profiles[device.profile].usb == "native"
        for uart in device.uarts:
            label = port_label(name, uart)
            if label in staged.joints:
                uarts[label] = staged.joints[label]
            if joint := uarts.get(label):
                joint.occupy(UartEnd(daemon.bench, daemon.lines, joint, device, uart, native_usb=native_usb))

    def _inject(self, plan: Plan, name: str) -> None:
        for fault in plan.config.faults:
            if fault.target.partition(".")[0] == name:
                try:
                    self._daemon.faults.inject(fault.fault, fault.target, fault.model_extra or {})
                except (
                    FaultRefused
                ) as error:  # the configuration's check knows all reasons; if not, it is told
                    log.error("%s: a fault of the configuration is left out: %s", name, error)


def _changed(plan: Plan) -> Changed:
    return Changed(*(tuple(plan.named(action)) for action in ("remove", "restart", "add")))


def _ports(config: DeviceConfig) -> dict[str, object]:
    return {MAIN: config.port, NETWORK: config.network}


def _memory(config: DeviceConfig, stored: dict[str, bytes], table: Mapping[str, bytes]) -> dict[str, bytes]:
    """As ``start_sections``, without looking at a file: ``table`` is what is in it."""
    if config.flash.table in ("stored", "empty"):
        return start_sections(config, stored, Path())
    return stored | dict(table)
