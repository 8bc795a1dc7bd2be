"""Ports of the benches that tests of this process have open, the newest last."""

import weakref
from collections.abc import Mapping

from hil.testing.serial_ports.ports_of_bench import SerialPorts

_OPEN: "list[weakref.ref[SerialPorts]]" = []

LIVE: list[tuple[str, Mapping[str, str]]] = []
"""Benches in real time: the name of each, and the paths or URLs of its ports by their names."""


def add_open(ports: SerialPorts) -> None:
    """Add a bench that was made."""
    _OPEN.append(weakref.ref(ports, _OPEN.remove))


def forget_closed(ports: SerialPorts) -> None:
    """Forget a bench that was closed; nothing if it was before."""
    _OPEN[:] = [each for each in _OPEN if each() is not ports]


def open_benches() -> list[SerialPorts]:
    """Ports of each open bench, the newest first."""
    return [ports for each in reversed(_OPEN) if (ports := each())]
