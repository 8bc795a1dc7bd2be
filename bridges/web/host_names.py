"""Names by which the door may be asked for, and pages of its own: who asks for another name was led here.

A page of another site can let a name of its own lead to 127.0.0.1 (DNS rebinding). The browser then says that
name in ``Host`` and ``Origin``, and both are refused. Pure.
"""

from collections.abc import Iterable

from bridges.web.web_options import authority, has_port

LOOPBACK = ("localhost", "127.0.0.1", "::1")
ANY = ("0.0.0.0", "::")
"""Hosts that stand for all addresses of this computer."""
_DEFAULT_PORT = {"http": 80, "https": 443}


class HostNames:
    """Names of the door. ``scheme``: http or https; ``names``: as the options have them."""

    def __init__(self, scheme: str, host: str, port: int, names: Iterable[str]) -> None:
        self.scheme = scheme
        hosts = [*LOOPBACK, *([] if host in ANY else [host])]
        known = {authority(each, port) for each in hosts}
        known |= {name if has_port(name) else _with_port(name, port) for name in names}
        ending = f":{_DEFAULT_PORT[scheme]}"
        known |= {name.removesuffix(ending) for name in known if name.endswith(ending)}
        self._known = frozenset(name.lower() for name in known)

    def is_known(self, host: str | None) -> bool:
        """True if the header ``Host`` has a name of the door."""
        return host is not None and host.lower() in self._known

    def is_own(self, origin: str | None, host: str) -> bool:
        """True if the header ``Origin`` names the page that ``host`` has, or is not there: browsers send it
        with each WebSocket, and whenever something is posted."""
        return origin is None or origin.lower() == f"{self.scheme}://{host.lower()}"


def _with_port(name: str, port: int) -> str:
    return f"{name}:{port}"
