"""Runs an input log again on the virtual clock."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from hil.compose import bench_runtime, find_catalogue
from hil.config import from_dict
from hil.core import Snapshot
from hil.session.bench import BenchRuntime
from hil.session.device import Device
from hil.session.input_log import read_input_log
from hil.testing.bench import MemoryOptions
from hil.vocab.time import SimTimeNs


@dataclass
class Replayed:
    """What the devices did: for each, (simulated time, bytes, state of the axis when it sent them)."""

    runtime: BenchRuntime
    sent: dict[str, list[tuple[SimTimeNs, bytes, Snapshot]]] = field(default_factory=dict)


class _LoggedStore:
    """Answers nothing by itself: the log has the answers."""

    def commit(self, device: Device, sections: Mapping[str, bytes]) -> None:
        return


def replay(log: str | Path, until_ns: SimTimeNs | None = None) -> Replayed:
    """Run the input log of a real-time run again, as far as its last input or to ``until_ns``.

    Raises:
        InputLogError: the file is not an input log.
        ConfigError: its configuration does not fit this program.
    """
    with Path(log).open() as file:
        read = read_input_log(file)
    catalogue = find_catalogue({"memory": MemoryOptions})
    runtime = bench_runtime(from_dict(read.config, catalogue), catalogue, read.memories, _LoggedStore())
    replayed = Replayed(runtime, {name: [] for name in runtime.devices})
    runtime.listeners.append(
        lambda device, at_ns, data: replayed.sent[device.name].append((at_ns, data, device.axis.snapshot()))
    )
    for logged in read.inputs:
        # Devices without a wire between them have times of their own: each is taken to its input's.
        runtime.give_at(runtime.devices[logged.device], logged.input, logged.at_ns)
    if until_ns is not None:
        runtime.advance(until_ns)
    return replayed
