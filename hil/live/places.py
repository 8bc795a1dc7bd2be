"""Registry of all places at which bytes enter: UARTs of twins, taps of segments and buses, real boards."""

import logging
from typing import Any

from hil.live.port_link import PortLink
from hil.sim.twin import Twin
from hil.vocab.address import owner_of

log = logging.getLogger("hil")


class Places(dict[str, PortLink[Any]]):
    """Links by address: ``m1`` and ``s1.network`` (a twin's UARTs), ``bus0.master`` (a tap), ``m2`` (a real
    board). In order as they came: of a start UARTs, taps, real boards. Only ``hil.live.apply`` changes
    them."""

    _is_shut = False

    def __setitem__(self, label: str, link: PortLink[Any]) -> None:
        link.is_shut = self._is_shut
        super().__setitem__(label, link)

    def shut(self, is_shut: bool) -> None:
        """Deliver nothing of what clients send from now on, or all again."""
        self._is_shut = is_shut
        for link in self.values():
            link.is_shut, link.undelivered_bytes = is_shut, 0

    def of(self, owner: str) -> list[PortLink[Any]]:
        """Links of a device or a wire: of UARTs, or taps, that have a port."""
        return [link for label, link in self.items() if owner_of(label) == owner]

    def addresses(self) -> list[tuple[str, str]]:
        """Labels of all links, each with the address at which clients reach it."""
        return [(label, link.port.address) for label, link in self.items()]

    def tell_stopped(self, device: Twin) -> None:
        """Say in the log, and at its port, that a device has stopped."""
        again = f"the other devices go on; `hil reset {device.name}` restarts it"
        log.error("%s stopped: %s; %s", device.name, device.failed, again)
        if link := self.get(device.name):
            link.port.write(f"\r\n[hil: {device.name} stopped: {device.failed}]\r\n".encode())

    async def close(self) -> None:
        for link in self.values():
            await link.port.close()
