"""Registry of all places at which bytes enter: UARTs of twins, taps of segments and buses, real boards."""

import logging
from collections.abc import Iterator
from itertools import chain
from typing import Any

from hil.live.board_end import BoardEnd
from hil.live.port_joint import Joint
from hil.live.sim_ends import TapEnd, UartEnd
from hil.sim.twin import Twin
from hil.vocab.address import owner_of

log = logging.getLogger("hil")


class Places:
    """Joints by address: ``m1`` and ``s1.network`` (a twin's UARTs), ``bus0.master`` (a tap), ``m2`` (a real
    board). In order: UARTs, taps, real boards, each as they came. Only ``hil.live.apply`` changes them."""

    def __init__(self) -> None:
        self.uarts: dict[str, Joint[UartEnd]] = {}
        self.taps: dict[str, Joint[TapEnd]] = {}
        self.boards: dict[str, Joint[BoardEnd]] = {}

    def __getitem__(self, label: str) -> Joint[Any]:
        """Joint of a label. Raises KeyError: there is no such place."""
        return self.uarts.get(label) or self.taps.get(label) or self.boards[label]

    def __contains__(self, label: object) -> bool:
        return label in self.uarts or label in self.taps or label in self.boards

    def __iter__(self) -> Iterator[str]:
        return chain(self.uarts, self.taps, self.boards)

    def joints(self) -> Iterator[Joint[Any]]:
        return chain(self.uarts.values(), self.taps.values(), self.boards.values())

    def of_device(self, name: str) -> list[Joint[Any]]:
        """Joints of a device: those of a twin's UARTs that have a port, or that of a real board."""
        joints: Iterator[Joint[Any]] = chain(self.uarts.values(), self.boards.values())
        return [joint for joint in joints if owner_of(joint.label) == name]

    def remove(self, label: str) -> None:
        """Remove the joint of a device."""
        self.uarts.pop(label, None)
        self.boards.pop(label, None)

    def addresses(self) -> list[tuple[str, str]]:
        """Labels of all joints, each with the address at which clients reach it."""
        return [(joint.label, joint.port.address) for joint in self.joints()]

    def tell_stopped(self, device: Twin) -> None:
        """Say in the log, and at its port, that a device has stopped."""
        again = f"the other devices go on; `hil reset {device.name}` restarts it"
        log.error("%s stopped: %s; %s", device.name, device.failed, again)
        if joint := self.uarts.get(device.name):
            joint.port.write(f"\r\n[hil: {device.name} stopped: {device.failed}]\r\n".encode())

    async def close(self) -> None:
        for joint in self.joints():
            await joint.port.close()
