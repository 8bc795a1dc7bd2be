"""Names of a run's fields as people write them: ``m1.e``, ``arm.elbow.position_deg``, ``m1.*``."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from hil.core import CoreAxis
from hil.sim.bench import BenchRuntime
from hil.vocab.near_words import meant


class RunField(NamedTuple):
    """Field of the axis at an address."""

    axis: str
    name: str

    def __str__(self) -> str:
        return f"{self.axis}.{self.name}"


class NoSuchField(ValueError):
    """Error of a name that means no field: ``str(error)`` says which there are."""


def parse_fields(runtime: BenchRuntime, texts: Iterable[str]) -> list[RunField]:
    """Read names of fields, each once, in their order; ``*`` for a name means all of the axis.

    Raises:
        NoSuchField: there is none of this name.
    """
    axes = {address: device.axes[name] for address, (device, name) in runtime.parts.axes.items()}
    return [*dict.fromkeys(each for text in texts for each in _fields(runtime, axes, text.strip()))]


def _fields(runtime: BenchRuntime, axes: Mapping[str, CoreAxis], text: str) -> list[RunField]:
    of, dot, name = text.rpartition(".")
    address = runtime.parts.axis_address(of) if dot else None
    if address is None:
        example = next(iter(axes), "m1")
        raise NoSuchField(
            f"{text!r} names no axis: {meant(of or text, axes)}; write it as {example}.position_deg"
        )
    known = [field for field in axes[address].kind.fields if field != "at_ns"]
    if name == "*":
        return [RunField(address, each) for each in known]
    if name not in known:
        raise NoSuchField(f"{address} has no field {name!r}; {meant(name, known)}")
    return [RunField(address, name)]
