"""Devices of a bench as doors see them."""

from collections.abc import Iterator, Mapping
from functools import lru_cache

from hil.core import AxisKind
from hil.core.fields import FIELDS, OFFSETS
from hil.live.configured import Configured
from hil.live.places import Places
from hil.sim.bench import BenchRuntime
from hil.sim.settable import SETTABLE
from hil.vocab.address import Address, address_of
from hil.vocab.desk_protocol import AxisField, DeviceInfo
from hil.vocab.profile import Profile
from hil.vocab.verbs import Verb


class Devices(Mapping[str, DeviceInfo]):
    """Devices, and further axes of them, by address, of the configuration at the moment of the look."""

    def __init__(self, sim: BenchRuntime, places: Places, configured: Configured) -> None:
        self._sim = sim
        self._drives = places.drives
        self._configured = configured

    def __getitem__(self, address: str) -> DeviceInfo:
        name, part = address_of(address)
        device = self._configured.config.devices[name]
        if not part and (control := self._drives.get(name)):
            drive = control.drive
            return DeviceInfo(name, device.profile, True, drive.verbs, drive.fields)
        board = self._configured.catalogue.boards[device.profile]
        if device.at is not None and not part:
            return _real(name, device.profile, board)
        if device.at is not None or (part not in (axes := self._sim.devices[name].axes) and part):
            raise KeyError(address)
        kind = axes[part].kind if axes else None
        return twin_info(axes.label(name, part), device.profile, board, kind)

    def __iter__(self) -> Iterator[str]:
        for name, device in self._configured.config.devices.items():
            yield name
            axes = list(self._sim.devices[name].axes) if device.at is None else []
            yield from (str(Address(name, axis)) for axis in axes[1:])

    def __len__(self) -> int:
        return sum(1 for _ in self)


@lru_cache(2048)
def twin_info(address: str, profile: str, board: Profile, kind: AxisKind | None) -> DeviceInfo:
    """Describe a device with its first axis, or another of its axes."""
    is_other, has_axis = bool(address_of(address).part), kind is not None
    table = {name: verb for name, verb in board.table.items() if board.uarts or name != "type"}
    verbs = {name: verb for name, verb in table.items() if _can(verb, is_other, has_axis)}
    if kind is None:
        return DeviceInfo(address, profile, False, verbs, {})
    return DeviceInfo(address, profile, False, verbs, _fields(kind, board.shown_first), _inputs(kind))


def _can(verb: Verb, is_other: bool, has_axis: bool) -> bool:
    """True if a verb can be asked at an address: of a device, or of another axis than its first
    (``is_other``), which takes only verbs of axes."""
    is_of_axis = verb.is_of_axis or verb.name == "pin"
    return is_of_axis if is_other else has_axis or not is_of_axis


@lru_cache(2048)
def _real(name: str, profile: str, board: Profile) -> DeviceInfo:
    table, dialogues = board.table, board.dialogues
    verbs = {verb: each for verb, each in table.items() if verb == "type" or verb in dialogues}
    return DeviceInfo(name, profile, True, verbs, {})


@lru_cache
def _fields(kind: AxisKind, shown_first: tuple[str, ...]) -> Mapping[str, AxisField]:
    return {
        name: AxisField(name, f.type, f.unit, f.meaning, OFFSETS[name], name in SETTABLE, name in shown_first)
        for name, f in FIELDS.items()
        if name in kind.fields
    }


@lru_cache
def _inputs(kind: AxisKind) -> Mapping[str, str]:
    names: dict[int, list[str]] = {}
    for name, number in kind.inputs.items():
        names.setdefault(number, []).append(name)
    inputs = {}
    for _, pin in sorted(names.items()):
        told = {name: field for name in pin if (field := f"pin_{name.lower()}") in kind.fields}
        name = next(iter(told), pin[0])
        inputs[name] = told.get(name, "")
    return inputs
