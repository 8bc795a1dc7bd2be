"""Addresses of real CANopen drives: ``can+socketcan://can0?node=5`` and others, see ``EXAMPLES``.

Sources: CiA 301 V4.2.0 (nodes 1 to 127); Lawicel's CANUSB manual (bit rates S0 to S8); python-can's
documentation of its interfaces (port of udp_multicast, speed of serial adapters).
"""

import re
from dataclasses import dataclass

from hil.wire.address_keys import AddressRefused, query_keys, whole_number, with_key

SOCKETCAN, SLCAN, MULTICAST = "can+socketcan", "can+slcan", "can+udp_multicast"
EXAMPLES = {
    SOCKETCAN: "can+socketcan://can0?node=5",
    SLCAN: "can+slcan:///dev/ttyACM0?bitrate=1000000&node=5",
    MULTICAST: "can+udp_multicast://239.74.163.2?node=5",
}
NODES = range(1, 128)
BAUD, LEAST_BAUD, MOST_BAUD = 115_200, 300, 4_000_000
MULTICAST_PORT, MOST_PORT = 43113, 65535
_KEYS = {
    SOCKETCAN: ("node", "master"),
    SLCAN: ("node", "master", "bitrate", "baud"),
    MULTICAST: ("node", "master"),
}
_INTERFACE = re.compile(r"[^\s/:?]{1,15}/?")
_GROUP = re.compile(
    r"(?:\[(?P<ipv6>[fF]{2}[0-9A-Fa-f:.]+)\]|(?P<ipv4>[0-9]+(?:\.[0-9]+){3}))(?::(?P<port>[0-9]+))?/?"
)
_TCP = re.compile(r"(?P<host>\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9._-]+):(?P<port>[0-9]+)/?")


@dataclass(frozen=True)
class CanPlace:
    """CAN bus, or the adapter to one. ``interface``: python-can's name of the kind; ``bit_rate``, ``baud``:
    of an adapter at a serial line; ``port``: of a group of multicast."""

    interface: str
    channel: str
    bit_rate: int | None = None
    baud: int | None = None
    port: int | None = None

    @property
    def where(self) -> str:
        """Key that no two places share."""
        return self.channel if self.port is None else f"{self.channel}:{self.port}"

    def __str__(self) -> str:
        if self.bit_rate is None:
            return self.where
        return f"{self.channel} at {self.bit_rate} bit/s, {self.baud} baud"


@dataclass(frozen=True)
class CanDriveAddress:
    """Node on a bus."""

    place: CanPlace
    node: int
    master: int | None = None
    """Node that hil is to the drive, which watches its heartbeat; None: it is none."""

    @property
    def number(self) -> int:
        return self.node

    def __str__(self) -> str:
        return f"{self.place.where}, node {self.node}"


def place_differs(name: str, first: CanDriveAddress, other: CanDriveAddress) -> tuple[str, str] | None:
    """Difference of two drives on one bus, with the remedy; None: there is none. ``name``: the first's."""
    if first.place != other.place:
        remedy = "an adapter has one bit rate and one speed; write the same for both"
        return f"device {name} has this adapter: {first.place}", remedy
    if first.master != other.master:
        remedy = "a bus has one master; write the same for both"
        return f"device {name} is on this bus, with another master", remedy
    return None


def can_drive_address(text: str) -> CanDriveAddress:
    """Read an address. Raises AddressRefused: it cannot be used, with the first thing that is wrong."""
    scheme, _, rest = text.partition("://")
    if scheme not in EXAMPLES or "://" not in text:
        raise AddressRefused(f"there is no scheme {scheme[:20]!r}", f"write {' or '.join(EXAMPLES.values())}")
    body, _, query = rest.partition("?")
    if scheme != SLCAN and "bitrate=" in query:
        where = f"`ip link set {body or 'can0'} type can bitrate ...` sets it" if scheme == SOCKETCAN else ""
        raise AddressRefused("a bit rate is not set by this address", where or "leave it out: it has none")
    keys = dict(query_keys(query, _KEYS[scheme], EXAMPLES[scheme]))
    if "node" not in keys:
        raise AddressRefused("no node is given", f"write {with_key(text, 'node', 1)}")
    node = _node(keys["node"])
    master = _node(keys["master"]) if "master" in keys else None
    if node == master:
        raise AddressRefused(f"node {node} is the drive, and cannot be the master", "write another master")
    if scheme == SOCKETCAN:
        return CanDriveAddress(_interface(body), node, master)
    if scheme == MULTICAST:
        return CanDriveAddress(_group(body), node, master)
    return CanDriveAddress(_adapter(text, body, keys), node, master)


def _node(text: str) -> int:
    node = whole_number(text)
    if node is None or node not in NODES:
        what = "is for all nodes at once, and nobody answers" if node == 0 else "is no node"
        raise AddressRefused(f"{text[:20]!r} {what}", f"write {NODES.start} to {NODES.stop - 1}")
    return node


def _interface(body: str) -> CanPlace:
    if not _INTERFACE.fullmatch(body):
        remedy = f"write the name that `ip link` shows, as in {EXAMPLES[SOCKETCAN]}"
        raise AddressRefused("there is no name of a CAN interface", remedy)
    return CanPlace("socketcan", body.rstrip("/"))


def _group(body: str) -> CanPlace:
    match = _GROUP.fullmatch(body)
    numbers = [int(part[:4]) for part in (match["ipv4"] or "").split(".") if part] if match else []
    is_group = not numbers or (224 <= numbers[0] <= 239 and max(numbers) <= 255)
    if not match or not is_group:
        remedy = f"write 224.0.0.0 to 239.255.255.255, or [ff...], as in {EXAMPLES[MULTICAST]}"
        raise AddressRefused("there is no address of a multicast group", remedy)
    port = MULTICAST_PORT if match["port"] is None else whole_number(match["port"])
    if not port or port > MOST_PORT:
        what = f"{match['port'][:20]!r} is no port"
        raise AddressRefused(what, f"write 1 to {MOST_PORT}, python-can's is {MULTICAST_PORT}")
    return CanPlace("udp_multicast", match["ipv6"] or match["ipv4"], port=port)


def _adapter(text: str, body: str, keys: dict[str, str]) -> CanPlace:
    tcp = _TCP.fullmatch(body)
    if tcp and not 0 < (whole_number(tcp["port"]) or 0) <= MOST_PORT:
        raise AddressRefused(f"{tcp['port'][:20]!r} is no port", f"write 1 to {MOST_PORT}")
    if not tcp and (not body.startswith("/") or len(body) < 2 or "\0" in body):
        remedy = f"write three slashes and the path, as in {EXAMPLES[SLCAN]}, or host:port"
        raise AddressRefused("there is no path of a serial port", remedy)
    from bridges.can.frames.slcan import BIT_RATES  # most benches have no bus

    rates = ", ".join(map(str, BIT_RATES))
    if "bitrate" not in keys:
        raise AddressRefused("no bit rate is given", f"write {with_key(text, 'bitrate', 1_000_000)}")
    bit_rate = whole_number(keys["bitrate"])
    if bit_rate not in BIT_RATES:
        what = f"{keys['bitrate'][:20]!r} is no bit rate of such an adapter"
        raise AddressRefused(what, f"write one of {rates}")
    baud = whole_number(keys.get("baud", str(BAUD)))
    if baud is None or not LEAST_BAUD <= baud <= MOST_BAUD:
        raise AddressRefused(f"{keys['baud'][:20]!r} is no speed", f"write {LEAST_BAUD} to {MOST_BAUD}")
    channel = f"socket://{body.rstrip('/')}" if tcp else body
    return CanPlace("slcan", channel, bit_rate=bit_rate, baud=baud)
