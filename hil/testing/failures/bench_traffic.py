"""Traffic of a bench in memory: records as a capture has them, and the last of them in words."""

from collections import deque
from collections.abc import Iterable, Iterator

from hil.compose.decoded_item import DecodedItem
from hil.compose.decoding import Decoder, decoded
from hil.config.port_interface import port_interface
from hil.sim.bench import BenchRuntime
from hil.sim.input_log import logged_port
from hil.sim.inputs import Bytes, Logged
from hil.testing.kept_inputs import KeptInputs
from hil.wire.pcapng import Record, RecordKind, frame_record, header, record

SHOWN = 20
"""Number of pieces of each port and wire that a report shows."""
MOST_SOURCES = 16
"""Number of ports and wires that a report shows."""
READ = 20 * SHOWN
"""Number of records of each that are read for them: a board prints a line in several."""


def port_records(kept: KeptInputs, runtime: BenchRuntime, since: int = 0) -> Iterator[Record]:
    """Traffic of the ports of a bench, those on wires excepted. ``since``: number of kept records to leave
    out."""
    lines = {
        (name, logged_port(device, uart)): port_interface(device.uarts.label(name, uart), device, uart)
        for name, device in runtime.devices.items()
        for uart, of in device.uarts.items()
        if of.station is None
    }
    for each in kept.records[since:]:
        if not isinstance(each, Logged):
            at_ns, name, data, port, _ = each
            if line := lines.get((name, port)):
                yield Record(line, at_ns, RecordKind.RX, data, "", 0)
        elif isinstance(each.input, Bytes) and (line := lines.get((each.device, each.input.port))):
            yield Record(line, each.at_ns, RecordKind.TX, each.input.data, "", 0)


def last_of_each(records: Iterable[Record], most: int) -> list[Record]:
    """The last records of each interface."""
    by_line: dict[str, deque[Record]] = {}
    for each in records:
        by_line.setdefault(each.interface, deque(maxlen=most)).append(each)
    return [each for of_line in by_line.values() for each in of_line]


def traffic_lines(records: Iterable[Record]) -> list[str]:
    """The last pieces of each port and wire as `hil decode` words them, in the order of their times, which
    are seconds since the bench's start. Of more than ``MOST_SOURCES`` those that were used last."""
    read = sorted(last_of_each(records, READ), key=lambda each: each.at_ns)
    by_source: dict[str, deque[DecodedItem]] = {}
    for item in decoded(read, Decoder()):
        by_source.setdefault(item.source, deque(maxlen=SHOWN)).append(item)
    latest = sorted(by_source, key=lambda source: by_source[source][-1].at_ns, reverse=True)
    shown = [item for source in latest[:MOST_SOURCES] for item in by_source[source]]
    quiet = ", ".join(source for source in by_source if source in latest[MOST_SOURCES:])
    lines = [item.line(0) for item in sorted(shown, key=lambda item: item.at_ns)]
    return [f"not shown, their last is older: {quiet}", *lines] if quiet else lines


def as_pcapng(records: Iterable[Record], program: str) -> bytes:
    """Capture of the records, with simulated time."""
    ordered = sorted(records, key=lambda each: each.at_ns)
    lines = {each.interface: each.line for each in ordered}
    numbers: dict[str, int] = {name: number for number, name in enumerate(lines)}
    blocks = [_block(numbers[each.interface], each) for each in ordered]
    return b"".join([header(program, [*lines.values()]), *blocks])


def _block(number: int, each: Record) -> bytes:
    if each.line.is_serial:
        return record(number, each.at_ns, RecordKind(each.event), each.data, each.comment)
    return frame_record(number, each.at_ns, each.data, each.comment)
