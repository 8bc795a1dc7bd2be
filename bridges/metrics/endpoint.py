"""Address and port to listen at, as they are written. Nothing is asked of the network."""

import ipaddress
import re
import socket

_FORM = re.compile(r"(\[[^\s\[\]]+\]|[^\s\[\]]+):([0-9]{1,5})", re.ASCII)
_NAME_CHARACTERS = 253
MAX_PORT = 65535


def endpoint(text: str) -> tuple[str, int]:
    """The host, without brackets, and the port's number.

    Raises:
        ValueError: they are not; the text says why.
    """
    if not (match := _FORM.fullmatch(text)) or int(match[2]) > MAX_PORT:
        raise ValueError(f"{text!r} is no address and port")
    host = match[1].removeprefix("[").removesuffix("]")
    if not _is_address(host) and not _is_name(host):
        raise ValueError(f"{host!r} is no address and no name of a computer")
    return host, int(match[2])


def is_loopback(host: str) -> bool:
    """Only programs of this computer reach it."""
    if host.lower() == "localhost":
        return True
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        return _is_short(host) and ipaddress.ip_address(socket.inet_aton(host)).is_loopback
    return (getattr(address, "ipv4_mapped", None) or address).is_loopback


def _is_address(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return _is_short(host)
    return True


def _is_short(host: str) -> bool:
    """An address that inet_aton(3) takes, as 127.1."""
    try:
        socket.inet_aton(host)
    except (OSError, ValueError):
        return False
    return True


def _is_name(host: str) -> bool:
    """As the resolver can be asked for it; there need be no such computer."""
    try:
        name = host.encode("idna")
    except UnicodeError:  # an empty or too long label
        return False
    return len(name) <= _NAME_CHARACTERS and re.fullmatch(rb"[\w.-]+", name) is not None
