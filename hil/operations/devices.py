"""Devices of a bench as doors see them."""

from collections.abc import Iterator, Mapping
from functools import lru_cache

from hil.live.configured import Configured
from hil.live.places import Places
from hil.sim.bench import BenchRuntime
from hil.sim.twin_info import info_of
from hil.vocab.address import Address, address_of
from hil.vocab.desk_protocol import DeviceInfo
from hil.vocab.profile import Profile


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
        if device.at is not None or (part and part not in self._sim.devices[name].axes):
            raise KeyError(address)
        return info_of(self._sim.devices[name], part, board)

    def __iter__(self) -> Iterator[str]:
        for name, device in self._configured.config.devices.items():
            yield name
            axes = list(self._sim.devices[name].axes) if device.at is None else []
            yield from (str(Address(name, axis)) for axis in axes[1:])

    def __len__(self) -> int:
        return sum(1 for _ in self)


@lru_cache(2048)
def _real(name: str, profile: str, board: Profile) -> DeviceInfo:
    table, dialogues = board.table, board.dialogues
    verbs = {verb: each for verb, each in table.items() if verb == "type" or verb in dialogues}
    return DeviceInfo(name, profile, True, verbs, {})
