"""The desk of a bench, from the parts that answer."""

from collections.abc import Callable
from pathlib import Path

from hil.host.real_time import Grant
from hil.live.captures import Captures
from hil.live.clock import WallClock
from hil.live.live_bench import LiveBench, LiveRuns
from hil.operations.board_operations import BoardOperations
from hil.operations.daemon_operations import DaemonOperations
from hil.operations.desk import Desk
from hil.operations.devices import Devices
from hil.operations.fault_operations import FaultOperations
from hil.operations.health import Health
from hil.operations.looking_on import LookingOn
from hil.operations.metrics import Metrics
from hil.operations.reports import Reports
from hil.operations.run_operations import RunOperations


def make_desk(
    live: LiveBench,
    runs: LiveRuns,
    clock: WallClock,
    grant: Grant,
    *,
    state_dir: Path,
    is_service: bool,
    stop: Callable[[], None],
) -> Desk:
    """Of a bench that runs. ``is_service``: a service manager started the daemon; ``stop``: ends it."""
    sim, configured, places = live.sim, live.configured, live.places
    commits, faults, bridges = live.commits, live.faults, live.bridges
    devices = Devices(sim, configured)
    health = Health(sim, places, commits, live.vitals, grant, state_dir, is_service=is_service)
    metrics = Metrics(
        sim, configured, places, clock, commits, faults, runs.queue, bridges, live.vitals, health
    )
    looking_on = LookingOn(sim, live.watches, Captures(sim, places, clock), runs.queue)
    reports = Reports(
        sim, configured, places, devices, commits, faults, bridges, live.notes, grant, health, metrics
    )
    parts = (
        BoardOperations(sim, places, configured, runs.real),
        FaultOperations(faults),
        RunOperations(runs.queue, runs.parts, runs.others),
        looking_on,
        reports,
        DaemonOperations(live.reloader, stop),
    )
    return Desk(configured.config.bench, clock, devices, sim.segments, looking_on, parts)
