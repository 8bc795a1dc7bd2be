"""Composition of a bench's desk from the parts that answer."""

import time
from collections.abc import Callable, Iterable
from contextlib import AsyncExitStack
from pathlib import Path

from hil.host.real_time import Grant
from hil.live.core_thread import WallClock
from hil.live.devices.bench_devices import DeviceInfos
from hil.live.held_time import HeldTime
from hil.live.live_bench import LiveBench, LiveRuns
from hil.live.standing_time import StandingTime
from hil.operations.about import About
from hil.operations.bench_operations import BenchOperations
from hil.operations.command_log import begin_commands
from hil.operations.desk import Desk
from hil.operations.device_operations import ChannelOperations, DeviceOperations
from hil.operations.drawing_operation import DrawingOperation
from hil.operations.event_log import EventLog
from hil.operations.halt_operation import HaltOperation
from hil.operations.health import Health
from hil.operations.leases import FILE, Leases
from hil.operations.metrics import Metrics
from hil.operations.past_operations import PastOperations
from hil.operations.processor_operations import ProcessorOperations
from hil.operations.recorded_events import RecordedEvents
from hil.operations.reports import Reports, SharedReport
from hil.operations.said_events import SaidEvents
from hil.operations.seen_events import SeenEvents
from hil.operations.site_stop_operation import SiteStop
from hil.operations.table import OPERATIONS, Answerer
from hil.operations.watch_operations import WatchOperations
from hil.operations.wire_reports import data_sheet, listed_wires
from hil.sim.noted_events import NotedEvent
from hil.vocab.desk_protocol import Description


def make_desk(
    stack: AsyncExitStack,
    live: LiveBench,
    runs: LiveRuns,
    clock: WallClock,
    grant: Grant,
    *,
    state_dir: Path,
    is_service: bool,
    stop: Callable[[], None],
    is_seen: bool = True,
    events_before: Iterable[NotedEvent] = (),
    said: SaidEvents | None = None,
) -> Desk:
    """Make the desk of a running bench; ``stack`` ends what it begins. ``is_service``: a service manager
    started the bench; ``stop``: ends it; ``is_seen``: its events have what nobody asked for, too;
    ``events_before``: those of the recorded run that it goes on from; ``said``: lines of the process's log,
    which become events."""
    sim, configured, places, faults, queue = live.sim, live.configured, live.places, live.faults, runs.queue
    commits, bridges, vitals = live.commits, live.bridges, live.vitals
    known = live.devices
    health = Health(sim, known, places, commits, vitals, grant, state_dir, is_service, bridges)
    events, recorded = EventLog(lambda: sim.now_ns), RecordedEvents(live.recording)
    events.listeners.append(recorded.put)
    stack.callback(recorded.end)
    events.begin_with(events_before)
    if said:
        said.begin(events)
        stack.callback(said.end)
    commands = begin_commands(stack, configured.config, sim, clock, state_dir, is_service, is_live=is_seen)
    events.outcomes.append(commands.put)
    kept, wall_ns = (state_dir / FILE, time.time_ns) if is_seen else (None, lambda: clock.times_ns()[1])
    leases = Leases(kept, places, events, wall_ns)
    metrics = Metrics(
        sim,
        configured,
        known,
        places,
        clock,
        commits,
        faults,
        queue,
        bridges,
        vitals,
        health,
        leases,
        commands,
    )
    seen = SeenEvents(events, sim, places, faults, queue, bridges, health, leases)
    stack.push_async_callback(seen.end)
    if is_seen:
        seen.begin()
    looks = WatchOperations(sim, known, places, clock, live.watches, queue, events, commands)
    drawings = DrawingOperation(runs.axes)
    reports = Reports(
        sim,
        configured,
        places,
        known,
        faults,
        bridges,
        grant,
        health,
        queue,
        live.recording,
        drawings.last,
        leases.told,
    )
    infos = DeviceInfos(known)
    about = About(configured, infos, health, queue, events, clock, leases.current, bridges, live.recording)
    listed, status = SharedReport(reports.listed), SharedReport(reports.status)
    devices = DeviceOperations(sim, known)
    channels, held = ChannelOperations(sim), HeldTime(sim, configured, known, clock)
    processors = ProcessorOperations(known, configured, StandingTime(held))
    past = PastOperations(live.recording, lambda: sim.now_ns, configured.config.speed)
    stack.push_async_callback(past.end)
    halts = HaltOperation(known, queue)
    bench = BenchOperations(faults, queue, live.reloader, stop)
    answerers: dict[str, Answerer] = {
        "list": lambda asked: listed.read(),
        "status": lambda asked: status.read(),
        "health": lambda asked: reports.health_in_short(),
        "metrics": lambda asked: metrics.read(),
        "segments": lambda asked: listed_wires(sim, places, "segments"),
        "buses": lambda asked: listed_wires(sim, places, "can"),
        "about": lambda asked: about.told(),
        "benches": lambda asked: runs.others.joined(asked.source),
        "verbs": reports.verbs,
        "state": devices.state,
        "packed": devices.packed,
        "look": devices.look,
        "read_text": devices.read_text,
        "registers": reports.registers,
        "eds": lambda asked: data_sheet(sim, asked.target),
        "reset": devices.reset,
        "pin": devices.pin,
        "set": devices.set_field,
        "zero": devices.zero,
        "type": devices.type,
        "send": devices.send,
        "do": devices.do,
        "wait": devices.wait,
        "drive": devices.drive,
        "play": devices.play,
        "processor": processors.processor,
        "load_program": processors.load_program,
        "count": processors.count,
        "counted": processors.counted,
        "debug": processors.debug,
        "attach": channels.attach,
        "detach": channels.detach,
        "transmit": channels.transmit,
        "watch": looks.watch,
        "samples": looks.samples,
        "unwatch": looks.unwatch,
        "capture": looks.capture,
        "past": past.overview,
        "past_state": past.state,
        "past_samples": past.samples,
        "past_bytes": past.bytes_at,
        "past_packets": past.packets,
        "past_find": past.find,
        "inject": lambda asked, fault, parameters: {"number": faults.inject(fault, asked.target, parameters)},
        "clear": bench.clear,
        "faults": lambda asked: faults.listed(),
        "fault_places": lambda asked: faults.places(),
        "run": bench.run,
        "drawing": drawings.drawing,
        "runs": bench.runs,
        "cancel_run": lambda asked, how: queue.cancel(asked.target, how).as_dict(),
        "pace_run": lambda asked, pace: queue.set_pace(asked.target, pace).as_dict(),
        "part": lambda asked, given: runs.parts.answer(asked.source, asked.target, given),
        "halt": halts.halt,
        "stop_site": SiteStop(configured, halts, runs.others).stop,
        "events": lambda asked, after: events.told(after),
        "lease": leases.told,
        "take_lease": leases.begin,
        "renew_lease": leases.renew,
        "give_lease": leases.give,
        "break_lease": leases.end_anothers,
        "pause": lambda asked: {"sim_ns": held.hold(True)},
        "resume": lambda asked: {"sim_ns": held.hold(False)},
        "reload": bench.reload,
        "stop": bench.stop,
    }
    buses = {name: wire.frames for name, wire in sim.wires.items() if wire.frames}
    bench_name = configured.config.bench
    description = Description(bench_name, clock, infos, sim.segments, places, OPERATIONS, buses)
    return Desk(description, known, looks, answerers, events, leases)
