"""Puts the new in the old's place in one step, which cannot fail at a reload; a start may still refuse a
fault of the configuration."""

import logging
from dataclasses import dataclass

from hil.compose.build import axis_seed, join_devices
from hil.compose.simulated_config import as_simulated
from hil.live.apply.bench_plan import BenchPlan
from hil.live.apply.staging import Stage, Staged
from hil.live.board_backend import BoardBackend
from hil.live.configured import Configured
from hil.live.devices.bench_devices import Devices
from hil.live.fault_registry import FaultRegistry
from hil.live.lines import PacedLines
from hil.live.memory_commits import Commits
from hil.live.places import Places
from hil.live.refusals import Refused
from hil.live.run_recording import RunRecording
from hil.live.sim_backends import TapBackend, UartBackend
from hil.live.watches import Watches
from hil.sim.bench import BenchRuntime
from hil.sim.reloads import Begun, Reloaded
from hil.vocab.address import address_of, owner_of
from hil.vocab.device import Device
from hil.vocab.faults import FaultRefused
from hil.vocab.ports import Port
from hil.vocab.time import SimTimeNs

log = logging.getLogger("hil")


@dataclass(frozen=True)
class Swap:
    """Swap of a bench's parts for a plan's. ``notes``: for the operator, by device, about its start."""

    bench: BenchRuntime
    configured: Configured
    stage: Stage
    places: Places
    devices: Devices
    lines: PacedLines
    commits: Commits
    faults: FaultRegistry
    watches: Watches
    notes: dict[str, str]
    recording: RunRecording

    def carry_out(
        self, plan: BenchPlan, staged: Staged, asides: dict[str, str]
    ) -> tuple[list[Port], list[Device]]:
        """Put the new in the old's place; answers the ports that have gone, still open, and devices that
        are to be closed."""
        own = {name: dict(device.nvm) for name, device in self.bench.devices.items() if name in plan.tables}
        twins = set(self.bench.devices)
        gone: list[Port] = []
        leaving: list[Device] = []
        for name in plan.named("remove", "restart"):
            leaving.append(self.devices.pop(name))
            gone += self._take_away(plan, staged, leaving[-1])
        self.configured.config = plan.config
        self.stage.done(plan, staged)
        for name, (_, device) in staged.twins.items():
            stored = own.get(name, {})
            if memory := plan.memories.get(name):
                stored = dict(memory.content.sections)
                self.commits.begin(name, memory.content.counter)
                if note := asides.get(name, memory.note):
                    self.notes[name] = note
                    log.warning("%s: %s", name, note)
            device.nvm.update(plan.sections(name, stored))
        now_ns = self.bench.now_ns
        if not plan.is_start:
            self._record(plan, staged, [each.name for each in leaving if each.name in twins], now_ns)
        for group, device in staged.twins.values():
            self.bench.add(group, device)
        if plan.is_start:
            join_devices(self.bench, plan.config, self.configured.catalogue)
        self._occupy(plan, staged)
        self._add(plan, staged)
        if not plan.is_start:  # then all are set going together
            for _, device in staged.twins.values():
                self.bench.set_going(device, now_ns)
        self._inject(plan)
        self.watches.exchanged(plan.named("remove", "restart", "add"))
        return gone, leaving

    def _record(self, plan: BenchPlan, staged: Staged, left: list[str], now_ns: SimTimeNs) -> None:
        """Put the reload into the recording of the run. ``left``: twins that were removed."""
        begun = (
            Begun(name, axis_seed(plan.config, staged.seeds[name]), group.now_ns, dict(device.nvm))
            for name, (group, device) in staged.twins.items()
        )
        self.recording.reload(Reloaded(now_ns, as_simulated(plan.config), tuple(left), tuple(begun)))

    def _take_away(self, plan: BenchPlan, staged: Staged, device: Device) -> list[Port]:
        """Remove a device; answers its ports that have gone. Ports that the new one keeps are vacated."""
        gone: list[Port] = []
        name = device.name
        self.faults.forget(name)
        device.leave()
        self.notes.pop(name, None)  # of the start that ends here
        if not plan.has_twin(name):
            self.commits.failures.pop(name, None)
        for link in self.places.of(name):
            link.vacate()
            if self.stage.keeps_port(plan, name, address_of(link.label).part):
                continue
            gone.append(link.port)
            del self.places[link.label]
            if link.label in staged.links:
                staged.links[link.label].listeners = link.listeners
        return gone

    def _occupy(self, plan: BenchPlan, staged: Staged) -> None:
        places = self.places
        profiles = self.configured.catalogue.profiles
        for name, (_, device) in staged.twins.items():
            native_usb = profiles[device.profile].usb == "native"
            for uart in device.uarts:
                label = device.uarts.label(name, uart)
                if link := staged.links.get(label) or places.get(label):
                    end = UartBackend(
                        self.bench,
                        self.lines,
                        link,
                        device,
                        device.uarts.short(uart),
                        native_usb=native_usb,
                    )
                    places[label] = link
                    link.occupy(end)
        for label in self.bench.taps if plan.is_start else ():
            places[label] = link = staged.links[label]
            link.occupy(TapBackend(self.bench, self.lines, link, self.bench.taps[label]))
        for name, line in staged.lines.items():
            places[name] = link = staged.links.get(name) or places[name]
            link.occupy(BoardBackend(link, line))

    def _add(self, plan: BenchPlan, staged: Staged) -> None:
        """Add what begins to the bench's devices, each with all that its profile says."""
        for name in plan.begun():
            self.devices[name] = staged.makers[name]()
        self.devices.order(plan.config.devices)

    def _inject(self, plan: BenchPlan) -> None:
        """Inject the configuration's faults on devices that begin."""
        begun = plan.begun()
        for fault in plan.config.faults:
            place = owner_of(fault.target)
            if place not in begun and not plan.is_start:
                continue
            try:
                self.faults.inject(fault.fault, fault.target, fault.model_extra or {})
            except FaultRefused as error:  # the configuration's check knows all reasons; if not, it is told
                if plan.is_start:
                    raise Refused(f"faults: {error}") from None
                log.error("%s: a fault of the configuration is left out: %s", place, error)
