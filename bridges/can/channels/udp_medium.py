"""A group of UDP, in which programs with python-can's ``udp_multicast`` are.

A program hears what it sends itself, as everybody in the group does: what comes from the socket that sends
here is left out. Without leave only programs of this computer are heard, and nothing goes further.
"""

import asyncio
import logging
import socket
from typing import Any

from bridges.can.channels.channel_medium import AT_A_TIME, Take, frame_of, message_of
from bridges.can.frames.can_frame import CanFrame
from hil.vocab.bridge_protocol import BridgeError

NO_NETWORK = "without a network, `ip link set lo multicast on; ip route add 224.0.0.0/4 dev lo` makes one"
NEIGHBOURS = 1
"""Hop limit that reaches the computers of this network."""

log = logging.getLogger("hil")


class UdpMedium:
    """Group at an address and port. ``is_open``: for other computers too. A
    ``bridges.can.channels.channel_medium.Medium``."""

    def __init__(self, group: str, port: int, *, is_open: bool) -> None:
        self._group, self._port = group, port
        self._is_open = is_open
        self.rejected = self.strangers = 0
        self.failure = ""
        self._bus: Any = None
        self._sender: socket.socket | None = None
        self._own: tuple[Any, ...] = ()
        self._hosts: set[str] = set()
        self._take: Take = lambda frames: None
        self._loop: asyncio.AbstractEventLoop | None = None

    def open(self, loop: asyncio.AbstractEventLoop, take: Take) -> None:
        from can import CanInitializationError
        from can.interfaces.udp_multicast.bus import GeneralPurposeUdpMulticastBus

        self._loop, self._take = loop, take
        hops = NEIGHBOURS if self._is_open else 0
        try:
            self._bus = GeneralPurposeUdpMulticastBus(self._group, self._port, hops)
            self._sender = _sender(self._group, self._port, hops)
        except (CanInitializationError, OSError) as error:
            self._shut()
            cause = error.__cause__ or error
            why = getattr(cause, "strerror", None) or str(cause)
            raise BridgeError(f"{self._group}: {why}; {NO_NETWORK}") from None
        self._own = self._sender.getsockname()[:2]
        self._hosts = {_host(self._own[0]), "127.0.0.1", "::1"}
        self.hold(False)

    def hold(self, is_held: bool) -> None:
        if self._loop and self._bus:
            if is_held:
                self._loop.remove_reader(self._bus.fileno())
            else:
                self._loop.add_reader(self._bus.fileno(), self._read)

    def send(self, frame: CanFrame, at_s: float) -> bool:
        from can.interfaces.udp_multicast.utils import pack_message

        if not self._sender:
            return False
        try:
            self._sender.send(pack_message(message_of(frame, at_s)))
        except OSError:
            return False
        return True

    async def close(self) -> None:
        if self._loop and self._bus:
            self._loop.remove_reader(self._bus.fileno())
        self._shut()

    def _shut(self) -> None:
        if self._bus:
            self._bus.shutdown()
        if self._sender:
            self._sender.close()
        self._bus = self._sender = None

    def _read(self) -> None:
        from can import CanOperationError

        frames = []
        for _ in range(AT_A_TIME):
            try:
                if not (received := self._bus.recv(0)):
                    break
            except (CanOperationError, OSError) as error:
                self._fail(str(error))
                break
            data, sender, _ = received
            if sender[:2] == self._own:
                continue
            if not self._is_open and _host(sender[0]) not in self._hosts:
                self.strangers += 1
            elif frame := _unpacked(data):
                frames.append(frame)
            else:
                self.rejected += 1
        if frames:
            self._take(frames)

    def _fail(self, why: str) -> None:
        self.failure = why
        log.error("can: udp_multicast %s: %s; nothing comes from it any more", self._group, why)
        self.hold(True)


def _sender(group: str, port: int, hops: int) -> socket.socket:
    """Make a socket that sends to a group and never waits; its address tells its own packets."""
    is_v6 = ":" in group
    made = socket.socket(socket.AF_INET6 if is_v6 else socket.AF_INET, socket.SOCK_DGRAM)
    try:
        if is_v6:
            made.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_MULTICAST_HOPS, hops)
        else:
            made.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, hops)
        made.connect((group, port))
        made.setblocking(False)
    except OSError:
        made.close()
        raise
    return made


def _host(address: str) -> str:
    return address.partition("%")[0]


def _unpacked(data: bytes) -> CanFrame | None:
    from can.interfaces.udp_multicast.utils import unpack_message

    try:
        return frame_of(unpack_message(data, check=True))
    except Exception:  # whatever anybody has sent to the group
        return None
