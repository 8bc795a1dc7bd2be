"""Events of a recorded run within a window: what came to its boards, and what they sent."""

import json
from collections.abc import Iterator
from typing import Any, NamedTuple

from hil.recorded.recorded_run import RecordedRun
from hil.recorded.time_words import time_text
from hil.sim.inputs import Logged, encode_line
from hil.sim.twin import Twin
from hil.vocab.address import Address
from hil.vocab.faults import TIMING
from hil.vocab.shown_text import printable
from hil.vocab.time import SimTimeNs

_HEAD = {"at_ns", "device", "input"}
_SEEN_OF = 60
"""Maximum characters of a list in an input's words: a path or a train may have thousands."""


class RunEvent(NamedTuple):
    """Event of a run. ``at``: the address that it concerns; ``what``: ``sent``, or the kind of the input as
    the log has it; ``values``: the input's fields, or the bytes sent in hexadecimal digits."""

    at_ns: SimTimeNs
    at: str
    what: str
    values: dict[str, Any]

    def line(self) -> str:
        """One line for people: time, address, direction, and what it was."""
        arrow = "->" if self.what == "sent" else "<-"
        return f"{time_text(self.at_ns):17}  {self.at:12}  {arrow} {self.words()}".rstrip()

    def words(self) -> str:
        """Words of the event, without its time and place."""
        values = self.values
        match self.what:
            case "sent" | "bytes":
                return bytes_words(bytes.fromhex(values["data"]))
            case "inject":
                return fault_words(values["kind"], dict(values["parameters"]), f"fault {values['number']}: ")
            case "clear":
                return f"fault {values['number']} is cleared"
            case "do":
                given = [f"{name}={_short(value)}" for name, value in values["parameters"]]
                later = values.get("later_ns")
                return " ".join([values["verb"], *given, *([f"at {later} ns"] if later else [])])
            case "commit_done":
                return "memory written" if values["durable"] else "memory not written"
            case "pin":
                return f"pin {values['pin']} is {values['level']}"
            case "set_field":
                return f"set {values['field']}={_short(values['value'])}"
        return " ".join([self.what, *(f"{name}={_short(value)}" for name, value in values.items())])


def fault_words(kind: str, parameters: dict[str, Any], head: str = "") -> str:
    """Words of a fault as they are typed, without those of its timing that say nothing."""
    timing = {each.name: each.default for each in TIMING}
    said = [f"{name}={_short(value)}" for name, value in parameters.items() if value != timing.get(name)]
    return " ".join([f"{head}{kind}", *said])


def bytes_words(data: bytes) -> str:
    """Bytes as text in quotes, with escapes for what is none."""
    return repr(data)[1:]


def _short(value: object) -> str:
    text = f"{value:.15g}" if isinstance(value, float) else str(value)
    return printable(text if len(text) <= _SEEN_OF else f"{text[:_SEEN_OF]}...")


def place_of_sender(device: Twin, port: str) -> str:
    """Address of a UART or a card that sends, as ``RecordedRun.listeners`` are told it."""
    return device.uarts.label(device.name, port) if port in device.uarts else str(Address(device.name, port))


def input_event(logged: Logged) -> RunEvent:
    """Event of an input."""
    values = json.loads(encode_line(logged))
    own = {name: value for name, value in values.items() if name not in _HEAD}
    at = str(Address(logged.device, own.pop("port", "")))
    return RunEvent(logged.at_ns, at, values["input"], own)


def events(run: RecordedRun, from_ns: SimTimeNs, to_ns: SimTimeNs) -> Iterator[RunEvent]:
    """Go through a run to a time, and answer the events of the window, both ends included, in the order of
    their times."""
    sent: list[RunEvent] = []

    def heard(device: Twin, port: str, at_ns: SimTimeNs, data: bytes) -> None:
        if from_ns <= at_ns <= to_ns:
            sent.append(RunEvent(at_ns, place_of_sender(device, port), "sent", {"data": data.hex()}))

    run.listeners.append(heard)
    run.run_until(to_ns)
    run.listeners.remove(heard)
    given = [input_event(each) for each in run.log.inputs if from_ns <= each.at_ns <= to_ns]
    yield from sorted([*given, *sent], key=lambda event: event.at_ns)
