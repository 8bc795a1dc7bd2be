"""Options of the CAN bridge."""

import ipaddress
import re
import socket
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from hil.vocab.address import NAME_PATTERN, Address, address_of, owner_of
from hil.vocab.bridge_protocol import DoorPort, OptionProblem
from hil.vocab.near_words import meant

UDP_PORT = 43113
"""Port of python-can's ``udp_multicast``, its default."""
UDP_GROUP = "239.74.163.2"
"""Group of python-can's ``udp_multicast``, its default of IPv4."""
NO_CAN = "this kernel has no CAN sockets"
LOAD_CAN = "load them, `modprobe -a can_raw vcan`, or take another interface, as udp_multicast"


class Channel(BaseModel):
    """A channel of a bus."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    interface: Literal["virtual", "udp_multicast", "socketcan"] = Field(
        description=(
            "What python-can calls it: `virtual` within this process, `udp_multicast` on this computer or in"
            " its network, `socketcan` a CAN interface of Linux."
        )
    )
    channel: str | None = Field(
        default=None,
        min_length=1,
        description=(
            f"The group's address (null: {UDP_GROUP}), the name of the interface as vcan0, or any text for"
            " virtual (null: the bus's name)."
        ),
    )
    port: int = Field(
        default=UDP_PORT, ge=1, le=65535, description="UDP port of the group; for `udp_multicast` alone."
    )
    insecure: bool = Field(
        default=False,
        description=(
            "Let other computers of the network in, and tell them what is on the bus; for `udp_multicast`"
            " alone. Nobody is asked who it is; log and status say so again."
        ),
    )

    @model_validator(mode="after")
    def _is_meant(self) -> Self:
        if self.interface == "udp_multicast":
            if not _is_group(self.group):
                remedy = f"write one of 224.0.0.0/4 or ff00::/8, as {UDP_GROUP}"
                raise _error("group", f"{self.group} is no multicast address", "channel", remedy)
        elif self.port != UDP_PORT or self.insecure:
            key = "insecure" if self.insecure else "port"
            raise _error("udp", f"{key} is for udp_multicast alone", key, "leave this key out")
        if self.interface == "socketcan" and self.channel is None:
            remedy = "add channel: vcan0, as `ip link` shows it"
            raise _error("interface", "socketcan needs a channel", "interface", remedy)
        return self

    @property
    def group(self) -> str:
        """Address of the group."""
        return self.channel or UDP_GROUP

    def medium(self, bus: str) -> str:
        """Name, for people, what its programs share; two channels of one medium hear each other."""
        if self.interface == "udp_multicast":
            shown = f"[{self.group}]" if ":" in self.group else self.group
            return f"udp_multicast/{shown}:{self.port}"
        return f"{self.interface}/{self.channel or bus}"


def _error(code: str, message: str, key: str, remedy: str) -> PydanticCustomError:
    said = {"why": message, "at": (key,), "remedy": remedy}
    return PydanticCustomError(code, "{why}", said)


def _is_group(text: str) -> bool:
    try:
        return ipaddress.ip_address(text).is_multicast
    except ValueError:
        return False


class Options(BaseModel):
    """Options under ``bridges.can``."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    channels: dict[str, Channel] = Field(
        min_length=1,
        description=(
            "Channels by CAN bus, as in `{can0: {interface: udp_multicast}}`, or by an address there,"
            " `can0.lab`, which its node has; that of `can0` has the interface's name, `can0.udp_multicast`."
        ),
    )

    @property
    def is_open(self) -> bool:
        """True if other computers are let in."""
        return any(channel.insecure for channel in self.channels.values())

    def nodes(self) -> Mapping[str, Address]:
        """Nodes of the channels, by the keys of these."""
        return {
            key: Address(owner_of(key), address_of(key).part or channel.interface)
            for key, channel in self.channels.items()
        }

    def wanted_ports(self) -> Sequence[DoorPort]:
        return ()

    def problems(self, axes: Collection[str]) -> Iterable[OptionProblem]:
        """Channels of one bus that are one node, or hear each other."""
        nodes: dict[Address, str] = {}
        media: dict[tuple[str, str], str] = {}
        for key, node in self.nodes().items():
            medium = self.channels[key].medium(node.owner)
            if not re.fullmatch(NAME_PATTERN, node.part):
                remedy = "a name is a letter a-z and up to 31 more of a-z, 0-9, _ and -"
                yield OptionProblem(("channels", key), f"{node.part!r} is no name", remedy, at_key=True)
            elif (other := nodes.setdefault(node, key)) != key:
                message, remedy = (
                    f"it is the node {node}, as {other} is",
                    f"give it a name, as {node.owner}.lab",
                )
                yield OptionProblem(("channels", key), message, remedy, at_key=True)
            elif (other := media.setdefault((node.owner, medium), key)) != key:
                message = f"{other} is on {medium}, too: each frame would go round forever"
                yield OptionProblem(("channels", key), message, "leave one of them out", at_key=True)

    def bus_problems(self, buses: Collection[str]) -> Iterable[OptionProblem]:
        """Buses that are not there."""
        for key, node in self.nodes().items():
            if node.owner not in buses:
                remedy = meant(node.owner, buses) if buses else "add it under `can:`"
                message = f"there is no CAN bus {node.owner!r}"
                yield OptionProblem(("channels", key), message, remedy, at_key=True)

    def file_problems(self) -> Iterable[OptionProblem]:
        """Interfaces that this computer has not."""
        for key, channel in self.channels.items():
            if channel.interface == "socketcan" and (problem := _no_interface(channel.channel or "")):
                yield OptionProblem(("channels", key, problem[0]), *problem[1:])


def _no_interface(name: str) -> tuple[str, str, str] | None:
    """Key, problem and remedy of a CAN interface of Linux that cannot be used."""
    try:
        socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError:
        return "interface", NO_CAN, LOAD_CAN
    try:
        socket.if_nametoindex(name)
    except OSError:
        known = ", ".join(each for _, each in socket.if_nameindex() if "can" in each) or "none"
        remedy = f"there are {known}; a virtual one: `ip link add {name} type vcan && ip link set {name} up`"
        return "channel", f"there is no interface {name!r}", remedy
    return None
