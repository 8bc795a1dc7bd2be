"""Addresses of real Modbus drives: ``modbus+tcp://192.168.1.5:502?unit=1``, ``modbus+rtu:///dev/ttyUSB0?unit=3``.

Sources: "MODBUS Messaging on TCP/IP Implementation Guide" V1.0b (port 502, unit 255 for a device without a
gateway); "MODBUS over Serial Line" V1.02 (units 1 to 247, 19200 baud and even parity by default, 11 bit times
a character).
"""

import re
from dataclasses import dataclass

from hil.wire.address_keys import AddressRefused, query_keys, whole_number, with_key

TCP, RTU = "modbus+tcp", "modbus+rtu"
EXAMPLES = {
    TCP: "modbus+tcp://192.168.1.5:502?unit=1",
    RTU: "modbus+rtu:///dev/ttyUSB0?baud=19200&format=8E1&unit=3",
}
TCP_PORT = 502
BAUD, FORMAT = 19200, "8E1"
LEAST_BAUD, MOST_BAUD = 300, 4_000_000
FORMATS = ("8E1", "8O1", "8N1", "8N2", "8E2", "8O2")
"""Character formats of a line: bits, parity, stop bits. RTU has 8 bits."""
UNITS = range(1, 248)
WITHOUT_GATEWAY = 255
"""Unit of a device on TCP that is no gateway."""
MOST_PORT = 65535
_HOST_AND_PORT = re.compile(
    r"(?:\[(?P<ipv6>[0-9A-Fa-f:.]+)\]|(?P<host>[A-Za-z0-9._-]+))(?::(?P<port>[0-9]+))?/?"
)
_KEYS = {TCP: ("unit",), RTU: ("unit", "baud", "format", "echo")}
_ECHO = {"true": True, "false": False}


@dataclass(frozen=True)
class TcpPlace:
    """Listener of a drive or a gateway."""

    host: str
    port: int

    @property
    def where(self) -> str:
        """Key that no two places share."""
        return str(self)

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{host}:{self.port}"


@dataclass(frozen=True)
class RtuPlace:
    """Serial line, with its speed in baud and its character format."""

    path: str
    baud: int = BAUD
    format: str = FORMAT
    echo: bool | None = None
    """True if the adapter echoes what it sends; None: nobody has said so."""

    @property
    def character_bits(self) -> int:
        """Bit times of one character, the start bit included."""
        return 9 + (self.format[1] != "N") + int(self.format[2])

    @property
    def where(self) -> str:
        """Key that no two places share."""
        return self.path

    def __str__(self) -> str:
        echo = "" if self.echo is None else ", with an echo" if self.echo else ", without an echo"
        return f"{self.path} at {self.baud} baud, {self.format}{echo}"


@dataclass(frozen=True)
class ModbusDriveAddress:
    """Unit at a place."""

    place: TcpPlace | RtuPlace
    unit: int

    @property
    def number(self) -> int:
        return self.unit

    def __str__(self) -> str:
        return f"{self.place}, unit {self.unit}"


def place_differs(name: str, first: ModbusDriveAddress, other: ModbusDriveAddress) -> tuple[str, str] | None:
    """Difference of two drives on one line, with the remedy; None: there is none. ``name``: the first's."""
    if first.place == other.place:
        return None
    remedy = "a line has one speed and one format, and an echo or none; write the same for both"
    return f"device {name} has this line: {first.place}", remedy


def modbus_drive_address(text: str) -> ModbusDriveAddress:
    """Read an address. Raises AddressRefused: it cannot be used, with the first thing that is wrong."""
    scheme, _, rest = text.partition("://")
    if scheme not in EXAMPLES or "://" not in text:
        raise AddressRefused(f"there is no scheme {scheme[:20]!r}", f"write {' or '.join(EXAMPLES.values())}")
    body, _, query = rest.partition("?")
    keys = dict(query_keys(query, _KEYS[scheme], EXAMPLES[scheme]))
    if "unit" not in keys:
        raise AddressRefused("no unit is given", f"write {with_key(text, 'unit', 1)}")
    if scheme == TCP:
        return ModbusDriveAddress(_tcp_place(body), _unit(keys["unit"], (*UNITS, WITHOUT_GATEWAY)))
    return ModbusDriveAddress(_rtu_place(body, keys), _unit(keys["unit"], tuple(UNITS)))


def _unit(text: str, allowed: tuple[int, ...]) -> int:
    unit = whole_number(text)
    if unit is None or unit not in allowed:
        too = f", or {WITHOUT_GATEWAY} for a device that is no gateway" if WITHOUT_GATEWAY in allowed else ""
        remedy = f"write {UNITS.start} to {UNITS.stop - 1}{too}"
        what = "is for all units at once, and nobody answers" if unit == 0 else "is no unit"
        raise AddressRefused(f"{text[:20]!r} {what}", remedy)
    return unit


def _tcp_place(body: str) -> TcpPlace:
    """Host, an IPv6 address in brackets, and port; the usual one if there is none."""
    if not (match := _HOST_AND_PORT.fullmatch(body)):
        raise AddressRefused("there is no host, or more than host and port", f"write {EXAMPLES[TCP]}")
    port = TCP_PORT if match["port"] is None else whole_number(match["port"])
    if not port or port > MOST_PORT:
        what = f"{match['port'][:20]!r} is no port"
        raise AddressRefused(what, f"write 1 to {MOST_PORT}, most often {TCP_PORT}")
    return TcpPlace(match["ipv6"] or match["host"], port)


def _rtu_place(body: str, keys: dict[str, str]) -> RtuPlace:
    if not body.startswith("/") or len(body) < 2 or "\0" in body:
        remedy = f"write three slashes and the path, as in {EXAMPLES[RTU]}"
        raise AddressRefused("there is no path of a serial port", remedy)
    baud = whole_number(keys.get("baud", str(BAUD)))
    if baud is None or not LEAST_BAUD <= baud <= MOST_BAUD:
        raise AddressRefused(f"{keys['baud'][:20]!r} is no speed", f"write {LEAST_BAUD} to {MOST_BAUD}")
    form = keys.get("format", FORMAT)
    if form not in FORMATS:
        raise AddressRefused(f"{form[:20]!r} is no format of a character", f"known are: {', '.join(FORMATS)}")
    if (echo := keys.get("echo")) is not None and echo not in _ECHO:
        raise AddressRefused(f"{echo[:20]!r} is no echo", f"write echo={' or echo='.join(_ECHO)}")
    return RtuPlace(body, baud, form, _ECHO.get(echo or ""))
