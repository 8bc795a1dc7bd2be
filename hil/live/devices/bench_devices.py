"""Devices of a bench by name, as operations, doors and runs find them."""

import asyncio
from collections.abc import Iterable, Iterator, Mapping

from hil.sim.bench import BenchRuntime
from hil.vocab.address import address_of, owner_of
from hil.vocab.axis import Axis, AxisNow
from hil.vocab.desk_protocol import DeviceInfo
from hil.vocab.device import Device
from hil.vocab.verbs import VerbRefused


class Devices(dict[str, Device]):
    """Devices by name, in the order of the configuration. Only ``hil.live.apply`` changes them."""

    def order(self, names: Iterable[str]) -> None:
        """Put them into the order of these names."""
        found = {name: self[name] for name in names if name in self}
        self.clear()
        self.update(found)

    def at(self, address: str) -> tuple[Device, str]:
        """Device of an address, and the name of its part. Raises VerbRefused: it has gone meanwhile."""
        name, part = address_of(address)
        if (device := self.get(name)) is None:
            raise VerbRefused("no_device", f"no device {address!r}; a reload has taken it away")
        return device, part

    async def stop(self) -> None:
        """Stop what still moves."""
        await asyncio.gather(*(device.stop() for device in self.values()))

    async def close(self) -> None:
        while self:
            await self.popitem()[1].close()


class DeviceInfos(Mapping[str, DeviceInfo]):
    """Devices, and further axes of them, by address, as doors see them at the moment of the look."""

    def __init__(self, devices: Mapping[str, Device]) -> None:
        self._devices = devices

    def __getitem__(self, address: str) -> DeviceInfo:
        name, part = address_of(address)
        return self._devices[name].info(part)

    def __iter__(self) -> Iterator[str]:
        for device in self._devices.values():
            yield from device.addresses()

    def __len__(self) -> int:
        return sum(1 for _ in self)


class DeviceAxes:
    """Axes of all devices, as ``hil.vocab.axis.Axes``."""

    def __init__(self, devices: Mapping[str, Device], bench: BenchRuntime) -> None:
        self._devices, self._bench = devices, bench

    @property
    def now_ns(self) -> int:
        return self._bench.now_ns

    def axes(self) -> dict[str, AxisNow]:
        return {name: now for device in self._devices.values() for name, now in device.axes().items()}

    def __getitem__(self, address: str) -> Axis:
        return self._devices[owner_of(address)].axis(address_of(address).part)
