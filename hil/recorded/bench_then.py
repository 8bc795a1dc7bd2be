"""A recorded bench as it was at a time: states of its axes, last words at its ports, faults."""

from dataclasses import asdict, dataclass
from typing import Any

from hil.recorded.recorded_run import RecordedRun
from hil.recorded.run_events import bytes_words, place_of_sender
from hil.sim.twin import Twin
from hil.vocab.time import SimTimeNs

LAST_BYTES = 400
"""Maximum bytes that are kept of what a port sent last."""


@dataclass(frozen=True)
class BenchThen:
    """State of a bench at a time. ``axes``: fields of each by its address; ``words``: the last bytes that
    were sent at each place; ``faults``: those in force or still to begin; ``failed``: devices that had
    stopped, and why; ``absent``: real boards, which no replay has, with where they were."""

    at_ns: SimTimeNs
    axes: dict[str, dict[str, float]]
    words: dict[str, bytes]
    faults: list[dict[str, Any]]
    failed: dict[str, str]
    absent: dict[str, str]

    def values(self) -> dict[str, Any]:
        """Values for programs: bytes as hexadecimal digits, a value that is not finite as None."""
        axes = {
            axis: {name: value if abs(value) < float("inf") else None for name, value in fields.items()}
            for axis, fields in self.axes.items()
        }
        words = {place: {"text": bytes_words(data), "hex": data.hex()} for place, data in self.words.items()}
        return asdict(self) | {"axes": axes, "words": words}


def bench_then(run: RecordedRun, at_ns: SimTimeNs) -> BenchThen:
    """Go to a time, and tell how the bench is there."""
    words: dict[str, bytes] = {}

    def heard(device: Twin, port: str, at_ns: SimTimeNs, data: bytes) -> None:
        place = place_of_sender(device, port)
        words[place] = (words.get(place, b"") + data)[-LAST_BYTES:]

    run.listeners.append(heard)
    run.run_until(at_ns)
    run.listeners.remove(heard)
    runtime, faults = run.runtime, run.runtime.faults
    return BenchThen(
        at_ns,
        {axis: runtime.snapshot(axis).as_dict() for axis in runtime.parts.axes},
        words,
        [
            {"number": number, **asdict(fault), "begin_ns": faults.begin_ns[number]}
            for number, fault in faults.active.items()
        ],
        {name: device.failed for name, device in runtime.devices.items() if device.failed},
        {name: str(device.at) for name, device in run.config.real.items()},
    )
