"""Table of metrics: each one's name and meaning, and where its values stand."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from hil import __version__
from hil.core.core import bucket_edges_ns
from hil.host.process import Process, read_process
from hil.live.configured import Configured
from hil.live.core_thread import WallClock
from hil.live.fault_registry import FaultRegistry
from hil.live.memory_commits import Commits
from hil.live.places import Places
from hil.live.runs.queue import RunQueue
from hil.live.vitals import Vitals
from hil.operations.command_log import CommandLog
from hil.operations.health import Health, problem_kinds, state_of
from hil.operations.leases import Leases
from hil.operations.wire_reports import Echo, echoes
from hil.sim.bench import BenchRuntime
from hil.vocab.bridge_protocol import Bridge
from hil.vocab.device import Device
from hil.vocab.monitoring import STATES, Histogram, Metric, Reading, Value
from hil.vocab.ports import EchoState, Port, PortStats
from hil.vocab.wire import WireInfo, WireMetric

RUN_STATES = ("queued", "running", "done", "failed", "cancelled")
FIRST_OCTAVE, LAST_OCTAVE = 10, 30
"""Octaves of a histogram: buckets end at 2^10 ns (1 us) to 2^30 ns (1.07 s)."""

Values = Iterable[tuple[tuple[str, ...], Value]]


@dataclass(frozen=True)
class Metrics:
    """Metrics of one bench."""

    sim: BenchRuntime
    configured: Configured
    devices: Mapping[str, Device]
    places: Places
    clock: WallClock
    commits: Commits
    faults: FaultRegistry
    runs: RunQueue
    bridges: Mapping[str, Bridge]
    vitals: Vitals
    health: Health
    leases: Leases
    commands: CommandLog

    def read(self) -> Iterator[Reading]:
        """Read all metrics, each without interruption: between two, a reload may add and remove devices."""
        scrape = Scrape(self, self.sim.core.native.rt_stats(), read_process())
        for metric, read in metric_rows(self.configured.catalogue.wire_infos):
            yield metric, list(read(scrape))


class Scrape(NamedTuple):
    """Values that one reading needs more than once."""

    of: Metrics
    rt: Any
    process: Process

    def ports(self) -> dict[str, Port]:
        """Ports by name; a real board's is the one that programs use."""
        return {label: link.port for label, link in self.of.places.items()}


class MetricRow(NamedTuple):
    """A metric and how to read it."""

    metric: Metric
    read: Callable[[Scrape], Values]


def octave_histogram(octaves: Iterable[int], total_ns: int) -> Histogram:
    """Make a histogram of counts by powers of two of nanoseconds: number b has those of [2^(b-1), 2^b)."""
    below: dict[int, int] = dict.fromkeys(range(FIRST_OCTAVE, LAST_OCTAVE + 1), 0)
    over = 0
    for power, count in enumerate(octaves):
        if power > LAST_OCTAVE:
            over += count
        else:
            below[max(power, FIRST_OCTAVE)] += count
    return Histogram([((1 << power) / 1e9, n) for power, n in below.items()], over, total_ns / 1e9)


def _wake_latency(s: Scrape) -> Values:
    octaves = [0] * 64
    for bucket, count in enumerate(s.rt["wake_latency"]):
        octaves[bucket_edges_ns(bucket)[0].bit_length()] += count
    yield (), octave_histogram(octaves, s.rt["latency_total_ns"])


def _one(read: Callable[[Scrape], Value]) -> Callable[[Scrape], Values]:
    return lambda s: [((), read(s))]


def _of_ports(read: Callable[[PortStats], int]) -> Callable[[Scrape], Values]:
    return lambda s: (((name,), read(port.stats())) for name, port in s.ports().items())


def _of_wires(kind: str, metric: WireMetric) -> MetricRow:
    def values(s: Scrape) -> Values:
        now_ns = s.of.sim.now_ns
        for name, wire in s.of.sim.wires_of(kind).items():
            yield from metric.read(name, wire.counters(now_ns))

    return MetricRow(metric.metric, values)


def _of_bridges(counter: str) -> Callable[[Scrape], Values]:
    return lambda s: (((name,), b.status().get(counter, 0)) for name, b in s.of.bridges.items())


def _health(s: Scrape) -> Values:
    present = state_of(s.of.health.problems())
    return [((state,), int(state == present)) for state in STATES]


def _problems(s: Scrape) -> Values:
    found = [problem.kind for problem in s.of.health.problems()]
    kinds = problem_kinds(s.of.configured.catalogue.wire_infos)
    return [((kind,), found.count(kind)) for kind in kinds]


def _granted(s: Scrape) -> Values:
    errnos = {"priority": "fifo_errno", "cpu": "pin_errno", "memory": "lock_errno"}
    return [((what,), int(not s.rt[errno])) for what, errno in errnos.items()]


def _runs(s: Scrape) -> Values:
    found = [progress.state for progress in s.of.runs.progress.values()]
    return [((state,), found.count(state)) for state in RUN_STATES]


def _lease_left(s: Scrape) -> Values:
    if lease := s.of.leases.told()["lease"]:
        yield (lease["user"],), lease["left_s"]


def _overruns(s: Scrape) -> Values:
    for name, device in s.of.sim.devices.items():
        for uart, each in device.uarts.items():
            yield (name, uart), each.overrun_bytes


def _of_devices(read: Callable[[Any], int]) -> Callable[[Scrape], Values]:
    return lambda s: (((name,), read(device)) for name, device in s.of.sim.devices.items())


def _boards(s: Scrape) -> Values:
    for name, device in s.of.devices.items():
        if device.is_there is not None:
            yield (name,), int(device.is_there)


def _of_drives(counter: str) -> Callable[[Scrape], Values]:
    return lambda s: (
        ((name,), counts[counter])
        for name, device in s.of.devices.items()
        if counter in (counts := device.counters())
    )


def _echoes(value: Callable[[Echo], int]) -> Callable[[Scrape], Values]:
    return lambda s: (
        ((each[0],), value(each[1]))
        for each in echoes(s.of.devices, s.of.sim, s.of.places, s.of.bridges)
        if each
    )


def _metric(
    name: str, kind: Any, about: str, read: Callable[[Scrape], Values], labels: tuple[str, ...] = ()
) -> MetricRow:
    return MetricRow(Metric(name, kind, about, labels), read)


PORT, BRIDGE = ("port",), ("bridge",)
_BEFORE_WIRES = (
    _metric("hil_bench_info", "gauge", "always 1; which bench this is, of which version of hil",
            lambda s: [((s.of.configured.config.bench, __version__), 1)], ("bench", "version")),
    _metric("hil_healthy", "gauge", "1 if nothing is wrong, as `hil status` says",
            _one(lambda s: int(not s.of.health.problems()))),
    _metric("hil_health", "gauge", "1 for the present state, as `hil status` says", _health, ("state",)),
    _metric("hil_problems", "gauge", "what is wrong now, by kind", _problems, ("kind",)),
    _metric("hil_rt_granted", "gauge", "1 if the core has real-time priority, its cpu, locked memory",
            _granted, ("what",)),
    _metric("hil_speed_ratio", "gauge", "simulated seconds in one second, as configured",
            _one(lambda s: s.of.configured.config.speed)),
    _metric("hil_simulated_seconds_total", "counter", "simulated time since the start",
            _one(lambda s: s.of.sim.now_ns / 1e9)),
    _metric("hil_ticks_total", "counter", "wakes of the core", _one(lambda s: s.rt["ticks"])),
    _metric("hil_missed_ticks_total", "counter", "wakes that came so late that the next was due already",
            _one(lambda s: s.rt["missed"])),
    _metric("hil_overruns_total", "counter", "wakes that had more than 20 ms of work",
            _one(lambda s: s.rt["overruns"])),
    _metric("hil_wake_latency_seconds", "histogram", "how late the core woke", _wake_latency),
    _metric("hil_wake_latency_max_seconds", "gauge", "the longest since the start",
            _one(lambda s: s.rt["longest_latency_ns"] / 1e9)),
    _metric("hil_firmware_lag_seconds", "histogram", "how late firmware ran after it was due",
            _one(lambda s: octave_histogram(s.of.sim.real_time.lag, s.of.sim.real_time.lag_total_ns))),
    _metric("hil_loop_lag_seconds", "histogram", "how late the event loop was, looked at ten times a second",
            _one(lambda s: octave_histogram(s.of.vitals.loop_lag, s.of.vitals.loop_lag_total_ns))),
    _metric("hil_device_failed", "gauge", "1 if the device's firmware has stopped",
            _of_devices(lambda device: int(device.failed is not None)), ("device",)),
    _metric("hil_setpoints_starved_total", "counter", "set-point time-outs",
            _of_devices(lambda device: device.setpoints.starved), ("device",)),
    _metric("hil_uart_overrun_bytes_total", "counter", "bytes that found no room at a board's UART",
            _overruns, ("device", "uart")),
    _metric("hil_flash_writes_total", "counter", "writes of boards' memories that were asked for",
            lambda s: [((result,), count) for result, count in s.of.commits.writes.items()], ("result",)),
    _metric("hil_port_clients", "gauge", "clients that have the port open",
            _of_ports(lambda p: p.clients), PORT),
    _metric("hil_port_connects_total", "counter", "clients that ever opened it",
            _of_ports(lambda p: p.connects), PORT),
    _metric("hil_port_received_bytes_total", "counter", "bytes from clients", _of_ports(lambda p: p.rx_bytes),
            PORT),
    _metric("hil_port_sent_bytes_total", "counter", "bytes to clients",
            _of_ports(lambda p: p.tx_bytes), PORT),
    _metric("hil_port_dropped_bytes_total", "counter", "bytes lost because a client does not read",
            _of_ports(lambda p: p.dropped_bytes), PORT),
    _metric("hil_port_unheard_bytes_total", "counter", "bytes sent while nobody had the port open",
            _of_ports(lambda p: p.unheard_bytes), PORT),
    _metric("hil_port_backlog_bytes", "gauge", "bytes that wait for a client to read",
            lambda s: (((name,), port.backlog()) for name, port in s.ports().items()), PORT),
    _metric("hil_port_failed", "gauge", "1 if the port cannot go on",
            lambda s: (((link.label,), int(link.failure is not None)) for link in s.of.places.values()),
            PORT),
    _metric("hil_real_board_present", "gauge", "1 if the real board's port is open, or the drive answers",
            _boards, ("device",)),
    _metric("hil_drive_polls_total", "counter", "complete readings of a real drive's state",
            _of_drives("polls"), ("device",)),
    _metric("hil_drive_time_outs_total", "counter", "requests that a real drive did not answer in time",
            _of_drives("time_outs"), ("device",)),
    _metric("hil_drive_exceptions_total", "counter", "exceptions that a real drive answered with",
            _of_drives("exceptions"), ("device",)),
    _metric("hil_drive_connects_total", "counter", "times that a real drive came to be there",
            _of_drives("connects"), ("device",)),
    _metric("hil_adapter_echo", "gauge", "1 if the adapter of a real line echoes what it sends",
            _echoes(lambda echo: int(echo["state"] == EchoState.YES)), PORT),
    _metric("hil_adapter_echo_bytes_total", "counter", "bytes that came back and were dropped",
            _echoes(lambda echo: int(echo["bytes"])), PORT),
    _metric("hil_adapter_collisions_total", "counter", "times that what was sent came back damaged",
            _echoes(lambda echo: int(echo["collisions"])), PORT),
)  # fmt: skip
_BEHIND_WIRES = (
    _metric("hil_bridge_links", "gauge", "connections", _of_bridges("links"), BRIDGE),
    _metric("hil_bridge_commands_total", "counter", "commands, or scrapes", _of_bridges("commands"), BRIDGE),
    _metric("hil_bridge_rejected_total", "counter", "commands that were refused",
            _of_bridges("rejected"), BRIDGE),
    _metric("hil_bridge_dropped_total", "counter", "messages that found no room",
            _of_bridges("dropped"), BRIDGE),
    _metric("hil_runs", "gauge", "runs that are remembered, by state", _runs, ("state",)),
    _metric("hil_faults", "gauge", "faults that are active", _one(lambda s: len(s.of.faults.listed()))),
    _metric("hil_leased", "gauge", "1 if somebody has a lease of the bench",
            _one(lambda s: int(s.of.leases.current() is not None))),
    _metric("hil_lease_remaining_seconds", "gauge", "time until the lease ends, while there is one",
            _lease_left, ("user",)),
    _metric("hil_commands_total", "counter", "requests that are no readings, by outcome",
            lambda s: [((outcome,), n) for outcome, n in s.of.commands.outcomes.items()], ("outcome",)),
    _metric("hil_log_messages_total", "counter", "warnings and errors in the log",
            lambda s: [((level,), n) for level, n in s.of.vitals.messages.items()], ("level",)),
    _metric("hil_locked_memory_bytes", "gauge", "memory of the process that cannot be paged out",
            _one(lambda s: s.process.locked_bytes)),
    _metric("hil_major_page_faults_total", "counter", "page faults that waited for a disk",
            _one(lambda s: s.process.major_faults)),
    _metric("process_resident_memory_bytes", "gauge", "memory in use",
            _one(lambda s: s.process.resident_bytes)),
    _metric("process_cpu_seconds_total", "counter", "CPU time, of users' and the kernel's code",
            _one(lambda s: s.process.cpu_s)),
    _metric("process_open_fds", "gauge", "file descriptors in use", _one(lambda s: s.process.open_fds)),
    _metric("process_max_fds", "gauge", "RLIMIT_NOFILE", _one(lambda s: s.process.max_fds)),
    _metric("process_start_time_seconds", "gauge", "when simulated time began, since 1970",
            _one(lambda s: s.of.clock.epoch_ns / 1e9)),
)  # fmt: skip


def metric_rows(wires: Mapping[str, WireInfo]) -> list[MetricRow]:
    """Table of all metrics, with those of wires, each with its meaning and how to read it."""
    of_wires = [_of_wires(kind, metric) for kind, told in wires.items() for metric in told.metrics]
    return [*_BEFORE_WIRES, *of_wires, *_BEHIND_WIRES]
