"""Addresses of real TMCL modules: ``tmcl+serial:///dev/ttyUSB0?baud=9600&module=1``."""

from dataclasses import dataclass

from hil.wire.address_keys import AddressRefused, query_keys, whole_number, with_key
from tmcl_bus.frames import HOST, MODULES

SCHEME = "tmcl+serial"
EXAMPLE = f"{SCHEME}:///dev/ttyUSB0?baud=9600&module=1"
BAUD, LEAST_BAUD, MOST_BAUD = 9600, 300, 4_000_000
_KEYS = ("module", "baud", "host")


@dataclass(frozen=True)
class SerialPlace:
    """Serial line, with its speed in baud."""

    path: str
    baud: int = BAUD

    @property
    def where(self) -> str:
        """Key that no two places share."""
        return self.path

    def __str__(self) -> str:
        return f"{self.path} at {self.baud} baud"


@dataclass(frozen=True)
class TmclDriveAddress:
    """Module at a place. ``host``: the address to which it replies."""

    place: SerialPlace
    module: int
    host: int = HOST

    @property
    def number(self) -> int:
        return self.module

    def __str__(self) -> str:
        return f"{self.place}, module {self.module}"


def place_differs(name: str, first: TmclDriveAddress, other: TmclDriveAddress) -> tuple[str, str] | None:
    """Difference of two modules on one line, with the remedy; None: there is none. ``name``: the first's."""
    if first.place == other.place:
        return None
    return f"device {name} has this line: {first.place}", "a line has one speed: write the same for both"


def tmcl_drive_address(text: str) -> TmclDriveAddress:
    """Read an address. Raises AddressRefused: it cannot be used, with the first thing that is wrong."""
    scheme, _, rest = text.partition("://")
    if scheme != SCHEME:
        raise AddressRefused(f"there is no scheme {scheme[:20]!r}", f"write {EXAMPLE}")
    path, _, query = rest.partition("?")
    if not path.startswith("/") or len(path) < 2 or "\0" in path:
        raise AddressRefused("there is no path of a serial port", f"write three slashes, as in {EXAMPLE}")
    keys = dict(query_keys(query, _KEYS, EXAMPLE))
    if "module" not in keys:
        raise AddressRefused("no module is given", f"write {with_key(text, 'module', 1)}")
    place = SerialPlace(path, _number(keys, "baud", BAUD, range(LEAST_BAUD, MOST_BAUD + 1)))
    return TmclDriveAddress(place, _number(keys, "module", 1, MODULES), _number(keys, "host", HOST, MODULES))


def _number(keys: dict[str, str], key: str, default: int, allowed: range) -> int:
    text = keys.get(key, str(default))
    number = whole_number(text)
    if number is None or number not in allowed:
        remedy = f"write {allowed.start} to {allowed.stop - 1}"
        raise AddressRefused(f"{text[:20]!r} is no {key}", remedy)
    return number
