"""What a device is made of."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from hil.sim.setpoints import TimeOut
from hil.vocab.firmware import Board, Firmware
from hil.vocab.verbs import Verb


@dataclass(frozen=True, kw_only=True)
class DeviceSpec:
    """What a device is, beside its axis.

    ``bauds``: of its UARTs, by their names; None where bytes take no time. All but the main one are made in
    software. ``power_up``: the axis's fields that the power sets beside the core's own, the encoder's
    registers. ``nvm``: named contents of its memory at the start.
    """

    name: str
    profile: str
    firmware: Callable[[Board], Firmware]
    bauds: Mapping[str, int | None]
    nvm: Mapping[str, bytes]
    power_up: Mapping[str, int]
    facts: Mapping[str, int]
    verbs: Mapping[str, Verb] = field(default_factory=dict)
    time_out: TimeOut | None = None
    follow: Callable[..., None] | None = None
