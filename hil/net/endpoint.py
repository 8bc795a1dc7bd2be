"""Address and port to listen at, as a user writes them. Nothing is asked of the network."""

import ipaddress
import re
import socket
from contextlib import suppress

_FORM = re.compile(r"(\[[^\s\[\]]+\]|[^\s\[\]]+):([0-9]{1,5})", re.ASCII)
_NAME_CHARACTERS = 253
MAX_PORT = 65535


def endpoint(text: str) -> tuple[str, int]:
    """Parse the host, without brackets, and the port's number.

    Raises:
        ValueError: they are not; the text says why.
    """
    if not (match := _FORM.fullmatch(text)) or int(match[2]) > MAX_PORT:
        raise ValueError(f"{text!r} is no address and port")
    host = match[1].removeprefix("[").removesuffix("]")
    if _address(host) is None and not _is_name(host):
        raise ValueError(f"{host!r} is no address and no name of a computer")
    return host, int(match[2])


def is_loopback(host: str) -> bool:
    """True if only programs of this computer reach a host."""
    address = _address(host)
    if address is None:
        return host.lower() == "localhost"
    return (getattr(address, "ipv4_mapped", None) or address).is_loopback


def _address(host: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    """Parse an address, also one that inet_aton(3) takes, as 127.1."""
    with suppress(ValueError):
        return ipaddress.ip_address(host)
    with suppress(OSError, ValueError):
        return ipaddress.ip_address(socket.inet_aton(host))
    return None


def _is_name(host: str) -> bool:
    """True if the resolver can be asked for a name; there need be no such computer."""
    try:
        name = host.encode("idna")
    except UnicodeError:  # an empty or too long label
        return False
    return len(name) <= _NAME_CHARACTERS and re.fullmatch(rb"[\w.-]+", name) is not None
