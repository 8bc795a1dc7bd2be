"""Composition of a bench in real time: each part gets what it needs in its constructor."""

import asyncio
import os
from contextlib import AsyncExitStack
from dataclasses import dataclass
from pathlib import Path

from hil.compose.build import empty_bench
from hil.live.apply.bench_plan import BenchPlan
from hil.live.apply.fail_first import Apply
from hil.live.apply.reload import Reloader
from hil.live.apply.staging import Stage
from hil.live.apply.swap import Swap
from hil.live.bridges import Bridges
from hil.live.configured import Configured
from hil.live.core_thread import WallClock, turn
from hil.live.devices.bench_devices import DeviceAxes, Devices
from hil.live.devices.twin_device import TwinHome
from hil.live.fault_registry import FaultRegistry
from hil.live.fork import Fork
from hil.live.guard import BREADCRUMB, StepGuard
from hil.live.lines import PacedLines
from hil.live.memory_commits import Commits
from hil.live.places import Places
from hil.live.reservations import Reservations
from hil.live.run_recording import RunRecording, begin_recording
from hil.live.runs.other_benches import OtherBenches
from hil.live.runs.part import Parts
from hil.live.runs.queue import RunQueue
from hil.live.store import NvmStore
from hil.live.vitals import Vitals
from hil.live.watches import Watches
from hil.sim.bench import BenchHooks, BenchRuntime
from hil.sim.firmware_guard import Guard
from hil.vocab.axis import Axes
from hil.vocab.ports import PortContext

CHECK_INPUTS = "HIL_CHECK_INPUTS"
"""Variable of the environment, for tests: each input has to be such that a replay takes it."""


@dataclass(frozen=True)
class Paths:
    """Files and folders of a bench. ``config``: the configuration, if it has a file; files that it names are
    looked up from ``folder``. ``runtime`` and ``state`` are the bench's own folders; ``port_group``: the
    group that may use its ports; ``is_recorded``: its runs are recorded in ``state`` where there is no
    ``input_log``."""

    folder: Path
    config: Path | None
    runtime: Path
    state: Path
    input_log: Path | None
    port_group: str | None
    is_recorded: bool = True


@dataclass(frozen=True)
class LiveBench:
    """Parts of a bench, for code that composes more; no part gets all of them. ``notes``: for the operator,
    by device."""

    configured: Configured
    sim: BenchRuntime
    devices: Devices
    places: Places
    commits: Commits
    faults: FaultRegistry
    reservations: Reservations
    watches: Watches
    vitals: Vitals
    bridges: Bridges
    apply: Apply
    reloader: Reloader
    notes: dict[str, str]
    recording: RunRecording

    async def go_through(self, fork: Fork) -> None:
        """Go through the recorded run, to the time from which the bench goes on. Raises Refused: it cannot
        take an input of it."""
        config, catalogue = self.configured.config, self.configured.catalogue
        await fork.go_through(self.sim, config, catalogue, self.places, self.commits, self.recording.file)
        self.sim.real_time.is_held = fork.stands


@dataclass(frozen=True)
class LiveRuns:
    """Parts for a bench's runs: its own runs, its parts in those of others, and its axes."""

    queue: RunQueue
    parts: Parts
    others: OtherBenches
    axes: Axes


def make_live(
    stack: AsyncExitStack,
    configured: Configured,
    plan: BenchPlan,
    files: NvmStore,
    at: Paths,
    watch_idle_s: float,
    fork: Fork | None = None,
) -> LiveBench:
    """Make a bench without devices, which stands still; ``plan`` is the first that it will get. ``fork``: the
    recorded run that it goes on from. ``stack`` puts it away.

    Raises:
        StartError: the input log cannot be written.
    """
    loop, config = asyncio.get_running_loop(), configured.config
    if os.environ.get(CHECK_INPUTS):
        from hil.sim.input_check import assert_taken_back

        BenchRuntime.check_input = staticmethod(assert_taken_back)
    forked_from = fork.source if fork else ""
    recording = begin_recording(
        stack, plan, at.state, at.input_log, is_wanted=at.is_recorded, forked_from=forked_from
    )

    def context(label: str) -> PortContext:
        return PortContext(config.bench, label, at.runtime, at.port_group)

    devices, places, bridges, notes = Devices(), Places(), Bridges(context), dict[str, str]()
    stack.push_async_callback(devices.close)
    stack.push_async_callback(places.close)
    guard = StepGuard(at.state / BREADCRUMB, config.speed)
    stack.callback(guard.close)
    lines = PacedLines(loop, lambda: sim.now_ns, config.speed, lambda: sim.real_time.is_held)
    stack.callback(lines.close)
    commits = Commits(files, loop)
    guarded: Guard = guard
    if fork:
        commits.replayed, guarded = fork.store, fork.guard(guard)
    stack.push_async_callback(commits.end)  # its answers to commits are inputs, for the log too
    sim = empty_bench(
        config,
        configured.catalogue,
        commits,
        BenchHooks(lines.turn_over, turn, guarded, places.tell_stopped, recording.writer),
    )
    sim.real_time.is_held = fork is not None  # until it has come to its time
    stack.callback(sim.stop)
    faults, reservations = FaultRegistry(sim, devices), Reservations(devices)
    watches = Watches(sim, config.speed, watch_idle_s)
    stack.callback(watches.stop)
    vitals = Vitals(sim)
    stack.callback(vitals.stop)
    home = TwinHome(sim, places, commits, watches.sampler, notes, config.speed)
    stage = Stage(sim, configured, places, context, home)
    swap = Swap(sim, configured, stage, places, devices, lines, commits, faults, watches, notes, recording)
    apply = Apply(sim, stage, devices, files, reservations, bridges, swap)
    reloader = Reloader(at.config, at.folder, sim, configured, files, reservations, apply)
    return LiveBench(
        configured,
        sim,
        devices,
        places,
        commits,
        faults,
        reservations,
        watches,
        vitals,
        bridges,
        apply,
        reloader,
        notes,
        recording,
    )


def make_runs(stack: AsyncExitStack, live: LiveBench, clock: WallClock) -> LiveRuns:
    """Make the parts for runs of a bench that runs; ``stack`` ends what moves."""
    axes, others = DeviceAxes(live.devices, live.sim), OtherBenches(live.bridges)
    stack.push_async_callback(live.devices.stop)
    queue = RunQueue(axes, live.configured, clock, others, live.reservations)
    stack.push_async_callback(queue.close)
    return LiveRuns(queue, Parts(queue, axes, live.configured, clock, live.reservations), others, axes)
