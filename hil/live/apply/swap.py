"""Puts the new in the old's place in one step, which cannot fail at a reload; a start may still refuse a
fault of the configuration."""

import logging
from dataclasses import dataclass

from hil.compose.build import join_devices
from hil.live.apply.bench_plan import BenchPlan
from hil.live.apply.staging import Stage, Staged
from hil.live.board_end import BoardEnd
from hil.live.configured import Configured
from hil.live.drives.drive_control import DriveControl
from hil.live.fault_registry import FaultRegistry
from hil.live.lines import Lines
from hil.live.memory_commits import Commits
from hil.live.places import Places
from hil.live.port_joint import Joint
from hil.live.refusals import Refused
from hil.live.sim_ends import TapEnd, UartEnd
from hil.live.watches import Watches
from hil.sim.bench import BenchRuntime
from hil.vocab.address import address_of, owner_of
from hil.vocab.faults import FaultRefused
from hil.vocab.ports import Port

log = logging.getLogger("hil")


@dataclass(frozen=True)
class Swap:
    """Swap of a bench's parts for a plan's. ``notes``: for the operator, by device, about its start."""

    bench: BenchRuntime
    configured: Configured
    stage: Stage
    places: Places
    lines: Lines
    commits: Commits
    faults: FaultRegistry
    watches: Watches
    notes: dict[str, str]

    def carry_out(
        self, plan: BenchPlan, staged: Staged, asides: dict[str, str]
    ) -> tuple[list[Port], list[DriveControl]]:
        """Put the new in the old's place; answers the ports that have gone, still open, and real drives that
        are still asked."""
        own = {name: dict(device.nvm) for name, device in self.bench.devices.items() if name in plan.tables}
        gone: list[Port] = []
        leaving: list[DriveControl] = []
        for name in plan.named("remove", "restart"):
            if name in self.places.drives:
                leaving.append(self.places.drives.pop(name))
            else:
                gone += self._take_away(plan, staged, name)
        self.configured.config = plan.config
        self.stage.done(plan, staged)
        for name, (group, device) in staged.twins.items():
            stored = own.get(name, {})
            if memory := plan.memories.get(name):
                stored = dict(memory.content.sections)
                self.commits.begin(name, memory.content.counter)
                if note := asides.get(name, memory.note):
                    self.notes[name] = note
                    log.warning("%s: %s", name, note)
            device.nvm.update(plan.sections(name, stored))
            self.bench.add(group, device)
        if plan.is_start:
            join_devices(self.bench, plan.config, self.configured.catalogue)
        self._occupy(plan, staged)
        if not plan.is_start:  # then all are set going together
            for _, device in staged.twins.values():
                self.bench.set_going(device)
        self._inject(plan)
        self.watches.exchanged(plan.named("remove", "restart", "add"))
        return gone, leaving

    def _take_away(self, plan: BenchPlan, staged: Staged, name: str) -> list[Port]:
        """Remove a device; answers its ports that have gone. Ports that the new one keeps are vacated."""
        gone: list[Port] = []
        self.faults.forget(name)
        boards, uarts = self.places.boards, self.places.uarts
        if name in boards:
            gone.append(boards[name].end.line)
        else:
            self.bench.remove(name)
            self.notes.pop(name, None)  # of the start that ends here
            if not plan.has_twin(name):
                self.commits.failures.pop(name, None)
        for joint in self.places.of_device(name):
            joint.vacate()
            if self.stage.keeps_port(plan, name, address_of(joint.label).part):
                continue
            gone.append(joint.port)
            (boards if name in boards else uarts).pop(joint.label)
            if joint.label in staged.joints:
                staged.joints[joint.label].listeners = joint.listeners
        return gone

    def _occupy(self, plan: BenchPlan, staged: Staged) -> None:
        uarts, taps, boards = self.places.uarts, self.places.taps, self.places.boards
        profiles = self.configured.catalogue.profiles
        for name, (_, device) in staged.twins.items():
            native_usb = profiles[device.profile].usb == "native"
            for uart in device.uarts:
                label = device.uarts.label(name, uart)
                joint: Joint[UartEnd] | None = staged.joints.get(label) or uarts.get(label)
                if joint:
                    end = UartEnd(
                        self.bench,
                        self.lines,
                        joint,
                        device,
                        device.uarts.short(uart),
                        native_usb=native_usb,
                    )
                    uarts[label] = joint
                    joint.occupy(end)
        for label in self.bench.taps if plan.is_start else ():
            taps[label] = staged.joints[label]
            taps[label].occupy(TapEnd(self.bench, self.lines, taps[label], self.bench.taps[label]))
        self.places.drives.update(staged.drives)
        for name, line in staged.lines.items():
            boards[name] = staged.joints.get(name) or boards[name]
            boards[name].occupy(BoardEnd(boards[name], line))

    def _inject(self, plan: BenchPlan) -> None:
        """Inject the configuration's faults on devices that begin."""
        begun = {*plan.begun(twins=True), *plan.begun(twins=False)}
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
