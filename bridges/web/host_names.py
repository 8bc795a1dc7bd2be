"""Names by which the door may be asked for, and pages of its own: who asks for another name was led here.

A page of another site can let a name of its own lead to 127.0.0.1 (DNS rebinding). The browser then says that
name in ``Host`` and ``Origin``, and both are refused. Pure.
"""

from collections.abc import Iterable

from bridges.web.web_options import PROXY, authority, has_port

LOOPBACK = ("localhost", "127.0.0.1", "::1")
ANY = ("0.0.0.0", "::")
"""Hosts that stand for all addresses of this computer."""
_DEFAULT_PORT = {"http": 80, "https": 443}


class HostNames:
    """Names of the door. ``scheme``: http or https; ``names``: as the options have them."""

    def __init__(self, scheme: str, host: str, port: int, names: Iterable[str]) -> None:
        own = {authority(each, port) for each in (*LOOPBACK, *([] if host in ANY else [host]))}
        own |= {_with_port(name, port) for name in names if not name.startswith(PROXY)}
        proxies = {_with_port(name.removeprefix(PROXY), 443) for name in names if name.startswith(PROXY)}
        self._schemes = _as_headers(own, scheme) | _as_headers(proxies, "https")
        """Scheme by which browsers reach each name, as the header ``Host`` has it: http or https."""

    def is_known(self, host: str | None) -> bool:
        """True if the header ``Host`` has a name of the door."""
        return host is not None and host.lower() in self._schemes

    def is_own(self, origin: str | None, host: str) -> bool:
        """True if the header ``Origin`` names the page that ``host`` has, or is not there: browsers send it
        with each WebSocket, and whenever something is posted."""
        return origin is None or origin.lower() == f"{self.scheme_of(host)}://{host.lower()}"

    def scheme_of(self, host: str) -> str:
        """Scheme by which browsers reach a name that is known: http or https."""
        return self._schemes[host.lower()]


def _as_headers(names: Iterable[str], scheme: str) -> dict[str, str]:
    """Names as browsers write them, with and without the port that belongs to ``scheme``."""
    ending = f":{_DEFAULT_PORT[scheme]}"
    short = {name.removesuffix(ending) for name in names}
    return dict.fromkeys((name.lower() for name in {*names, *short}), scheme)


def _with_port(name: str, port: int) -> str:
    return name if has_port(name) else f"{name}:{port}"
