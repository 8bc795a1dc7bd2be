"""A recorded run as MCAP, which Foxglove, PlotJuggler and Rerun plot: needs the extra ``mcap``."""

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, BinaryIO, NamedTuple

from hil.compose.decoded_item import DecodedItem
from hil.compose.decoding import Decoder
from hil.recorded.exports import mcap_messages as messages
from hil.recorded.exports.capture_export import epoch_ns
from hil.recorded.exports.run_records import RunRecords, record_sources
from hil.recorded.recorded_fields import RunField
from hil.recorded.recorded_run import RecordedRun
from hil.recorded.run_events import RunEvent, input_event
from hil.recorded.sampled import sampled
from hil.telemetry.sampler import Interval
from hil.vocab.time import NS_PER_S, SimTimeNs

if TYPE_CHECKING:
    from hil.recorded.exports.mcap_chunks import McapFile

_FAULTS = ("inject", "clear")
_NOT_TOLD = ("bytes", "play")
"""Inputs that the channels of ports and wires have."""


class McapContent(NamedTuple):
    """Content of a file: fields of axes, and ports and wires by name. ``has_inputs``: faults, verbs and the
    log too."""

    fields: Sequence[RunField]
    sources: Sequence[str]
    has_inputs: bool = True


def write_mcap(
    file: BinaryIO,
    run: RecordedRun,
    content: McapContent,
    from_ns: SimTimeNs,
    to_ns: SimTimeNs,
    interval_ns: Interval,
    told: Callable[[int], object] = lambda now_ns: None,
) -> int:
    """Write a window of a run that is at its beginning; answers the number of messages. Times are simulated,
    counted from the wall's at 0 if the log has it, else from 0. ``told``: called with the time reached.

    Raises:
        OSError: it cannot be written.
    """
    from hil.recorded.exports.mcap_chunks import McapFile

    made = McapFile(file, run.log.program)
    since_ns = epoch_ns(run)
    of_axes: dict[str, list[str]] = {}
    for field in content.fields:
        of_axes.setdefault(field.axis, []).append(field.name)
    axes = {
        axis: (
            made.channel(f"/axis/{axis}/state", f"hil.state.{axis}", messages.axis_schema(names)),
            messages.AxisTexts(names),
        )
        for axis, names in of_axes.items()
    }
    passing = _Passing(made, run, content.sources, from_ns, since_ns)
    inputs = _Inputs(made, run, since_ns) if content.has_inputs else None
    if axes:
        for chunk in sampled(run, content.fields, from_ns, to_ns, interval_ns):
            channel, texts = axes[chunk.axis]
            made.add(channel, texts.texts(chunk.rows, since_ns))
            passing.write(run.now_ns)
            told(run.now_ns)
    while run.now_ns < to_ns:
        run.run_until(SimTimeNs(min(run.now_ns + NS_PER_S, to_ns)))
        passing.write(run.now_ns)
        told(run.now_ns)
    passing.write(to_ns, is_last=True)
    if inputs:  # which verbs were refused is known now
        inputs.write(from_ns, to_ns)
    made.finish()
    return made.messages


class _Passing:
    """Bytes at ports, packets and frames of wires, each on a channel of its own."""

    def __init__(
        self, made: "McapFile", run: RecordedRun, names: Sequence[str], from_ns: int, since_ns: int
    ) -> None:
        self._made, self._from_ns, self._since_ns = made, from_ns, since_ns
        every = record_sources(run.runtime)
        self._records = RunRecords(run, names)
        self._decoders: dict[str, tuple[int, Decoder]] = {}
        self._ports: dict[str, int] = {}
        for name in names:
            line = every[name]
            if name in run.runtime.wires:
                kind = "can" if line.is_can else "segment" if line.is_serial else "wire"
                topic = f"/{kind}/{name}/{'packets' if line.is_serial else 'frames'}"
                number = made.channel(topic, "hil.packet", messages.PACKET_SCHEMA)
                self._decoders[name] = number, Decoder()
            else:
                for way in ("rx", "tx"):
                    topic = f"/port/{name}/{way}"
                    self._ports[topic] = made.channel(topic, "hil.port", messages.BYTES_SCHEMA)

    def write(self, until_ns: int, *, is_last: bool = False) -> None:
        """Write what has passed up to a time, to which the run has gone."""
        for record in self._records.drain(until_ns, is_last=is_last):
            if record.interface in self._decoders:
                channel, decoder = self._decoders[record.interface]
                self._add(channel, decoder.feed(record))
            elif record.at_ns >= self._from_ns:
                channel = self._ports[messages.port_topic(record.line, record.event)]
                self._made.add(channel, [(self._since_ns + record.at_ns, messages.bytes_text(record))])
        if is_last:
            for channel, decoder in self._decoders.values():
                self._add(channel, decoder.silence())

    def _add(self, channel: int, items: Iterable[DecodedItem]) -> None:
        texts = [(self._since_ns + item.at_ns, messages.item_text(item)) for item in items]
        self._made.add(channel, [text for text in texts if text[0] >= self._since_ns + self._from_ns])


class _Inputs:
    """Faults, verbs, other inputs, and all of them as lines of a log."""

    def __init__(self, made: "McapFile", run: RecordedRun, since_ns: int) -> None:
        self._made, self._run, self._since_ns = made, run, since_ns
        self._faults = made.channel("/faults", "hil.fault", messages.FAULT_SCHEMA)
        self._verbs = made.channel("/verbs", "hil.verb", messages.VERB_SCHEMA)
        self._others = made.channel("/inputs", "hil.input", messages.INPUT_SCHEMA)
        self._log = made.channel("/log", "foxglove.Log", messages.LOG_SCHEMA)
        self._kinds: dict[int, str] = {}

    def write(self, from_ns: SimTimeNs, to_ns: SimTimeNs) -> None:
        """Write those of a window, to whose end the run has gone."""
        inputs, refused = self._run.log.inputs, dict(self._run.refused)
        for index in sorted(range(len(inputs)), key=lambda index: inputs[index].at_ns):
            event = input_event(inputs[index])
            if event.what not in _NOT_TOLD:
                refusal = str(refused.get(index, ""))
                channel, level, data = self._message(event, refusal)
                if from_ns <= event.at_ns <= to_ns:
                    at_ns = self._since_ns + event.at_ns
                    words = f"{event.words()}: refused: {refusal}" if refusal else event.words()
                    self._made.add(channel, [(at_ns, data)])
                    self._made.add(self._log, [(at_ns, messages.log_text(at_ns, level, event.at, words))])

    def _message(self, event: RunEvent, refusal: str) -> tuple[int, int, bytes]:
        """Channel, level in the log, and text of an input."""
        if event.what in _FAULTS:
            return self._faults, messages.WARNING, messages.fault_text(event, self._kinds)
        if event.what == "do":
            level = messages.WARNING if refusal else messages.INFO
            return self._verbs, level, messages.verb_text(event, refusal)
        level = messages.ERROR if event.what == "stopped" or refusal else messages.INFO
        return self._others, level, messages.input_text(event)
