"""Composition of the desk of a bench in memory, of the parts that a daemon's has."""

from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any, NamedTuple, cast

from hil.config import BenchConfig, Catalogue
from hil.host.real_time import Grant
from hil.live.apply.fail_first import Apply
from hil.live.apply.reload import Reloader
from hil.live.bridges import Bridges
from hil.live.configured import Configured
from hil.live.core_thread import WallClock
from hil.live.devices.bench_devices import Devices
from hil.live.devices.twin_device import TwinDevice, TwinHome
from hil.live.fault_registry import FaultRegistry
from hil.live.live_bench import LiveBench, make_runs
from hil.live.memory_commits import Commits
from hil.live.places import Places
from hil.live.reservations import Reservations
from hil.live.run_recording import RunRecording
from hil.live.store import NvmStore
from hil.live.vitals import Vitals
from hil.live.watches import Watches
from hil.operations.make_desk import make_desk
from hil.operations.table import WATCH_IDLE_S
from hil.sim.bench import BenchRuntime
from hil.telemetry import Sampler
from hil.vocab.desk_protocol import Desk
from hil.vocab.ports import PortContext

SPEED = 1.0
"""Wall time of a door goes with simulated time, from 1970 on."""
_NOT_ASKED = Grant(0, -1, {}, is_asked=False)
_NEVER = cast(Any, None)
"""Part of a daemon that no door reaches: files of memories, reloads."""


class MemoryDesk(NamedTuple):
    """Desk of a bench in memory, and the sampler of its watches, which has to be polled in time."""

    desk: Desk
    sampler: Sampler


async def memory_desk(sim: BenchRuntime, config: BenchConfig, catalogue: Catalogue) -> MemoryDesk:
    """Make the desk of a bench in memory, in the loop that is to run its tasks."""
    configured, places = Configured(config, catalogue), Places()
    commits = Commits(cast(NvmStore, _NEVER), _NEVER)
    watches = Watches(sim, SPEED, WATCH_IDLE_S)
    home = TwinHome(sim, places, commits, watches.sampler, {}, SPEED)
    devices = Devices()
    for name, twin in sim.devices.items():
        devices[name] = TwinDevice(home, twin, catalogue.boards[config.devices[name].profile])
    live = LiveBench(
        configured,
        sim,
        devices,
        places,
        commits,
        FaultRegistry(sim, devices),
        Reservations(devices),
        watches,
        Vitals(sim),
        Bridges(cast("type[PortContext]", _NEVER)),
        cast(Apply, _NEVER),
        cast(Reloader, _NEVER),
        {},
        RunRecording(),
    )
    clock = WallClock(sim, SPEED, 0)
    stack = AsyncExitStack()
    runs = make_runs(stack, live, clock)
    desk = make_desk(
        stack,
        live,
        runs,
        clock,
        _NOT_ASKED,
        state_dir=Path(),
        is_service=False,
        stop=lambda: None,
        is_seen=False,
    )
    return MemoryDesk(desk, watches.sampler)
