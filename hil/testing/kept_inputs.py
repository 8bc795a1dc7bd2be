"""Inputs of a bench in memory, and its input log of them when one is wanted."""

from collections.abc import Mapping

from hil import __version__
from hil.compose.simulated_config import as_simulated
from hil.config import BenchConfig
from hil.sim.input_log import InputLog, InputLogSink, InputLogWriter, Sent, SentRecord, logged_port
from hil.sim.inputs import Logged
from hil.sim.log_checks import LineSink
from hil.sim.twin import Twin
from hil.vocab.time import SimTimeNs


class KeptInputs:
    """Inputs of a bench with their times, and what its devices sent, from its start on. No text is made until
    one is asked for, and states of axes are not kept: a replay compares bytes and times.

    ``memories``: of the devices at the start; ``also``: another receiver of all of it."""

    def __init__(
        self,
        config: BenchConfig,
        memories: Mapping[str, Mapping[str, bytes]],
        also: InputLogSink | None = None,
    ) -> None:
        self.records: list[Logged | SentRecord] = []
        """Inputs and what was sent, in the order in which they came."""
        self._config, self._also = config, also
        self._memories = {name: dict(sections) for name, sections in memories.items()}

    @property
    def inputs(self) -> list[Logged]:
        """Inputs alone, in their order."""
        return [record for record in self.records if isinstance(record, Logged)]

    def write(self, logged: Logged) -> None:
        self.records.append(logged)
        if self._also:
            self._also.write(logged)

    def sent(self, device: Twin, port: str, at_ns: SimTimeNs, data: bytes) -> None:
        """Keep what a device sent; a bench's listener."""
        self.records.append((at_ns, device.name, data, logged_port(device, port), None))
        if self._also:
            self._also.sent(device, port, at_ns, data)

    def log(self) -> InputLog:
        """Input log so far, as it would be read back."""
        inputs = self.inputs
        pieces = (record for record in self.records if not isinstance(record, Logged))
        sent = [Sent(at_ns, name, data, state=None, port=port) for at_ns, name, data, port, _ in pieces]
        return InputLog(as_simulated(self._config), self._memories, inputs, sent, lines=[0] * len(inputs))

    def write_to(self, file: LineSink) -> None:
        """Write the input log so far, with its end, as `hil serve --log` does; `hil replay` takes it."""
        config = as_simulated(self._config)
        log = InputLogWriter(file, f"hil {__version__}", config, self._memories, later=lambda waiting: None)
        for record in self.records:
            log.add(record)
        log.end()
