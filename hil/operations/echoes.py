"""Echoes of a bench's adapters: at taps, real boards, real drives and lines of bridges."""

from collections.abc import Iterator, Mapping

from hil.live.places import Places
from hil.sim.bench import BenchRuntime
from hil.vocab.bridge_protocol import Bridge
from hil.vocab.device import Device
from hil.vocab.ports import EchoState

Echo = Mapping[str, str | int]
"""``hil.vocab.ports.EchoStats`` for JSON."""


def echoes(
    devices: Mapping[str, Device], sim: BenchRuntime, places: Places, bridges: Mapping[str, Bridge]
) -> Iterator[tuple[str, Echo]]:
    """Adapters, by the name of their place, or the address of a bridge's line."""
    told = [(link.label, link.port.stats().echo) for wire in sim.wires for link in places.of(wire)]
    told += [each for device in devices.values() for each in device.echoes()]
    for name, echo in told:
        if echo and echo.state is not EchoState.UNSOUGHT:
            yield name, echo.as_dict()
    for bridge in bridges.values():
        for address, line in bridge.status().get("lines", {}).items():
            if "echo" in line:
                yield address, line["echo"]
