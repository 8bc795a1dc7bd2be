"""Traffic of a recorded run as a capture has it: bytes at ports, and what passed on wires."""

from collections.abc import Callable, Collection, Iterator
from functools import partial
from typing import Any

from hil.config.port_interface import port_interface
from hil.recorded.recorded_run import RecordedRun
from hil.recorded.run_events import place_of_sender
from hil.sim.bench import BenchRuntime
from hil.sim.inputs import Bytes
from hil.sim.twin import Twin
from hil.vocab.address import Address
from hil.vocab.time import NS_PER_S, SimTimeNs
from hil.vocab.wire import FrameKind
from hil.wire.pcapng import Interface, Record, RecordKind

SLICE_NS = NS_PER_S
LATE_NS = 2 * NS_PER_S
"""Time by which something may be told late at the most: a burst is told when it has passed."""


def record_sources(runtime: BenchRuntime) -> dict[str, Interface]:
    """Wires, and ports of boards that are on none there, as sources of a capture, by name."""
    found = {name: wire.interface(name) for name, wire in runtime.wires.items()}
    for name, device in runtime.devices.items():
        for part, uart in device.uarts.items():
            if uart.station is None:
                label = device.uarts.label(name, part)
                found[label] = port_interface(label, device, part)
    return found


class RunRecords:
    """Records of some sources from the run's present on. ``at_ns`` of each is simulated."""

    def __init__(self, run: RecordedRun, names: Collection[str]) -> None:
        self._run = run
        every = record_sources(run.runtime)
        self.sources = {name: every[name] for name in names}
        """Sources by name, in the order of the names."""
        self._heard: list[Record] = []
        self._inputs = (
            (each.at_ns, line, each.input.data)
            for each in sorted(run.log.inputs, key=lambda each: each.at_ns)
            if isinstance(each.input, Bytes)
            and (line := self._port(run.runtime, each.device, each.input.port)) is not None
        )
        self._next = next(self._inputs, None)
        run.listeners.append(self._sent)
        for name in self.sources.keys() & run.runtime.wires.keys():
            wire = run.runtime.wires[name]
            heard = partial(self._carried, self.sources[name], wire.frames) if wire.frames else None
            wire.watchers.append(heard or partial(self._burst, self.sources[name]))

    def _port(self, runtime: BenchRuntime, device: str, port: str) -> Interface | None:
        return self.sources.get(str(Address(device, port))) if device in runtime.devices else None

    def _sent(self, device: Twin, part: str, at_ns: SimTimeNs, data: bytes) -> None:
        if line := self.sources.get(place_of_sender(device, part)):
            self._heard.append(Record(line, at_ns, RecordKind.RX, data, "", 0))

    def _burst(self, line: Interface, event: Any) -> None:
        kind = RecordKind.FRAMING_ERROR if event.is_damaged else RecordKind.RX
        self._heard.append(Record(line, event.at_ns, kind, event.data, event.about, 0))

    def _carried(self, line: Interface, frames: FrameKind, event: Any) -> None:
        self._heard.append(Record(line, event.at_ns, 0, frames.packed(event), event.node, 0))

    def drain(self, until_ns: int, *, is_last: bool) -> list[Record]:
        """Take what has passed up to a time, to which the run has gone, in the order of times; of the latest
        only what is certain, except at the end."""
        while self._next and self._next[0] <= until_ns:
            at_ns, line, data = self._next
            self._heard.append(Record(line, at_ns, RecordKind.TX, data, "", 0))
            self._next = next(self._inputs, None)
        self._heard.sort(key=lambda record: record.at_ns)
        decided_ns = until_ns if is_last else until_ns - LATE_NS
        end = next((at for at, each in enumerate(self._heard) if each.at_ns > decided_ns), len(self._heard))
        taken = self._heard[:end]
        del self._heard[:end]
        return taken


def run_records(
    run: RecordedRun,
    names: Collection[str],
    from_ns: SimTimeNs,
    to_ns: SimTimeNs,
    told: Callable[[int], object] = lambda now_ns: None,
) -> Iterator[Record]:
    """Go through a window, both ends included, and answer what passed in the order of times. ``told``: called
    with the time reached."""
    if from_ns > LATE_NS:  # at time 0 boards have not run yet, and may send something then
        run.run_until(SimTimeNs(from_ns - LATE_NS))
    records = RunRecords(run, names)
    while True:
        now_ns = SimTimeNs(min(run.now_ns + SLICE_NS, to_ns))
        run.run_until(now_ns)
        for record in records.drain(now_ns, is_last=now_ns == to_ns):
            if record.at_ns >= from_ns:
                yield record
        told(now_ns)
        if now_ns >= to_ns:
            break
