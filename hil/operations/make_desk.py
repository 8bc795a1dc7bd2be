"""Composition of a bench's desk from the parts that answer."""

from collections.abc import Callable
from pathlib import Path

from hil.host.real_time import Grant
from hil.live.clock import WallClock
from hil.live.live_bench import LiveBench, LiveRuns
from hil.operations.bench_operations import BenchOperations
from hil.operations.board_operations import BoardOperations
from hil.operations.bus_reports import data_sheet, listed_buses
from hil.operations.channel_operations import ChannelOperations
from hil.operations.desk import Desk
from hil.operations.devices import Devices
from hil.operations.drawing_operation import DrawingOperation
from hil.operations.drive_operations import DriveOperations
from hil.operations.health import Health
from hil.operations.looking_on import LookingOn
from hil.operations.metrics import Metrics
from hil.operations.reports import Reports, listed_segments
from hil.operations.shared_report import SharedReport
from hil.operations.table import Answerer


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
    """Make the desk of a running bench. ``is_service``: a service manager started it; ``stop``: ends it."""
    sim, configured, places, faults, queue = live.sim, live.configured, live.places, live.faults, runs.queue
    commits, bridges, vitals = live.commits, live.bridges, live.vitals
    devices = Devices(sim, places, configured)
    health = Health(sim, places, commits, vitals, grant, state_dir, is_service, bridges)
    metrics = Metrics(sim, configured, places, clock, commits, faults, queue, bridges, vitals, health)
    looks = LookingOn(sim, places, clock, live.watches, queue)
    reports = Reports(
        sim, configured, places, devices, commits, faults, bridges, live.notes, grant, health, queue
    )
    listed, status = SharedReport(reports.listed), SharedReport(reports.status)
    of_drives = DriveOperations(sim, places.drives)
    boards = BoardOperations(sim, places, configured, runs.axes, runs.real, of_drives)
    channels = ChannelOperations(sim)
    bench = BenchOperations(faults, queue, live.reloader, stop)
    answerers: dict[str, Answerer] = {
        "list": lambda asked: listed.read(),
        "status": lambda asked: status.read(),
        "health": lambda asked: reports.health_in_short(),
        "metrics": lambda asked: metrics.read(),
        "segments": lambda asked: listed_segments(sim, places),
        "buses": lambda asked: listed_buses(sim, places),
        "benches": lambda asked: runs.others.joined(asked.source),
        "verbs": reports.verbs,
        "state": boards.state,
        "packed": boards.packed,
        "look": boards.look,
        "registers": reports.registers,
        "eds": lambda asked: data_sheet(sim, asked.target),
        "reset": boards.reset,
        "pin": boards.pin,
        "set": boards.set_field,
        "zero": boards.zero,
        "type": boards.type,
        "send": boards.send,
        "do": boards.do,
        "wait": boards.wait,
        "drive": boards.drive,
        "play": boards.play,
        "attach": channels.attach,
        "detach": channels.detach,
        "transmit": channels.transmit,
        "watch": looks.watch,
        "samples": looks.samples,
        "unwatch": looks.unwatch,
        "capture": looks.capture,
        "inject": lambda asked, fault, parameters: {"number": faults.inject(fault, asked.target, parameters)},
        "clear": bench.clear,
        "faults": lambda asked: faults.listed(),
        "run": bench.run,
        "drawing": DrawingOperation(runs.axes).drawing,
        "runs": bench.runs,
        "cancel_run": lambda asked, how: queue.cancel(asked.target, how).as_dict(),
        "pace_run": lambda asked, pace: queue.set_pace(asked.target, pace).as_dict(),
        "part": lambda asked, given: runs.parts.answer(asked.source, asked.target, given),
        "reload": bench.reload,
        "stop": bench.stop,
    }
    return Desk(configured.config.bench, clock, devices, sim.segments, looks, answerers)
