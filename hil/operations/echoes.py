"""Echoes of a bench's adapters: at taps, real boards, real drives and lines of bridges."""

from collections.abc import Iterator, Mapping

from hil.live.places import Places
from hil.vocab.bridge_protocol import Bridge
from hil.vocab.ports import EchoState

Echo = Mapping[str, str | int]
"""``hil.vocab.ports.EchoStats`` for JSON."""


def echoes(places: Places, bridges: Mapping[str, Bridge]) -> Iterator[tuple[str, Echo]]:
    """Adapters, by the name of their place, or the address of a bridge's line."""
    ports = {label: joint.port for label, joint in (places.uarts | places.taps).items()}
    ports |= {name: board.end.line for name, board in places.boards.items()}
    told = {name: port.stats().echo for name, port in ports.items()}
    told |= {name: control.drive.echo for name, control in places.drives.items()}
    for name, echo in told.items():
        if echo and echo.state is not EchoState.UNSOUGHT:
            yield name, echo.as_dict()
    for bridge in bridges.values():
        for address, line in bridge.status().get("lines", {}).items():
            if "echo" in line:
                yield address, line["echo"]
