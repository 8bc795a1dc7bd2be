"""Who may."""

from typing import Any

from bridges.zenoh.options import Options


class SecurityError(Exception):
    """x"""


def gate_of(options: Options) -> Any:
    return None


def session_config(options: Options, bench: str) -> dict[str, Any]:
    return {
        "mode": "router" if options.listen else "peer",
        "connect/exit_on_failure": False,
        "connect/timeout_ms": -1,
        "listen/endpoints": list(options.listen),
        "connect/endpoints": list(options.connect),
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/shared_memory/enabled": False,
        "timestamping/enabled": False,
    }
