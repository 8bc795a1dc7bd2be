"""Options of the CAN bridge."""

import ipaddress
import socket
from collections.abc import Collection, Iterable, Sequence
from difflib import get_close_matches
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from hil.vocab.address import NAME_PATTERN
from hil.vocab.bridge_protocol import DoorPort, OptionProblem

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
    name: str | None = Field(
        default=None,
        pattern=NAME_PATTERN,
        description="Name of its node on the bus, behind the bus's, as can0.master; null: the interface's.",
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

    @property
    def node(self) -> str:
        """Name of its node behind the bus's."""
        return self.name or self.interface

    def medium(self, bus: str) -> str:
        """What its programs share, for people; two channels of one medium hear each other."""
        if self.interface == "udp_multicast":
            shown = f"[{self.group}]" if ":" in self.group else self.group
            return f"udp_multicast {shown}:{self.port}"
        return f"{self.interface} {self.channel or bus}"


def _error(code: str, message: str, key: str, remedy: str) -> PydanticCustomError:
    said = {"why": message, "at": (key,), "remedy": remedy}
    return PydanticCustomError(code, "{why}", said)


def _is_group(text: str) -> bool:
    try:
        return ipaddress.ip_address(text).is_multicast
    except ValueError:
        return False


def _list(value: Any) -> Any:
    """Read a channel as a list of one."""
    return [value] if isinstance(value, dict) else value


Channels = Annotated[list[Channel], BeforeValidator(_list), Field(min_length=1, max_length=16)]


class Options(BaseModel):
    """Options under ``bridges.can``."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    channels: dict[str, Channels] = Field(
        min_length=1,
        description=("Channels by CAN bus, one or a list, as in `{can0: {interface: udp_multicast}}`."),
    )

    @property
    def is_open(self) -> bool:
        """True if other computers are let in."""
        return any(channel.insecure for channels in self.channels.values() for channel in channels)

    def wanted_ports(self) -> Sequence[DoorPort]:
        return ()

    def problems(self, axes: Collection[str]) -> Iterable[OptionProblem]:
        """Channels of one bus that have one name, or hear each other."""
        for bus, channels in self.channels.items():
            names: dict[str, int] = {}
            media: dict[str, int] = {}
            for at, channel in enumerate(channels):
                path = ("channels", bus) if len(channels) == 1 else ("channels", bus, at)
                if (medium := channel.medium(bus)) in media:
                    message = f"{bus} has two channels on {medium}: each frame would go round for ever"
                    yield OptionProblem(path, message, "leave one of them out")
                elif channel.node in names:
                    message = f"{bus} has two channels {channel.node}"
                    yield OptionProblem(path, message, "give one of them another `name`")
                names[channel.node], media[medium] = at, at

    def bus_problems(self, buses: Collection[str]) -> Iterable[OptionProblem]:
        """Buses that are not there."""
        for bus in self.channels:
            if bus not in buses:
                near = get_close_matches(bus.lower(), buses, n=1)
                meant = f'did you mean "{near[0]}"? ' if near else ""
                known = f"there are {', '.join(buses)}" if buses else "add it under `can:`"
                message = f"there is no CAN bus {bus!r}"
                yield OptionProblem(("channels", bus), message, f"{meant}{known}", at_key=True)

    def file_problems(self) -> Iterable[OptionProblem]:
        """Interfaces that this computer has not."""
        for bus, channels in self.channels.items():
            for at, channel in enumerate(channels):
                if channel.interface == "socketcan" and (problem := _no_interface(channel.channel or "")):
                    path = ("channels", bus) if len(channels) == 1 else ("channels", bus, at)
                    yield OptionProblem((*path, problem[0]), *problem[1:])


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
