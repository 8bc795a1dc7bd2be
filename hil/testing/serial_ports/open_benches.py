"""Ports of the benches in memory that are open in this process, the newest last."""

import weakref

from hil.testing.serial_ports.ports_of_bench import SerialPorts

_OPEN: "list[weakref.ref[SerialPorts]]" = []


def add_open(ports: SerialPorts) -> None:
    """Add a bench that was made."""
    _OPEN.append(weakref.ref(ports, _OPEN.remove))


def forget_closed(ports: SerialPorts) -> None:
    """Forget a bench that was closed; nothing if it was before."""
    _OPEN[:] = [each for each in _OPEN if each() is not ports]


def open_benches() -> list[SerialPorts]:
    """Ports of each open bench, the newest first."""
    return [ports for each in reversed(_OPEN) if (ports := each())]
