"""One thing that can be asked of a bench, as data."""

from collections.abc import Mapping
from enum import Enum, IntEnum
from typing import Any

from hil.vocab.late_dataclass import dataclass
from hil.vocab.parameters import Parameter
from hil.vocab.verbs import Role


class Target(Enum):
    """Kind of target of an operation; the value is its name in requests, and its meaning."""

    BENCH = ("", "the bench")
    DEVICE = ("device", "a device")
    MEMBER = ("device", "a device, or an axis of one: m1, arm.elbow")
    TWIN = ("device", "an axis of a simulated device: m1, arm.elbow")
    UART = ("device", "a device's serial interface: m1, s1.network")
    PLACE = ("target", "where a fault can be: a device, an axis, a port, a segment, a tap")
    TAP = ("tap", "a tap of a segment")
    BUS = ("bus", "a CAN bus")
    CHANNEL = ("channel", "a channel of a CAN bus")
    RUN = ("name", "a run; empty: all that are remembered")

    @property
    def argument(self) -> str:
        """Name of the argument that gives the target in a request; empty: there is none."""
        return self.value[0]


@dataclass(frozen=True)
class Operation:
    """Row of the table of operations. ``takes_time``: its answer may have to be awaited. ``answer``: the form
    of the answer (``hil.net.answers``), None where that is no JSON and only doors in this process can have
    it."""

    name: str
    target: Target
    about: str
    parameters: tuple[Parameter, ...] = ()
    role: Role = Role.OPERATOR
    takes_time: bool = False
    answer: Any = None

    @property
    def arguments(self) -> tuple[str, ...]:
        """Names of a request's arguments: the target's, then the parameters'."""
        named = (self.target.argument,) if self.target.argument else ()
        return (*named, *(parameter.name for parameter in self.parameters))


class Urgency(IntEnum):
    """Classes of requests, the most urgent first: who comes first where many wait."""

    STOP = 0
    COMMAND = 1
    READING = 2


STOP_VERB, OFF_VERB, HALT, STOP_SITE = "stop", "disable", "halt", "stop_site"


def urgency_of(operation: Operation, given: Mapping[str, object]) -> Urgency:
    """Class of a request for an operation. A viewer's are readings, whatever else he asks for is refused."""
    if operation.name == "do":
        return Urgency.STOP if given.get("name") == STOP_VERB else Urgency.COMMAND
    if operation.name in (HALT, STOP_SITE):
        return Urgency.STOP
    return Urgency.READING if operation.role is Role.VIEWER else Urgency.COMMAND


A_RUN = "a run"
"""In the place of an axis's name, for what moves those that its text names."""


def moved_by(operation: Operation, target: str) -> str:
    """Device, or axis of one, that a request tells a verb, or ``A_RUN``; empty: none."""
    if operation.name in ("do", "drive"):
        return target
    return A_RUN if operation.name == "run" else ""
