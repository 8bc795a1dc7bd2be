"""Preparation of a plan beside the bench that runs: devices that do nothing yet, ports that are open."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from hil.compose.build import axis_seed, joined_devices, make_device
from hil.compose.find import make_port, serial_port_config
from hil.config import Catalogue, DeviceConfig, PortConfig
from hil.config.port_kinds import port_path
from hil.drives.drive_control import DriveControl
from hil.drives.drive_link import SharedLines
from hil.drives.real_drive import DrivePace
from hil.live.apply.bench_plan import BenchPlan
from hil.live.configured import Configured
from hil.live.devices.board_device import BoardDevice
from hil.live.devices.drive_device import DriveDevice
from hil.live.devices.twin_device import TwinDevice, TwinHome
from hil.live.places import Places
from hil.live.port_link import PortLink
from hil.live.program_watch import ProgramWatch
from hil.live.refusals import Refused
from hil.net.listeners import ListenRefused
from hil.sim.bench import BenchRuntime
from hil.sim.group import Group
from hil.sim.twin import Twin
from hil.vocab.address import Address
from hil.vocab.device import Device
from hil.vocab.ports import Port, PortContext, PortError

ANSWER_S = 0.2
"""Time for a real drive to answer, beside the delay of its line: a request and its answer take 0.1 s at 9600
baud, if they are long."""


def make_drive(
    name: str, device: DeviceConfig, catalogue: Catalogue, now_ns: Callable[[], int]
) -> DriveControl | None:
    """Make a real drive; None: the device is another real board."""
    profile = catalogue.profiles[device.profile]
    if (kind := catalogue.drive_kind(profile)) is None:
        return None
    pace = DrivePace(
        interval_s=device.poll_interval_ms / 1e3,
        timeout_s=ANSWER_S + device.line_delay_ms / 1e3,
        setpoint_s=1 / device.setpoint_rate_Hz,
    )
    own_map = catalogue.own_map(device, profile)
    made: DriveControl = kind.make(name, kind.address(str(device.at)), device, own_map, pace, now_ns)
    return made


@dataclass
class Staged:
    """Parts for a plan, made beside the bench. ``links``: those of ports that are new and open already,
    vacant, by label; ``lines``: those of real boards, still closed; ``makers``: make the device of each name,
    once its links are occupied; ``seeds``: index of each twin's axis among the bench's seeds."""

    twins: dict[str, tuple[Group, Twin]] = field(default_factory=dict)
    links: dict[str, PortLink[Any]] = field(default_factory=dict)
    lines: dict[str, Port] = field(default_factory=dict)
    makers: dict[str, Callable[[], Device]] = field(default_factory=dict)
    seeds: dict[str, int] = field(default_factory=dict)


@dataclass
class Stage:
    """Prepares plans for a bench. ``context``: gives the surroundings of a label's port."""

    bench: BenchRuntime
    configured: Configured
    places: Places
    context: Callable[[str], PortContext]
    home: TwinHome
    drive_lines: SharedLines = field(default_factory=SharedLines, init=False)
    _seeds: dict[str, int] = field(default_factory=dict, init=False)

    async def prepare(self, plan: BenchPlan, staged: Staged) -> None:
        """Make everything that begins; ``staged`` has what is made already, whatever happens.

        Raises:
            Refused: something cannot be made; all problems.
        """
        problems: list[str] = []
        joined = joined_devices(plan.config) if plan.is_start else {}
        for name in plan.tables:
            try:
                self._make_twin(plan, staged, name, joined.get(name))
            except MemoryError as error:
                problems.append(str(error))
                continue
            for uart, config in plan.config.devices[name].ports_by_uart().items():
                if not self.keeps_port(plan, name, uart):
                    context = self._twin_context(plan, name, uart)
                    await self._open(plan, staged, context, config, problems)
        if plan.is_start:
            for label, port in plan.config.tap_ports().items():
                await self._open(plan, staged, self.context(label), port, problems)
        for name in (each for each in plan.begun() if each not in plan.tables):
            device, speed = plan.config.devices[name], plan.config.speed
            if drive := make_drive(name, device, self.configured.catalogue, lambda: self.bench.now_ns):
                own = (drive, self.drive_lines, device.profile, device.at, speed)
                staged.makers[name] = partial(DriveDevice, *own)
                continue
            staged.makers[name] = partial(self._board, name, device, speed)
            staged.lines[name] = make_port(serial_port_config(device), self.context(name))
            if device.port and not self.keeps_port(plan, name, ""):
                await self._open(plan, staged, self.context(name), device.port, problems)
        if problems:
            raise Refused("\n".join(problems))

    async def put_away(self, staged: Staged) -> None:
        """Put everything away: nothing comes of it."""
        for link in staged.links.values():
            await link.port.close()
        for group in {group.id: group for group, _ in staged.twins.values()}.values():
            self.bench.discard(group)

    def done(self, plan: BenchPlan, staged: Staged) -> None:
        """Note that everything runs."""
        seeds = self._seeds | staged.seeds
        self._seeds = {name: seed for name, seed in seeds.items() if plan.has_twin(name)}

    def keeps_port(self, plan: BenchPlan, name: str, uart: str) -> bool:
        """True if a changed device's port stays as it is, with its clients. ``uart``: empty for the first."""
        old, new = self.configured.config.devices.get(name), plan.config.devices.get(name)
        if plan.is_start or old is None or new is None or (old.at is None) != (new.at is None):
            return False
        return old.port_of(uart) == new.port_of(uart)

    def _make_twin(self, plan: BenchPlan, staged: Staged, name: str, partner: str | None) -> None:
        config = plan.config.devices[name]
        staged.seeds[name] = self._seed_index(plan, staged, name)
        seed = axis_seed(plan.config, staged.seeds[name])
        group = staged.twins[partner][0] if partner else self.bench.open_group()
        catalogue = self.configured.catalogue
        twin = make_device(self.bench, name, config, catalogue, {}, seed, group, plan.config.speed)
        staged.twins[name] = group, twin
        programs = ProgramWatch((config.firmware, config.bootloader))
        board = catalogue.boards[config.profile]
        staged.makers[name] = partial(TwinDevice, self.home, twin, board, programs)

    def _board(self, name: str, config: DeviceConfig, speed: float) -> BoardDevice:
        return BoardDevice(
            self.bench,
            self.places[name],
            (config.profile, self.configured.catalogue.boards[config.profile]),
            config.at,
            speed,
            period_ns=round(1e9 / config.setpoint_rate_Hz),
            delay_ns=round(config.line_delay_ms * 1e6),
        )

    def _seed_index(self, plan: BenchPlan, staged: Staged, name: str) -> int:
        """Index of a twin's seed: it keeps its own, a new one gets the first that is free."""
        if name in self._seeds:
            return self._seeds[name]
        taken = {n for other, n in self._seeds.items() if plan.has_twin(other)}
        taken |= set(staged.seeds.values())
        return next(n for n in range(len(taken) + 1) if n not in taken)

    def _twin_context(self, plan: BenchPlan, name: str, uart: str) -> PortContext:
        device = plan.config.devices[name]
        identity = device.usb_identity(self.configured.catalogue.profiles[device.profile], uart)
        return replace(self.context(str(Address(name, uart))), usb=identity)

    async def _open(
        self,
        plan: BenchPlan,
        staged: Staged,
        context: PortContext,
        config: PortConfig,
        problems: list[str],
    ) -> None:
        """Open a port beside those that run, and if one of them is in its way, say so."""
        label = context.device
        link = PortLink[Any](label, make_port(config, context))
        try:
            await link.port.open(link)
            staged.links[label] = link
        except PortError as error:
            path = (*port_path(plan.config, label), *([error.option] if error.option else []))
            what = self._in_the_way(label, config, error) or str(error)
            problems.append(plan.config.written.placed(path, what))

    def _in_the_way(self, label: str, config: PortConfig, error: PortError) -> str:
        """Words for an address that another port of this bench has; empty if none has it."""
        if not (isinstance(error.__cause__, ListenRefused) and error.__cause__.is_taken):
            return ""
        listen = str(getattr(config.options, "listen", ""))
        end = f":{listen.rpartition(':')[2]}"
        addresses = self.places.addresses()
        holders = [name for name, address in addresses if "://" in address and address.endswith(end)]
        if not holders:
            return ""
        holder = f"{label} itself" if label in holders else holders[0]
        return (
            f"{listen} is in use by {holder}, and a reload opens new ports before it closes old ones; choose"
            " another port, or restart the daemon"
        )
