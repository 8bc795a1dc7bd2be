"""The desk of a bench, from the parts that answer."""

from collections.abc import Callable, Mapping
from pathlib import Path

from hil.host.real_time import Grant
from hil.live.apply import Reloader
from hil.live.captures import Captures
from hil.live.clock import WallClock
from hil.live.commits import Commits
from hil.live.configured import Configured
from hil.live.fault_registry import FaultRegistry
from hil.live.places import Places
from hil.live.runs.other_benches import OtherBenches
from hil.live.runs.part import Parts
from hil.live.runs.queue import RunQueue
from hil.live.runs.real import RealAxes
from hil.live.vitals import Vitals
from hil.live.watches import Watches
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
from hil.sim.bench import BenchRuntime
from hil.vocab.bridges import Bridge


def make_desk(
    *,
    sim: BenchRuntime,
    configured: Configured,
    places: Places,
    clock: WallClock,
    commits: Commits,
    faults: FaultRegistry,
    watches: Watches,
    captures: Captures,
    runs: RunQueue,
    parts: Parts,
    others: OtherBenches,
    real: RealAxes,
    apply: Reloader,
    bridges: Mapping[str, Bridge],
    vitals: Vitals,
    grant: Grant,
    notes: Mapping[str, str],
    state_dir: Path,
    is_service: bool,
    stop: Callable[[], None],
) -> Desk:
    """Of a bench that runs. ``notes``: for the operator, by device; ``is_service``: a service manager started
    the daemon; ``stop``: ends it."""
    devices = Devices(sim, configured)
    health = Health(sim, places, commits, vitals, grant, state_dir, is_service=is_service)
    metrics = Metrics(sim, configured, places, clock, commits, faults, runs, bridges, vitals, health)
    looking_on = LookingOn(sim, watches, captures, runs)
    return Desk(
        configured.config.bench,
        clock,
        devices,
        sim.segments,
        looking_on,
        (
            BoardOperations(sim, places, configured, real),
            FaultOperations(faults),
            RunOperations(runs, parts, others),
            looking_on,
            Reports(
                sim, configured, places, devices, commits, faults, bridges, notes, grant, health, metrics
            ),
            DaemonOperations(apply, stop),
        ),
    )
