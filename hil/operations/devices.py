"""Devices of a bench as doors see them."""

from collections.abc import Iterator, Mapping
from functools import lru_cache

from hil.compose.find import load_dialogues, load_verbs
from hil.core.fields import FIELDS, OF_KIND, OFFSETS
from hil.live.configured import Configured
from hil.sim.bench import BenchRuntime
from hil.sim.settable import SETTABLE
from hil.vocab.desk_protocol import AxisField, DeviceInfo

STATE = (
    *("at_ns", "position_deg", "yw", "velocity_rpm", "torque_Nm"),
    *("loop_on", "mode", "r", "u", "following"),
    *("commanded_deg", "lag_steps", "lost_steps", "motion_state", "speed_rpm", "queue_position", "pending"),
)
"""Fields of an axis in its short state; each kind has some of them."""


class Devices(Mapping[str, DeviceInfo]):
    """Devices by name, of the configuration at the moment of the look."""

    def __init__(self, sim: BenchRuntime, configured: Configured) -> None:
        self._sim = sim
        self._configured = configured

    def __getitem__(self, name: str) -> DeviceInfo:
        device = self._configured.config.devices[name]
        kind = None if device.at is not None else self._sim.devices[name].axis.kind
        return _info(name, device.profile, kind)

    def __iter__(self) -> Iterator[str]:
        return iter(self._configured.config.devices)

    def __len__(self) -> int:
        return len(self._configured.config.devices)


@lru_cache(2048)
def _info(name: str, profile: str, kind: int | None) -> DeviceInfo:
    table = load_verbs(profile).table
    if kind is not None:
        return DeviceInfo(name, profile, False, table, _fields(kind))
    dialogues = load_dialogues(profile)
    verbs = {verb: each for verb, each in table.items() if verb == "type" or verb in dialogues}
    return DeviceInfo(name, profile, True, verbs, {})


@lru_cache
def _fields(kind: int) -> Mapping[str, AxisField]:
    return {
        name: AxisField(name, f.type, f.unit, f.meaning, OFFSETS[name], name in SETTABLE, name in STATE)
        for name, f in FIELDS.items()
        if name in OF_KIND[kind]
    }
