"""Kinds of a bench's ports, by the names of the places where they are, and speeds of a segment's ports."""

from collections.abc import Mapping

from hil.config.catalogue import ProfileInfo
from hil.config.document import KeyPath
from hil.config.model import BenchConfig
from hil.config.port_model import SERIAL, USUAL_BAUD
from hil.config.station_names import station_uart
from hil.vocab.address import Address, address_of
from hil.vocab.firmware import NETWORK


def segment_speeds(bench: BenchConfig, name: str, profiles: Mapping[str, ProfileInfo]) -> Mapping[str, int]:
    """Speeds in baud of a segment's stations, nodes and taps; of a tap at a real adapter the adapter's. The
    speed of a station with a program of a user's own is not known."""
    segment, speeds = bench.segments[name], dict[str, int]()
    for device, part in segment.addresses():
        profile = profiles[bench.devices[device].profile]
        if bench.devices[device].firmware:
            continue
        bauds = bench.devices[device].uart_bauds(profile)
        uart = part or str(station_uart(profile.uarts))
        speeds[str(Address(device, uart))] = bauds[uart] or 0
    baud = segment.baud or next(iter(speeds.values()), USUAL_BAUD)
    speeds |= dict.fromkeys(segment.node_axes(), baud)
    for tap, config in segment.taps.items():
        own = getattr(config.port.options, "baud", baud) if config.port.kind == SERIAL else baud
        speeds[str(Address(name, tap))] = own
    return speeds


def port_path(config: BenchConfig, label: str) -> KeyPath:
    """Path to the key of a port in the configuration."""
    owner, part = address_of(label)
    if owner in config.devices:
        if part in ("", NETWORK):
            return ("devices", owner, part or "port")
        return ("devices", owner, "ports", part)
    key = next(key for key in config.bus_keys if owner in config.wires_of(key))
    return (key, owner, "taps", part, "port")


def port_kinds(config: BenchConfig) -> dict[str, str]:
    """Kinds by label: ``m1`` and ``s1.network`` of devices, ``bus0.master`` of taps."""
    kinds = {
        str(Address(name, uart)): port.kind
        for name, device in config.devices.items()
        for uart, port in device.ports_by_uart().items()
    }
    return kinds | {label: port.kind for label, port in config.tap_ports().items()}
