"""Builder of devices, axes and firmware for a validated configuration."""

import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from hil import __version__
from hil.compose.find import make_segment
from hil.compose.framings import framing_of
from hil.compose.lanes import choose_lanes
from hil.config import BenchConfig, Catalogue, DeviceConfig
from hil.config.board_parameters import built
from hil.config.port_model import USUAL_BAUD
from hil.config.processor_model import FieldVoltage, measured
from hil.config.station_names import station_uart
from hil.core import Core
from hil.core.core import SEED_MASK
from hil.firmware.runtime import Idle
from hil.host.regular_file import read_regular
from hil.sim.bench import VIRTUAL, BenchHooks, BenchRuntime, Store
from hil.sim.group import Group
from hil.sim.hardware import DeviceSpec
from hil.sim.segment_tap import Tap
from hil.sim.setpoints import TimeOut
from hil.sim.twin import Twin
from hil.sketch.chip_program import BOOT_SECTION, SECTION
from hil.vocab.address import Address, owner_of, pin_of
from hil.vocab.bus import NodeLine
from hil.vocab.firmware import Board, Firmware
from hil.vocab.line_format import FORMATS
from hil.vocab.profile import MemoryFile, Profile
from hil.vocab.time import NS_PER_S

if TYPE_CHECKING:
    from hil.config.segment_model import SegmentConfig
    from hil.config.switch_model import AxisSwitchConfig

LEAST_AXES = 8


class TableFileError(Exception):
    """Error of a look-up table's file that cannot be used: ``str(error)`` says which and why."""


def named_sections(board: Profile, stored: Mapping[str, bytes]) -> dict[str, bytes]:
    """Name all sections: version 1 of the memory files had one alone, without a name."""
    only = board.memory_file.section if board.memory_file else ""
    return {name or only: data for name, data in stored.items()}


def start_sections(
    config: DeviceConfig, board: Profile, stored: Mapping[str, bytes], folder: Path
) -> dict[str, bytes]:
    """Make a device's memory at the start: what the configuration asks for, over what is stored. A file is
    looked up from ``folder``.

    Raises:
        TableFileError: the configured file cannot be used.
    """
    sections, file, wanted = named_sections(board, stored), board.memory_file, config.flash.table
    sections = with_programs(config, sections)
    if wanted == "stored" or file is None:
        return sections
    if wanted == "empty":
        return {name: data for name, data in sections.items() if name != file.section}
    made = file.named[wanted]() if wanted in file.named else _read(file, folder / wanted)
    return sections | {file.section: made}


def with_programs(config: DeviceConfig, stored: Mapping[str, bytes]) -> dict[str, bytes]:
    """Put the programs that the configuration names over what is stored; a bootloader is there only if it
    names one."""
    sections = {name: data for name, data in stored.items() if name != BOOT_SECTION}
    named = {SECTION: config.firmware, BOOT_SECTION: config.bootloader}
    return sections | {name: file.packed for name, file in named.items() if file}


def start_memories(
    config: BenchConfig, catalogue: Catalogue, folder: Path = Path()
) -> dict[str, dict[str, bytes]]:
    """Make the memories of all devices that have none stored, as ``start_sections``."""
    return {
        name: start_sections(device, catalogue.boards[device.profile], {}, folder)
        for name, device in config.devices.items()
    }


def _read(file: MemoryFile, path: Path) -> bytes:
    try:
        return file.read(read_regular(path, file.most_bytes))
    except OSError as error:
        raise TableFileError(f"{path}: {error.strerror}") from error
    except ValueError as error:
        raise TableFileError(f"{path}: {error}") from error


def make_device(
    bench: BenchRuntime,
    name: str,
    config: DeviceConfig,
    catalogue: Catalogue,
    sections: Mapping[str, bytes],
    seed: int,
    group: Group,
    speed: float,
) -> Twin:
    """Open the axes and make the device, which ``bench.add`` puts into its group. ``seed``: of the first;
    ``speed``: the bench's."""
    profile, board = catalogue.profiles[config.profile], catalogue.boards[config.profile]
    time_out = None
    if (stream := config.setpoints) and board.starve:
        after_ns = round(stream.timeout_ms * 1e6)
        time_out = TimeOut(after_ns, stream.policy, stream.acceleration_rpm_per_s, board.starve)
    spec = DeviceSpec(
        name=name,
        profile=profile.name,
        firmware=_firmware(config, board),
        bauds=config.uart_bauds(profile),
        nvm=sections,
        power_up=config.power_up(profile),
        facts={
            "lookup_address": config.flash.address,
            "wall_second_ns": round(speed * NS_PER_S),
            **({"bootloader_baud": profile.processor.bootloader_baud or 0} if profile.processor else {}),
        },
        build=built(profile.parameters, config.parameters),
        verbs=board.table,
        time_out=time_out,
        follow=board.follow,
        framing=board.framing,
        send_buffers=profile.send_buffers,
        receive_buffers=profile.receive_buffers,
        own_map=catalogue.own_map(config, profile),
        resets_when_opened=profile.processor is not None and config.auto_reset,
    )
    device = bench.make(spec, config.axis_plans(profile, seed), group)
    _equip(device, config)
    return device


def _firmware(config: DeviceConfig, board: Profile) -> Callable[[Board], Firmware]:
    """Maker of the board's program, with the user's sketch if there is one."""
    if config.sketch and board.sketch:
        return board.sketch(config.sketch.file, config.sketch.text)
    return board.firmware or Idle


def axis_seed(config: BenchConfig, index: int) -> int:
    """Seed of the device of this number; far apart, so that bench 0's second is not bench 1's first."""
    return config.seed + (index << 32)


def partners(devices: Iterable[str], joints: Iterable[Iterable[str]]) -> dict[str, str]:
    """Map each device that ``joints`` join to earlier ones, over whatever way, to the first of them."""
    first = {name: name for name in devices}
    order = {name: place for place, name in enumerate(first)}
    for joint in filter(None, map(tuple, joints)):
        joined = {first[name] for name in joint}
        head = min(joined, key=order.__getitem__)
        first = {name: head if to in joined else to for name, to in first.items()}
    return {name: to for name, to in first.items() if name != to}


def bench_runtime(
    config: BenchConfig,
    catalogue: Catalogue,
    memories: Mapping[str, Mapping[str, bytes]],
    store: Store,
    around: BenchHooks = VIRTUAL,
) -> BenchRuntime:
    """Make all twins of a configuration at simulated time 0, none of which has run yet. ``memories`` has each
    device's non-volatile sections; ``store`` keeps what they write."""
    bench, joined = empty_bench(config, catalogue, store, around), joined_devices(config)
    for index, (name, device) in enumerate(config.twins.items()):
        memory, seed = memories.get(name, {}), axis_seed(config, index)
        group = bench.parts.group_of(joined[name]) if name in joined else bench.open_group()
        bench.add(group, make_device(bench, name, device, catalogue, memory, seed, group, config.speed))
    join_devices(bench, config, catalogue)
    return bench


def empty_bench(
    config: BenchConfig, catalogue: Catalogue, store: Store, around: BenchHooks = VIRTUAL
) -> BenchRuntime:
    """Make a bench without devices. The core has room for twice the axes of the configuration, and for
    ``LEAST_AXES``, so that a reload can add some, and for the groups of lines without stations.

    Raises:
        LanesRefused: the environment wants lanes that there are not.
    """
    axes = sum(places_of(device, catalogue) for device in config.devices.values())
    room = max(2 * axes, LEAST_AXES)
    core = Core(room + len(config.bus_wires()))
    choose_lanes(core, os.environ)
    return BenchRuntime(config.bench, core, store, around)


def places_of(device: DeviceConfig, catalogue: Catalogue) -> int:
    """Number of the core's places that a device takes: for its axes, or for its group alone."""
    return max(len(catalogue.profiles[device.profile].axes), 1)


def joined_devices(config: BenchConfig) -> dict[str, str]:
    """Map each twin that shares the time of earlier ones to the first of them."""
    return partners(config.twins, config.joints())


def join_devices(bench: BenchRuntime, config: BenchConfig, catalogue: Catalogue) -> None:
    """Join devices of the bench by wires, segments and buses; those that are joined are in one group."""
    for wire in config.wires:
        (source, output), (target, input_name) = wire.ends()
        axis = bench.parts.axis
        bench.core.wire((axis(source), output), (axis(target), input_name))
    for name, device in config.twins.items():
        _measure(bench, name, device)
        _place_magnet(bench, name, device)
    for number, (switch_name, switch) in enumerate(config.switches.items()):
        _add_switch(bench, switch_name, switch, switch_seed(config, number))
    for segment_name, wire_config in config.segments.items():
        _add_segment(bench, segment_name, wire_config, catalogue, config.seed)
    for kind in catalogue.wire_kinds:
        if config.wires_of(kind.key):
            kind.add(bench, config, catalogue)


def _equip(device: Twin, config: DeviceConfig) -> None:
    """Set what is around a processor: voltages at its pins, and the driver of its line."""
    if not (config.voltages or config.rs485) or (processor := device.axis.processor) is None:
        return
    for pin, voltage in config.voltages.items():
        if not isinstance(voltage, FieldVoltage):
            processor.set_volts(device.axis.kind.analog[pin], voltage)
    if config.rs485:
        device.uarts[""].has_driver = False
        processor.drives_line(config.rs485.de)


def _measure(bench: BenchRuntime, name: str, config: DeviceConfig) -> None:
    """Let voltages at a processor's pins follow fields of its group."""
    for pin, voltage in measured(config.voltages).items():
        source, field = voltage.source
        axis, of = bench.parts.axis(name), bench.parts.axis(source)
        if axis.processor is None:
            continue
        channel, mean = axis.kind.analog[pin], of.kind.means.get(field)
        if voltage.rc_s is None or mean is None:
            axis.processor.measure(channel, of.id, of.index(field), voltage.gain, voltage.offset_V)
        else:
            axis.processor.smooth(channel, of.id, mean, voltage.rc_s, voltage.gain, voltage.offset_V)


def _place_magnet(bench: BenchRuntime, name: str, config: DeviceConfig) -> None:
    """Put the magnet that an encoder reads on its shaft."""
    if magnet := config.magnet:
        shaft = bench.parts.axis(magnet.of)
        bench.parts.axis(name).place_magnet(shaft, zero_deg=magnet.zero_deg, is_reversed=magnet.reversed)


def switch_seed(config: BenchConfig, number: int) -> int:
    """Seed of the bounces of the switch of this number: beyond those of devices."""
    return (config.seed + ((1 << 20) + number << 32)) & SEED_MASK


def _add_switch(bench: BenchRuntime, name: str, config: "AxisSwitchConfig", seed: int) -> None:
    axis, pin_axis, pin = bench.parts.axis(config.axis), None, ""
    if config.to:
        of, pin = pin_of(config.to)
        pin_axis = bench.parts.axis(of)
    switch = axis.add_switch(config.native() | {"seed": seed}, pin_axis, pin)
    bench.parts.add_switch(owner_of(config.axis), name, switch)


def _add_segment(
    bench: BenchRuntime, name: str, config: "SegmentConfig", catalogue: Catalogue, bench_seed: int
) -> None:
    stations, members = config.addresses(), config.members()
    group = bench.parts.group_of(members[0]) if members else bench.open_group()
    framings = (bench.devices[device].framing for device, _ in stations)
    framing = framing_of(config, framings, catalogue)
    segment = make_segment(name, group, framing, FORMATS[config.format])
    most_ns = None if config.reaction_us is None else round(config.reaction_us * 1000)
    segment.reactions.spread(most_ns, bench_seed)
    bench.parts.add_wire(name, segment, group)
    bauds, of_programs = [config.baud] if config.baud else [], list[int]()
    for device, part in stations:
        uarts = bench.devices[device].uarts
        uart = part or str(station_uart(uarts))
        uarts[uart].join(segment, str(Address(device, uart)))
        # The speed of a processor is its program's: the line's is that of others, where there are any.
        (of_programs if uarts[uart].processor else bauds).append(uarts[uart].baud_now)
    baud = (*bauds, *of_programs, USUAL_BAUD)[0]
    line = NodeLine(segment, group, baud, catalogue.boards, __version__)
    for kind in catalogue.node_kinds:
        if nodes := getattr(config, kind.key):
            kind.add(bench, nodes, line)
    for tap_name, tap in config.taps.items():
        label = str(Address(name, tap_name))
        made = Tap(label, segment, group, baud, only_listens=tap.listen, is_real=tap.real)
        segment.join(label, made)
        bench.parts.add_tap(made, group)
        segment.set_echo(label, tap.hears_itself)
