"""The daemon: a bench in real time, its ports, its boards' memories, its control socket."""

import asyncio
import errno
import fcntl
import gc
import logging
import os
import signal
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from hil import __version__
from hil.compose import (
    bench_runtime,
    find_catalogue,
    make_port,
    serial_port_config,
    start_sections,
)
from hil.compose.build import TableFileError
from hil.config import BenchConfig, Catalogue, DeviceConfig
from hil.config.check_device import EMULATED_KEYS
from hil.host import signals
from hil.host.notify import Notifier
from hil.host.paths import CONTROL_SOCKET, make_folder
from hil.host.real_time import Grant, grant, refused, wanted_cpu, wanted_priority
from hil.host.service import Service, has_terminal
from hil.host.trust import distrust
from hil.live.apply import Reloader
from hil.live.board_end import BoardEnd
from hil.live.bridges import Bridges
from hil.live.captures import Captures
from hil.live.changes import Changes
from hil.live.clock import WallClock
from hil.live.commits import Commits
from hil.live.configured import Configured
from hil.live.fault_registry import FaultRegistry
from hil.live.guard import BREADCRUMB, StepGuard, take_breadcrumb
from hil.live.holds import Holds
from hil.live.joint import Joint
from hil.live.lines import Lines
from hil.live.log_file import LogFile
from hil.live.places import Places
from hil.live.runs.other_benches import OtherBenches
from hil.live.runs.part import Parts
from hil.live.runs.queue import RunQueue
from hil.live.runs.real_axes import AllAxes, RealAxes
from hil.live.sim_ends import TapEnd, UartEnd
from hil.live.store import NvmStore, StoreError
from hil.live.vitals import Vitals
from hil.live.watches import Watches
from hil.net.control_client import listener
from hil.operations.bridge_host import Host
from hil.operations.control_socket import ControlServer, already_running
from hil.operations.control_verbs import WATCH_IDLE_S
from hil.runs import BenchAxes
from hil.sim.around import Around
from hil.sim.bench import BenchRuntime
from hil.sim.device import Device
from hil.sim.input_log import InputLogWriter
from hil.vocab.bridges import BridgeError
from hil.vocab.faults import FaultRefused
from hil.vocab.firmware import MAIN, NETWORK
from hil.vocab.ports import PortContext, PortError, port_label

log = logging.getLogger("hil")

LOG_FLUSH_S = 0.2
TURN_S = 0.02
"""Of the event loop, for one group that is late: as long as the longest step of a healthy firmware."""


class StartError(Exception):
    """The daemon cannot start: ``str(error)`` says why and what to do, a line for each problem."""


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
        self.notes: dict[str, str] = {}
        self.places = Places()
        self.holds = Holds(self.places)
        self.changes = Changes()
        self.faults: FaultRegistry
        self.lines: Lines
        self.clock: WallClock
        self.captures: Captures
        self.bridges = Bridges(self.changes)
        self.host: Host
        self.runs: RunQueue
        self.parts: Parts
        self.real_axes: RealAxes
        self.others = OtherBenches(self.bridges)
        self.grant: Grant | None = None
        self.bench: BenchRuntime
        self.watches: Watches
        self.vitals: Vitals
        self.config_folder = config_folder
        self.config_file = config_file
        self.files: NvmStore
        self._input_log = input_log
        self._log_file: LogFile | None = None
        self._require_rt = require_rt
        self._port_group = port_group
        self.service = Service(self, notifier or Notifier({}, 0))
        self.reloader = Reloader(self)
        self._stop = asyncio.Event()
        self._keeps_parent = False
        """The folder of the runtime directory was there, and empty: somebody made it."""

    @property
    def config(self) -> BenchConfig:
        return self.configured.config

    @property
    def catalogue(self) -> Catalogue:
        return self.configured.catalogue

    async def run(self, started: Callable[["Daemon"], None]) -> None:
        """Start, say so, and serve until told to stop.

        Raises:
            StartError: something is missing; nothing was left behind.
        """
        loop = asyncio.get_running_loop()
        calls = {signal.SIGINT: self.stop, signal.SIGTERM: self.stop}
        if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:  # as under nohup
            calls[signal.SIGHUP] = self.stop if has_terminal() else self.reloader.request
        signals.answer(loop, calls)  # first: one that comes early leaves nothing behind either
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGHUP})
        self.files, lock = self._open_store()
        control = ControlServer(self, self.runtime_dir / CONTROL_SOCKET)
        try:
            self._prepare_runtime_dir()
            await control.open()
            self._build(self.files, loop)
            await self._open_ports()
            self._start_core(loop)
            self.vitals.start()
            self._make_runs()
            try:
                await self.bridges.open(self.config.bridges, self.host)
            except BridgeError as error:
                raise StartError(str(error)) from None
            self.reloader.is_open = True
            self.service.start()
            started(self)
            await self._stop.wait()
        finally:
            await self._put_away(loop, control, self.files)
            os.close(lock)
            signals.ignore(loop, calls)

    def _make_runs(self) -> None:
        self.real_axes = RealAxes(self.places, self.configured, self.bench)
        axes = AllAxes(BenchAxes(self.bench, self.watches.sampler), self.real_axes)
        self.runs = RunQueue(axes, self.configured, self.clock, self.others, self.holds)
        self.parts = Parts(self.runs, axes, self.configured, self.clock, self.holds)

    def stop(self) -> None:
        """End ``run``."""
        self._stop.set()

    # ---- start ----

    def _open_store(self) -> tuple[NvmStore, int]:
        """The store, and the file descriptor that keeps other daemons away from its directory."""
        try:
            make_folder(self.state_dir)
            lock = os.open(self.state_dir, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return NvmStore(self.state_dir), lock
        except BlockingIOError as error:
            with suppress(OSError):
                if pid := listener(self.runtime_dir / CONTROL_SOCKET):
                    raise StartError(already_running(self.config.bench, pid)) from error
            raise StartError(
                f"state directory {self.state_dir}: another daemon has it; choose another with --state-dir"
            ) from error
        except OSError as error:
            raise StartError(
                f"state directory {self.state_dir}: {error.strerror}; choose another with --state-dir"
            ) from error

    def _prepare_runtime_dir(self) -> None:
        try:
            parent = self.runtime_dir.parent
            self._keeps_parent = parent.exists() and not any(parent.iterdir())
            if not parent.exists() or parent.stat().st_uid != 0:  # root's is the service manager's
                make_folder(parent)
            make_folder(self.runtime_dir, 0o755)  # ports and socket have modes of their own
            if why := distrust(self.runtime_dir):
                raise PermissionError(errno.EACCES, why)
        except OSError as error:
            raise StartError(
                f"runtime directory {self.runtime_dir}: {error.strerror}; choose another with --runtime-dir"
            ) from error

    def _build(self, files: NvmStore, loop: asyncio.AbstractEventLoop) -> None:
        memories, counters, problems = {}, {}, []
        for name, config in self.config.twins.items():
            try:
                loaded = files.load(name, config.profile)
                memories[name] = start_sections(config, loaded.content.sections, self.config_folder)
            except StoreError as error:
                problems.append(str(error))
                continue
            except TableFileError as error:
                problems.append(f"devices.{name}.flash.table: {error}")
                continue
            counters[name] = loaded.content.counter
            if loaded.note:
                self.notes[name] = loaded.note
                log.warning("%s: %s", name, loaded.note)
        if problems:
            raise StartError("\n".join(problems))
        if hung := take_breadcrumb(self.state_dir / BREADCRUMB):
            self.notes[hung] = "its firmware could not be interrupted, which ended this bench the last time"
            log.error("%s: %s", hung, self.notes[hung])
        if self._input_log:
            self._open_log(self._input_log)
        self._guard = StepGuard(self.state_dir / BREADCRUMB, self.config.speed)
        self.lines = Lines(loop, lambda: self.bench.now_ns, self.config.speed)
        self.commits = Commits(files, loop)
        for name, counter in counters.items():
            self.commits.begin(name, counter)
        around = Around(
            turn_over=self.lines.turn_over,
            turn=self._turn,
            guard=self._guard,
            on_failed=self._device_failed,
            log=self._log_writer(memories),
        )
        self.bench = bench_runtime(self.config, self.catalogue, memories, self.commits, around)
        self.faults = FaultRegistry(self.bench, self.places)
        self.watches = Watches(self.bench, self.changes, self.config.speed, WATCH_IDLE_S)
        self.vitals = Vitals(self.bench)
        self.host = Host(self)

    def _open_log(self, path: Path) -> None:
        try:
            self._log_file = LogFile(path)
        except OSError as error:
            raise StartError(f"log {path}: {error.strerror}") from error

    def _log_writer(self, memories: Mapping[str, Mapping[str, bytes]]) -> InputLogWriter | None:
        if self._log_file is None:
            return None
        return InputLogWriter(self._log_file, f"hil {__version__}", self.config_as_dict(), memories)

    def addresses(self) -> list[tuple[str, str]]:
        """All ports' names, and where clients reach them."""
        return self.places.addresses()

    def config_as_dict(self) -> dict[str, Any]:
        """The configuration as a dict that ``hil.config.from_dict`` takes."""
        dumped: dict[str, Any] = self.config.model_dump(mode="json", by_alias=True)
        for device in dumped["devices"].values():
            device["port"] = "memory"
            device["network"] = None
            if device["at"]:  # its bytes are no part of a simulation
                for key in EMULATED_KEYS:
                    device.pop(key)
        for segment in dumped["segments"].values():
            for tap in segment["taps"].values():
                tap["port"] = "memory"
        return dumped

    async def _open_ports(self) -> None:
        problems = []
        for name, device_config in self.config.twins.items():
            native_usb = self.catalogue.profiles[device_config.profile].usb == "native"
            device = self.bench.devices[name]
            for uart, port_config in ((MAIN, device_config.port), (NETWORK, device_config.network)):
                if port_config is None:
                    continue
                label = port_label(name, uart)
                port = make_port(port_config, self.port_context(label))
                joint = Joint[UartEnd](label, port)
                try:
                    await port.open(joint)
                    joint.occupy(UartEnd(self.bench, self.lines, joint, device, uart, native_usb=native_usb))
                    self.places.uarts()[label] = joint
                except PortError as error:
                    problems.append(str(error))
        for segment, wire in self.config.segments.items():
            for tap_name, tap_config in wire.taps.items():
                label = f"{segment}.{tap_name}"
                port = make_port(tap_config.port, self.port_context(label))
                tap = self.bench.taps[label]
                tap_joint = Joint[TapEnd](label, port)
                try:
                    await port.open(tap_joint)
                    tap_joint.occupy(TapEnd(self.bench, self.lines, tap_joint, tap))
                    self.places.taps()[label] = tap_joint
                except PortError as error:
                    problems.append(str(error))
        for name, device_config in self.config.real.items():
            try:
                await self._open_real(name, device_config)
            except PortError as error:
                problems.append(str(error))
        if problems:
            raise StartError("\n".join(problems))
        try:
            for fault in self.config.faults:
                self.faults.inject(fault.fault, fault.target, fault.model_extra or {})
        except FaultRefused as error:
            raise StartError(f"faults: {error}") from None

    def port_context(self, label: str) -> PortContext:
        """Where the port with this label belongs."""
        return PortContext(self.config.bench, label, self.runtime_dir, self._port_group)

    async def _open_real(self, name: str, config: DeviceConfig) -> None:
        context = self.port_context(name)
        board = make_port(serial_port_config(config), context)
        joint = Joint[BoardEnd](name, make_port(config.port, context))
        await joint.port.open(joint)
        joint.occupy(BoardEnd(joint, board))
        self.places.boards()[name] = joint
        await board.open(joint.end.from_board)

    @staticmethod
    def _turn() -> Callable[[], bool]:
        end_s = time.monotonic() + TURN_S
        return lambda: time.monotonic() > end_s

    def _start_core(self, loop: asyncio.AbstractEventLoop) -> None:
        if why := refused(self.config.cpu):
            raise StartError(why)
        gc.collect()
        gc.freeze()  # a full collection would stop the event loop for 0.2 s per million objects
        gc.enable()
        priority, cpu = wanted_priority(), wanted_cpu(self.config.cpu)
        period_ns = 1_000_000_000 // self.config.rate_hz
        try:
            self.bench.drive.start(period_ns, self.config.speed, priority, cpu)
        except OSError as error:
            raise StartError(f"the core's thread could not be started: {error.strerror}") from error
        epoch_ns = time.time_ns() - round(self.bench.now_ns / self.config.speed)
        self.clock = WallClock(self.bench, self.config.speed, epoch_ns)
        self.captures = Captures(self.bench, self.places, self.clock)
        self.grant = grant(self.bench.core.native.rt_stats(), priority, cpu)
        if self.grant.missing and self._require_rt:
            raise StartError(self.grant.line())
        loop.add_reader(self.bench.core.event_fd, self.bench.drive.service)
        if self._log_file:
            loop.call_later(LOG_FLUSH_S, self._flush_log, loop)

    # ---- work ----

    def _flush_log(self, loop: asyncio.AbstractEventLoop) -> None:
        if self._log_file and not self._stop.is_set():
            self._log_file.flush()
            loop.call_later(LOG_FLUSH_S, self._flush_log, loop)

    def _device_failed(self, device: Device) -> None:
        again = f"the other devices go on; `hil reset {device.name}` restarts it"
        log.error("%s stopped: %s; %s", device.name, device.failed, again)
        if joint := self.places.uarts().get(device.name):
            joint.port.write(f"\r\n[hil: {device.name} stopped: {device.failed}]\r\n".encode())

    # ---- end ----

    async def _put_away(
        self, loop: asyncio.AbstractEventLoop, control: ControlServer, files: NvmStore
    ) -> None:
        self.service.stop()
        await self.reloader.close()
        await control.close()
        await self.bridges.close()
        if hasattr(self, "runs"):
            await self.runs.close()
            await self.real_axes.close()
        if hasattr(self, "_guard"):
            self._guard.close()
        if hasattr(self, "bench"):
            loop.remove_reader(self.bench.core.event_fd)
            self.watches.stop()
            self.vitals.stop()
            self.bench.stop()
            await self.commits.end()  # its answers to commits are inputs, for the log too
            self.lines.close()
        await loop.run_in_executor(None, files.close)
        for joint in self.places.joints():
            await joint.port.close()
        for board in self.places.boards().values():
            await board.end.line.close()
        if self._log_file:
            self._log_file.close()
        with suppress(OSError):
            self.runtime_dir.rmdir()
            if not self._keeps_parent:
                os.rmdir(self.runtime_dir.parent)
