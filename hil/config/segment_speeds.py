"""Speeds on a segment, by its configuration."""

from collections.abc import Mapping

from hil.config.catalogue import ProfileInfo
from hil.config.model import BenchConfig
from hil.config.port_model import SERIAL, USUAL_BAUD
from hil.config.station_names import station_uart
from hil.vocab.address import Address


def segment_speeds(bench: BenchConfig, name: str, profiles: Mapping[str, ProfileInfo]) -> Mapping[str, int]:
    """Speeds in baud of a segment's stations, nodes and taps; of a tap at a real adapter the adapter's."""
    segment, speeds = bench.segments[name], dict[str, int]()
    for device, part in segment.addresses():
        profile = profiles[bench.devices[device].profile]
        bauds = bench.devices[device].uart_bauds(profile)
        uart = part or str(station_uart(profile.uarts))
        speeds[str(Address(device, uart))] = bauds[uart] or 0
    baud = segment.baud or next(iter(speeds.values()), USUAL_BAUD)
    speeds |= dict.fromkeys(segment.node_axes(), baud)
    for tap, config in segment.taps.items():
        own = getattr(config.port.options, "baud", baud) if config.port.kind == SERIAL else baud
        speeds[str(Address(name, tap))] = own
    return speeds
