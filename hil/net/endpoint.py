"""Address and port to listen at, as a user writes them. Nothing is asked of the network."""

import ipaddress
import re
import socket
from contextlib import suppress

LOOPBACK = "127.0.0.1"
"""Host of an address that is a port alone."""
_FORM = re.compile(r"(\[[^\s\[\]]+\]|[^\s\[\]]+):([0-9]{1,5})", re.ASCII)
_NAME_CHARACTERS = 253
MAX_PORT = 65535
_BY_NETWORK = ("tcp", "tls", "quic", "udp", "ws")
_ELSEWHERE = ("quic_datagram", "serial", "unixpipe", "unixsock-stream", "vsock")
"""Transports of zenoh's addresses: with a host and a port, and with other places
(https://zenoh.io/docs/manual/configuration/)."""


class BadAddress(ValueError):
    """Error of an address: ``str(error)`` says what is wrong, ``remedy`` what to write."""

    def __init__(self, what: str, remedy: str) -> None:
        super().__init__(what)
        self.remedy = remedy


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


def check_joined(given: str) -> None:
    """Check an address of zenoh to connect to, as in ``tcp/127.0.0.1:7447``.

    Raises:
        BadAddress: it is none.
    """
    transport, _, rest = given.partition("/")
    place = re.split("[?#]", rest, maxsplit=1)[0]
    if transport in _ELSEWHERE and place:
        return
    number = place.rpartition(":")[2]
    if transport in _BY_NETWORK and has_port(place) and re.fullmatch(r"[0-9]{1,9}", number, re.ASCII):
        if not 1 <= int(number) <= MAX_PORT:
            raise BadAddress(f"{given[:80]!r}: {number} is no port", f"write 1 to {MAX_PORT}")
        with suppress(ValueError):
            endpoint(place)
            return
    what = f"{given[:80]!r} is no address to connect to"
    raise BadAddress(what, "write tcp/HOST:PORT, as tcp/127.0.0.1:7447")


def host_and_port(listen: str) -> tuple[str, int | None]:
    """Parse an address of the form that ``listen_address`` answers; None: it has no port."""
    if has_port(listen):
        return endpoint(listen)
    return listen.removeprefix("[").removesuffix("]"), None


def authority(host: str, port: int | None) -> str:
    """Format a host and a port as they stand in a URL."""
    shown = f"[{host}]" if ":" in host else host
    return shown if port is None else f"{shown}:{port}"


def has_port(name: str) -> bool:
    """True if a port stands behind a name, as in ``lab1:9000`` and ``[::1]:9000``."""
    return name.rpartition("]")[2].startswith(":") if name.startswith("[") else ":" in name


def listen_address(given: str | int, usual_port: int | None) -> str:
    """Complete an address to listen at: ``HOST:PORT``, a port alone for this computer, or a host alone for
    the usual port. ``usual_port``: None leaves a host alone as it is.

    Raises:
        BadAddress: it is none.
    """
    if isinstance(given, int) or re.fullmatch(r"[-+]?[0-9]+", given, re.ASCII):
        return authority(LOOPBACK, _port(str(given)))
    example = authority(LOOPBACK, usual_port or 8080)
    if "/" in given:
        raise BadAddress(f"{given!r} is no address and port", f"write it without a protocol, as in {example}")
    if given.count(":") > 1 and _is_ipv6(given):
        raise BadAddress(
            f"{given!r} is an IPv6 address without brackets, so that nobody can tell a port from it",
            f'write it in brackets and quotes, as in "[::1]:{usual_port or 8080}"',
        )
    if given.startswith(":"):
        remedy = f"write 127.0.0.1{given} for this computer alone, 0.0.0.0{given} for all its networks"
        raise BadAddress(f"{given!r} has no host", remedy)
    host, port = given, usual_port
    if has_port(given):
        host, _, number = given.rpartition(":")
        if ":" in host and not host.startswith("["):
            raise BadAddress(f"{given!r} is no address and port", f"write one of each, as in {example}")
        port = _port(number)
    bare = host.removeprefix("[").removesuffix("]") if _is_closed(host) else host
    is_known = not re.search(r"\s", bare) and (_address(bare) is not None or _is_name(bare))
    if not is_known or (host != bare and not _is_ipv6(bare)):
        what = f"{host!r} is no address and no name of a computer" if host else f"{given!r} has no host"
        raise BadAddress(what, f"write an address and a port, as in {example}")
    return authority(bare, port)


def is_loopback(host: str) -> bool:
    """True if only programs of this computer reach a host."""
    address = _address(host)
    if address is None:
        return host.lower() == "localhost"
    return (getattr(address, "ipv4_mapped", None) or address).is_loopback


def _port(number: str) -> int:
    if not re.fullmatch(r"[0-9]+", number, re.ASCII) or len(number) > 6 or int(number) > MAX_PORT:
        what = f"{number!r} is no port" if number else "there is no port behind the colon"
        raise BadAddress(what, f"a port is 1 to {MAX_PORT}, or 0 for any free one")
    return int(number)


def _is_closed(host: str) -> bool:
    return host.startswith("[") and host.endswith("]")


def _is_ipv6(text: str) -> bool:
    with suppress(ValueError):
        return ipaddress.ip_address(text).version == 6
    return False


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
