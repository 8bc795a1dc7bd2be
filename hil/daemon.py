"""One bench as a process: read, compose, serve, stop.

May import: hil.compose, hil.config, hil.host, hil.live, hil.operations, hil.vocab, the standard library.
"""

import asyncio
import logging
import signal
from collections.abc import Callable
from contextlib import AsyncExitStack
from dataclasses import dataclass
from pathlib import Path

from hil.compose import find_catalogue
from hil.compose.lanes import LanesRefused
from hil.config import BenchConfig
from hil.host import signals
from hil.host.notify import Notifier
from hil.host.real_time import Grant
from hil.host.service import Service, has_terminal
from hil.live.apply.bench_plan import plan_start
from hil.live.bridges import closed_doors
from hil.live.configured import Configured
from hil.live.core_thread import start_core
from hil.live.folders import folders
from hil.live.fork import Fork
from hil.live.guard import BREADCRUMB, note_hung
from hil.live.live_bench import LiveBench, Paths, make_live, make_runs
from hil.live.refusals import Refused, StartError
from hil.live.store import NvmStore
from hil.operations.control_socket import ClaimedSocket, ControlServer, SocketRefused
from hil.operations.desk import Desk
from hil.operations.make_desk import make_desk
from hil.operations.reports import status_line
from hil.operations.said_events import SaidEvents
from hil.operations.table import WATCH_IDLE_S
from hil.vocab.address import CONTROL_SOCKET, owner_of
from hil.vocab.bridge_protocol import BridgeError


@dataclass(frozen=True)
class Serving:
    """Parts of a bench that serves, handed to the program that started it."""

    live: LiveBench
    grant: Grant
    desk: Desk


class Daemon:
    """Process of a bench. ``run`` starts it, returns after ``stop`` or a signal, and puts all away."""

    def __init__(
        self,
        config: BenchConfig,
        *,
        config_folder: Path,
        config_file: Path | None = None,
        runtime_base: Path,
        state_base: Path,
        input_log: Path | None = None,
        is_recorded: bool = True,
        require_rt: bool = False,
        port_group: str | None = None,
        notifier: Notifier | None = None,
        fork: Fork | None = None,
    ) -> None:
        self._configured = Configured(config, find_catalogue(path=config.profile_path))
        runtime, state = runtime_base / config.bench, state_base / config.bench
        self._at = Paths(config_folder, config_file, runtime, state, input_log, port_group, is_recorded)
        self._require_rt = require_rt
        self._notifier = notifier or Notifier({}, 0)
        self._fork = fork
        self._stop, self._hang_up = asyncio.Event(), asyncio.Event()

    async def run(self, started: Callable[[Serving], None]) -> None:
        """Start the bench, call ``started``, and serve until told to stop.

        Raises:
            StartError: something is missing; nothing was left behind.
        """
        async with AsyncExitStack() as stack:  # puts away what was started, the last first
            try:
                serving = await self._start(stack)
            except (Refused, SocketRefused, BridgeError, LanesRefused) as error:
                raise StartError(str(error)) from None
            started(serving)
            await self._stop.wait()

    def stop(self) -> None:
        """End ``run``."""
        self._stop.set()

    async def _start(self, stack: AsyncExitStack) -> Serving:
        loop, config, at = asyncio.get_running_loop(), self._configured.config, self._at
        self._answer_signals(stack)  # first: one that comes early leaves nothing behind either
        said = SaidEvents(loop, lambda name: owner_of(name) in self._configured.config.devices)
        logging.getLogger().addHandler(said)
        stack.callback(said.end)
        stack.enter_context(folders(config.bench, at.state, at.runtime))
        claimed = ClaimedSocket(at.runtime / CONTROL_SOCKET, config.bench)
        stack.callback(claimed.release)
        files = NvmStore(at.state)
        stack.push_async_callback(loop.run_in_executor, None, files.close)
        fork, catalogue = self._fork, self._configured.catalogue
        plan = (
            fork.plan(config, catalogue, files) if fork else plan_start(config, at.folder, catalogue, files)
        )
        live = make_live(stack, self._configured, plan, files, at, WATCH_IDLE_S, fork)
        try:
            await live.apply.carry_out(plan)
        except Refused as refused:
            raise Refused("\n".join([str(refused), *await closed_doors(config)])) from None
        if fork:
            await live.go_through(fork)
        note_hung(at.state / BREADCRUMB, live.notes)
        clock, grant = start_core(stack, live.sim, config, require_rt=self._require_rt)
        if live.recording.file:
            live.recording.file.start(clock)
        live.vitals.start()
        runs = make_runs(stack, live, clock)
        is_service = bool(self._notifier)
        desk = make_desk(
            stack,
            live,
            runs,
            clock,
            grant,
            state_dir=at.state,
            is_service=is_service,
            stop=self.stop,
            events_before=fork.events() if fork else (),
            said=said,
        )
        stack.push_async_callback(live.bridges.close)
        await live.bridges.open(config, desk)
        server = ControlServer(desk, claimed)
        stack.push_async_callback(server.close)
        service = Service(
            self._notifier,
            lambda: status_line(live.sim, live.configured, live.places, grant),
            lambda: live.sim.core.native.rt_stats()["ticks"],
        )
        live.reloader.open(self._hang_up, service)
        stack.push_async_callback(live.reloader.close)
        stack.callback(service.stop)
        service.start()
        return Serving(live, grant, desk)

    def _answer_signals(self, stack: AsyncExitStack) -> None:
        loop, calls = asyncio.get_running_loop(), {signal.SIGINT: self.stop, signal.SIGTERM: self.stop}
        if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:  # as under nohup
            calls[signal.SIGHUP] = self.stop if has_terminal() else self._hang_up.set
        signals.answer(loop, calls)
        stack.callback(signals.ignore, loop, calls)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGHUP})
