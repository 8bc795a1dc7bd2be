"""Builder of CAN buses with their nodes and taps."""

from collections.abc import Callable, Mapping
from functools import partial
from zlib import crc32

from bridges.can.can_model import CanConfig, CanNodeConfig, SwitchConfig
from bridges.can.canopen.cia402.profile_drive import ProfileDrive
from bridges.can.canopen.node.application import Application
from bridges.can.canopen.node.canopen_node import CanOpenNode
from bridges.can.canopen.node.communication_entries import Identity
from bridges.can.cards.bench_bus import BenchBus
from bridges.can.cards.can_tap import CanTap
from bridges.can.cards.canopen_card import CanOpenCard, CardSpec
from bridges.can.cards.card_motor import Cam, CardMotor, DriveSwitch, PinSwitch, Rating, Wayside
from hil.config import BenchConfig, Catalogue
from hil.config.station_names import CANOPEN, node_name
from hil.core import AxisKind
from hil.core.kinds import KINDS
from hil.sim.bench import BenchRuntime
from hil.sim.group import Group
from hil.vocab.address import Address, address_of

VENDOR_ID = 0
"""Vendor id of 1018h: hil has none of CAN in Automation."""
REVISION = 0x0001_0000
"""Revision of 1018h, major number in the upper half: it changes with the objects."""


def add_buses(bench: BenchRuntime, config: BenchConfig, catalogue: Catalogue) -> None:
    """Put the buses into the bench, with their nodes and taps in the order of the configuration."""
    for name, of in config.wires_of(BenchBus.kind).items():
        _add_bus(bench, name, of, config, catalogue)


def _add_bus(
    bench: BenchRuntime, name: str, of: CanConfig, config: BenchConfig, catalogue: Catalogue
) -> None:
    members = of.members()
    group = bench.parts.group_of(members[0]) if members else bench.open_group()
    bus = BenchBus(name, group, of.bit_rate)
    bench.parts.add_wire(name, bus, group)
    for axis, node in of.nodes.items():
        _add_node(bench, axis, node, bus, group, _rating(config, catalogue, axis))
    for tap in of.taps:
        bench.parts.add_tap(CanTap(str(Address(name, tap)), bus.bus, group), group)


def _add_node(
    bench: BenchRuntime, axis: str, config: CanNodeConfig, bus: BenchBus, group: Group, rating: Rating
) -> None:
    owner, part = address_of(axis)
    device = bench.devices[owner]
    label, short = device.axes.label(owner, part), device.axes.short(part)
    switches = _switches(bench, config, device.axes[short].kind)
    motor = CardMotor(device, short, group, partial(bench.apply_unlogged, label), switches, rating)
    serial = crc32(f"{bench.name}/{label}".encode())
    make, identity = _application(config, motor, device.profile, serial)
    spec = CardSpec(
        node_id=config.id,
        make_application=make,
        identity=identity,
        section=f"{CANOPEN}.{short}" if short else CANOPEN,
    )
    bench.add_card(CanOpenCard(node_name(label, CANOPEN), bus, device, group, spec))


def _application(
    config: CanNodeConfig, motor: CardMotor, profile: str, serial: int
) -> tuple[Callable[[CanOpenNode], Application], Identity]:
    """Answer the maker of the drive, hil's own or that of a maker's file, and its identity."""
    if config.eds is None:
        identity = Identity(VENDOR_ID, crc32(profile.encode()), REVISION, serial, f"simulated {profile}")
        return lambda services: ProfileDrive(motor, services), identity
    from bridges.can.canopen.cia402.maker_drive import MakerDrive, identity_of
    from bridges.can.canopen.node.eds_reader import read_device
    from bridges.can.maker_findings import lines_of

    device, lines = read_device(config.eds.text, config.eds.name), lines_of(config)
    maker = identity_of(device, lines, serial)
    return lambda services: MakerDrive(motor, services, device, lines, maker), maker


def _rating(config: BenchConfig, catalogue: Catalogue, axis: str) -> Rating:
    owner, part = address_of(axis)
    device = config.devices[owner]
    profile = catalogue.profiles[device.profile]
    name = part or next(iter(profile.axes))
    kind, parameters = KINDS[profile.axes[name].law], device.axis_parameters(profile, name)
    current_A, torque_Nm = kind.max_current_A(parameters), kind.holding_Nm(parameters)
    return Rating(current_A, torque_Nm, int(parameters["rotor_teeth"]))


def _switches(bench: BenchRuntime, config: CanNodeConfig, kind: AxisKind) -> Mapping[str, DriveSwitch]:
    given: Mapping[str, SwitchConfig | None] = dict(config.switches)
    return {name: _switch(bench, switch, kind) for name, switch in given.items() if switch}


def _switch(bench: BenchRuntime, config: SwitchConfig, kind: AxisKind) -> DriveSwitch:
    if config.switch is not None:
        return Wayside(bench.parts.switches[config.switch])
    if config.pin is not None:
        field = kind.level_field(config.pin)
        assert field is not None, f"the configuration's check wants a pin that tells: {config.pin}"
        return PinSwitch(field, config.active == "low")
    bounds = {
        "from_deg": config.from_deg if config.above_deg is None else config.above_deg,
        "to_deg": config.to_deg if config.below_deg is None else config.below_deg,
    }
    return Cam(**{name: angle for name, angle in bounds.items() if angle is not None})
