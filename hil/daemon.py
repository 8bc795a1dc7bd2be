"""One bench as a process: read, compose, serve, stop."""

import asyncio
import signal
from collections.abc import Callable
from contextlib import AsyncExitStack
from pathlib import Path

from hil import __version__
from hil.compose import empty_bench, find_catalogue
from hil.config import BenchConfig, Catalogue
from hil.host import signals
from hil.host.notify import Notifier
from hil.host.paths import CONTROL_SOCKET
from hil.host.service import Service, has_terminal
from hil.live.apply import Apply
from hil.live.bench_plan import plan_start
from hil.live.bridges import Bridges
from hil.live.captures import Captures
from hil.live.changes import Changes
from hil.live.commits import Commits
from hil.live.configured import Configured
from hil.live.core_thread import start_core, turn
from hil.live.fault_registry import FaultRegistry
from hil.live.folders import folders
from hil.live.guard import BREADCRUMB, StepGuard, note_hung
from hil.live.holds import Holds
from hil.live.lines import Lines
from hil.live.log_file import LogFile, as_simulated
from hil.live.places import Places
from hil.live.refusals import Refused, StartError
from hil.live.reload import Reloader
from hil.live.runs.queue import Runs
from hil.live.staging import Stage
from hil.live.store import NvmStore
from hil.live.vitals import Vitals
from hil.live.watches import Watches
from hil.operations.bridge_host import Host
from hil.operations.control_socket import ControlServer
from hil.operations.control_verbs import WATCH_IDLE_S
from hil.sim.around import Around
from hil.sim.bench import BenchRuntime
from hil.sim.input_log import InputLogWriter
from hil.vocab.bridges import BridgeError
from hil.vocab.ports import PortContext


class Daemon:
    """One bench. ``run`` starts it, and returns after ``stop`` or a signal, with everything put away."""

    def __init__(
        self,
        config: BenchConfig,
        *,
        config_folder: Path,
        config_file: Path | None = None,
        runtime_base: Path,
        state_base: Path,
        input_log: Path | None = None,
        require_rt: bool = False,
        port_group: str | None = None,
        notifier: Notifier | None = None,
    ) -> None:
        self.configured = Configured(config, find_catalogue())
        self.runtime_dir = runtime_base / config.bench
        self.state_dir = state_base / config.bench
        self.config_folder = config_folder
        self.config_file = config_file
        self._input_log = input_log
        self._require_rt = require_rt
        self._port_group = port_group
        self._notifier = notifier or Notifier({}, 0)
        self._stop = asyncio.Event()

    async def run(self, started: Callable[["Daemon"], None]) -> None:
        """Start, say so, and serve until told to stop.

        Raises:
            StartError: something is missing; nothing was left behind.
        """
        async with AsyncExitStack() as stack:
            try:
                await self._start(stack)
            except (Refused, BridgeError) as error:
                raise StartError(str(error)) from None
            started(self)
            await self._stop.wait()

    @property
    def config(self) -> BenchConfig:
        return self.configured.config

    @property
    def catalogue(self) -> Catalogue:
        return self.configured.catalogue

    def stop(self) -> None:
        """End ``run``."""
        self._stop.set()

    async def _start(self, stack: AsyncExitStack) -> None:
        """All of it; ``stack`` puts it away, in the other order."""
        loop, config = asyncio.get_running_loop(), self.configured.config
        calls = {signal.SIGINT: self.stop, signal.SIGTERM: self.stop}
        is_reload = signal.getsignal(signal.SIGHUP) != signal.SIG_IGN  # as under nohup
        if is_reload:
            calls[signal.SIGHUP] = self.stop if has_terminal() else lambda: None
        signals.answer(loop, calls)  # first: one that comes early leaves nothing behind either
        stack.callback(signals.ignore, loop, calls)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGHUP})
        stack.enter_context(folders(config.bench, self.state_dir, self.runtime_dir))
        control = ControlServer(self, self.runtime_dir / CONTROL_SOCKET)
        await control.open()
        stack.push_async_callback(control.close)
        files = NvmStore(self.state_dir)
        stack.push_async_callback(loop.run_in_executor, None, files.close)
        plan = plan_start(config, self.config_folder, files)
        log = None
        if self._input_log:
            log_file = LogFile(self._input_log, loop)
            stack.callback(log_file.close)
            memories = {name: plan.sections(name, plan.memories[name].sections) for name in plan.tables}
            log = InputLogWriter(log_file, f"hil {__version__}", as_simulated(config), memories)
        self.places, self.changes, self.notes = Places(), Changes(), dict[str, str]()
        stack.push_async_callback(self.places.close)
        guard = StepGuard(self.state_dir / BREADCRUMB, config.speed)
        stack.callback(guard.close)
        self.lines = Lines(loop, lambda: self.bench.now_ns, config.speed)
        stack.callback(self.lines.close)
        self.commits = Commits(files, loop)
        stack.push_async_callback(self.commits.end)  # its answers to commits are inputs, for the log too
        around = Around(self.lines.turn_over, turn, guard, self.places.tell_stopped, log)
        self.bench: BenchRuntime = empty_bench(config, self.commits, around)
        stack.callback(self.bench.stop)
        self.holds, self.faults = Holds(self.places), FaultRegistry(self.bench, self.places)
        self.watches = Watches(self.bench, self.changes, config.speed, WATCH_IDLE_S)
        stack.callback(self.watches.stop)
        context = lambda label: PortContext(config.bench, label, self.runtime_dir, self._port_group)  # noqa: E731
        stage = Stage(self.bench, self.configured, self.places, context)
        apply = Apply(
            self.bench,
            self.configured,
            stage,
            self.places,
            self.lines,
            files,
            self.commits,
            self.faults,
            self.holds,
            self.changes,
            self.notes,
        )
        self.reloader = Reloader(
            self.config_file,
            self.config_folder,
            self.bench,
            self.configured,
            files,
            self.holds,
            apply,
            self.changes,
        )
        await apply.carry_out(plan)
        note_hung(self.state_dir / BREADCRUMB, self.notes)
        self.clock, self.grant = start_core(self.bench, config, require_rt=self._require_rt)
        loop.add_reader(self.bench.core.event_fd, self.bench.drive.service)
        stack.callback(loop.remove_reader, self.bench.core.event_fd)
        self.captures = Captures(self.bench, self.places, self.clock)
        self.vitals: Vitals = Vitals(self.bench)
        self.vitals.start()
        stack.callback(self.vitals.stop)
        self.bridges = Bridges(self.changes)
        self.host = Host(self)
        self.runs = Runs(self)
        stack.push_async_callback(self.runs.close)
        stack.push_async_callback(self.bridges.close)
        await self.bridges.open(config.bridges, self.host)
        stack.push_async_callback(control.close)
        stack.push_async_callback(self.reloader.close)
        self.reloader.is_open = True
        if is_reload and not has_terminal():
            signals.answer(loop, {signal.SIGHUP: self.reloader.request})
        self.service = Service(self, self._notifier)
        stack.callback(self.service.stop)
        self.service.start()
