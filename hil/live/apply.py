"""Makes the bench what a plan says: at the start all of it, at a reload what has changed.

First everything that can fail is done beside what runs (``Stage``). If something fails, it is all taken away
again, and nothing has changed. Then the new takes the old's place in one step, which cannot fail; at last
what has gone is closed.
"""

import asyncio
import logging

from hil.compose.build import join_devices
from hil.live.bench_plan import Plan
from hil.live.board_end import BoardEnd
from hil.live.changes import Changed, Changes
from hil.live.commits import Commits
from hil.live.configured import Configured
from hil.live.fault_registry import FaultRegistry
from hil.live.holds import Holds
from hil.live.joint import Joint
from hil.live.lines import Lines
from hil.live.places import Places
from hil.live.refusals import Refused
from hil.live.sim_ends import TapEnd, UartEnd
from hil.live.staging import Stage, Staged
from hil.live.store import NvmStore, StoreError
from hil.sim.bench import BenchRuntime
from hil.vocab.faults import FaultRefused
from hil.vocab.firmware import MAIN, NETWORK
from hil.vocab.ports import Port, port_label

log = logging.getLogger("hil")

COMMIT_S = 5.0
"""How long a reload waits for boards that are writing their memories."""
_POLL_S = 0.01


class Apply:
    """Of one bench. ``notes``: for the operator, by device, about its start."""

    def __init__(
        self,
        bench: BenchRuntime,
        configured: Configured,
        stage: Stage,
        places: Places,
        lines: Lines,
        files: NvmStore,
        commits: Commits,
        faults: FaultRegistry,
        holds: Holds,
        changes: Changes,
        notes: dict[str, str],
    ) -> None:
        self._bench = bench
        self._configured = configured
        self._stage = stage
        self._places = places
        self._lines = lines
        self._files = files
        self._commits = commits
        self._faults = faults
        self._holds = holds
        self._changes = changes
        self._notes = notes

    async def carry_out(self, plan: Plan) -> None:
        """Do what the plan says.

        Raises:
            Refused: it cannot be had; nothing has changed.
        """
        staged = Staged()
        try:
            await self._stage.prepare(plan, staged)
            await self._until_stored(plan)
            if problems := self._holds.problems(plan.named("remove", "restart")):
                raise Refused("\n".join(problems))
            asides = self._keep_aside(plan)
        except BaseException:
            await self._stage.put_away(staged)
            raise
        gone = self._swap(plan, staged, asides)
        for port in gone:
            await port.close()
        for name, line in staged.lines.items():
            await line.open(self._places.boards()[name].end.from_board)
        await self._changes.tell_afterwards(_changed(plan))

    async def _until_stored(self, plan: Plan) -> None:
        """A board whose memory is being written has to know what became of it."""
        devices, loop = self._bench.devices, asyncio.get_running_loop()
        twins = [devices[name] for name in plan.named("remove", "restart") if name in devices]
        until_s = loop.time() + COMMIT_S
        while writing := [device.name for device in twins if device.is_committing]:
            if loop.time() > until_s:
                raise Refused(f"{', '.join(writing)}: the memory is still being written; try again")
            await asyncio.sleep(_POLL_S)

    def _keep_aside(self, plan: Plan) -> dict[str, str]:
        """Put away the files of other boards; all of them, or none. Answers the notes about it, by device.

        Not in a thread: between the old board's last commit and its end nothing else may come.

        Raises:
            Refused: one cannot be put away.
        """
        kept = {}
        try:
            for name, memory in plan.memories.items():
                if memory.unfit and (aside := self._files.keep_aside(name, memory.unfit)):
                    kept[name] = aside
        except StoreError as error:
            for aside in kept.values():
                self._files.put_back(aside)
            raise Refused(str(error)) from error
        return {name: aside.note for name, aside in kept.items()}

    # ---- in one step ----

    def _swap(self, plan: Plan, staged: Staged, asides: dict[str, str]) -> list[Port]:
        """Put the new in the old's place; the ports that have gone, still open."""
        own = {name: dict(device.nvm) for name, device in self._bench.devices.items() if name in plan.tables}
        gone: list[Port] = []
        for name in plan.named("remove", "restart"):
            gone += self._take_away(plan, staged, name)
        self._configured.config = plan.config
        self._stage.done(plan, staged)
        for name, (group, device) in staged.twins.items():
            stored = own.get(name, {})
            if memory := plan.memories.get(name):
                stored = dict(memory.sections)
                self._commits.begin(name, memory.counter)
                if note := asides.get(name, memory.note):
                    self._notes[name] = note
                    log.warning("%s: %s", name, note)
            device.nvm.update(plan.sections(name, stored))
            self._bench.add(group, device)
        if plan.is_start:
            join_devices(self._bench, plan.config)
        self._occupy(plan, staged)
        if not plan.is_start:  # then all are set going together
            for _, device in staged.twins.values():
                self._bench.set_going(device)
        self._inject(plan)
        self._changes.tell_at_once(_changed(plan))
        return gone

    def _take_away(self, plan: Plan, staged: Staged, name: str) -> list[Port]:
        """What leaves of a device; ports that the new one goes on with are only vacated."""
        gone: list[Port] = []
        self._faults.forget(name)
        boards, uarts = self._places.boards(), self._places.uarts()
        if name in boards:
            gone.append(boards[name].end.line)
        else:
            self._bench.remove(name)
            self._notes.pop(name, None)  # of the start that ends here
            if not plan.has_twin(name):
                self._commits.failures.pop(name, None)
        for joint in self._places.of_device(name):
            joint.vacate()
            uart = NETWORK if joint.label == port_label(name, NETWORK) else MAIN
            if self._stage.keeps_port(plan, name, uart):
                continue
            gone.append(joint.port)
            (boards if name in boards else uarts).pop(joint.label)
            if joint.label in staged.joints:
                staged.joints[joint.label].listeners = joint.listeners
        return gone

    def _occupy(self, plan: Plan, staged: Staged) -> None:
        """Put what begins behind its ports."""
        uarts, taps, boards = self._places.uarts(), self._places.taps(), self._places.boards()
        profiles = self._configured.catalogue.profiles
        for name, (_, device) in staged.twins.items():
            native_usb = profiles[device.profile].usb == "native"
            for uart in device.uarts:
                label = port_label(name, uart)
                joint: Joint[UartEnd] | None = staged.joints.get(label) or uarts.get(label)
                if joint:
                    end = UartEnd(self._bench, self._lines, joint, device, uart, native_usb=native_usb)
                    uarts[label] = joint
                    joint.occupy(end)
        for label in self._bench.taps if plan.is_start else ():
            taps[label] = staged.joints[label]
            taps[label].occupy(TapEnd(self._bench, self._lines, taps[label], self._bench.taps[label]))
        for name, line in staged.lines.items():
            boards[name] = staged.joints.get(name) or boards[name]
            boards[name].occupy(BoardEnd(boards[name], line))

    def _inject(self, plan: Plan) -> None:
        """Faults of the configuration, on what begins."""
        begun = {*plan.begun(twins=True), *plan.begun(twins=False)}
        for fault in plan.config.faults:
            place = fault.target.partition(".")[0]
            if place not in begun and not plan.is_start:
                continue
            try:
                self._faults.inject(fault.fault, fault.target, fault.model_extra or {})
            except FaultRefused as error:  # the configuration's check knows all reasons; if not, it is told
                if plan.is_start:
                    raise Refused(f"faults: {error}") from None
                log.error("%s: a fault of the configuration is left out: %s", place, error)


def _changed(plan: Plan) -> Changed:
    return Changed(*(tuple(plan.named(action)) for action in ("remove", "restart", "add")))
