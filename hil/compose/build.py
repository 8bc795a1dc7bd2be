"""Builder of devices, axes and firmware for a validated configuration."""

from array import array
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from pathlib import Path

from hil.compose.find import PROFILES, load_verbs, make_segment
from hil.config import BenchConfig, Catalogue, DeviceConfig, ProfileInfo, SegmentConfig
from hil.core import Core
from hil.host.regular_file import read_regular
from hil.sim.bench import VIRTUAL, Around, BenchRuntime, Store
from hil.sim.device import Device
from hil.sim.group import Group
from hil.sim.hardware import DeviceSpec
from hil.sim.segment_tap import Tap
from hil.sim.setpoints import TimeOut
from hil.vocab.firmware import MAIN, NETWORK, Board, Firmware

LEAST_AXES = 8
TABLE_LEN = 16384
TABLE_FILE_BYTES = TABLE_LEN * 64
"""Maximum length of a table's file: a number has some ten characters."""
LOOKUP_SECTION = "lookup"
"""Section of a board's memory that holds the encoder's look-up table."""


class TableFileError(Exception):
    """A look-up table's file cannot be used: ``str(error)`` says which and why."""


def identity_table() -> bytes:
    """Make the table of a perfect encoder: angle = count * 360 / 16384, as float32."""
    return array("f", [i * 360 / TABLE_LEN for i in range(TABLE_LEN)]).tobytes()


def table_from_file(path: Path) -> bytes:
    """Read a table from a file: 16,384 numbers in degrees separated by white space or commas, as ``q`` prints
    them, or 65,536 bytes of little-endian float32.

    Raises:
        TableFileError: it cannot be read, or is neither.
    """
    try:
        data = read_regular(path, TABLE_FILE_BYTES)
    except OSError as error:
        raise TableFileError(f"{path}: {error.strerror}") from error
    if len(data) == TABLE_LEN * 4:
        return data
    try:
        angles = array("f", [float(word) for word in data.decode().replace(",", " ").split()])
    except (UnicodeDecodeError, ValueError) as error:
        raise TableFileError(f"{path}: neither numbers nor 65,536 bytes of float32 ({error})") from error
    if len(angles) != TABLE_LEN:
        raise TableFileError(f"{path}: {len(angles):,} angles instead of {TABLE_LEN:,}")
    return angles.tobytes()


def start_sections(config: DeviceConfig, stored: Mapping[str, bytes], folder: Path) -> dict[str, bytes]:
    """Make a device's memory at the start: what the configuration asks for, over what is stored. A table's
    file is looked up from ``folder``. Version 1 of the memory files had the table alone, without a name.

    Raises:
        TableFileError: the configured table's file cannot be used.
    """
    stored = {name or LOOKUP_SECTION: data for name, data in stored.items()}
    table = config.flash.table
    if table == "stored":
        return dict(stored)
    if table == "empty":
        return {name: data for name, data in stored.items() if name != LOOKUP_SECTION}
    packed = identity_table() if table == "identity" else table_from_file(folder / table)
    return dict(stored) | {LOOKUP_SECTION: packed}


def load_firmware(profile: ProfileInfo) -> Callable[[Board], Firmware]:
    """Load the class that a profile names as its firmware."""
    module, name = profile.firmware.split(":")
    made: Callable[[Board], Firmware] = getattr(import_module(f"{PROFILES}.{profile.name}.{module}"), name)
    return made


def make_device(
    bench: BenchRuntime,
    name: str,
    config: DeviceConfig,
    profile: ProfileInfo,
    sections: Mapping[str, bytes],
    seed: int,
    group: Group,
) -> Device:
    """Open an axis and make the device, which ``bench.add`` puts into its group. ``seed``: the axis's."""
    verbs = load_verbs(profile.name)
    time_out = None
    if (stream := config.setpoints) and verbs.starve:
        after_ns = round(stream.timeout_ms * 1e6)
        time_out = TimeOut(after_ns, stream.policy, stream.acceleration_rpm_per_s, verbs.starve)
    network = {NETWORK: profile.network_baud} if profile.network_baud is not None else {}
    spec = DeviceSpec(
        name=name,
        profile=profile.name,
        firmware=load_firmware(profile),
        bauds={MAIN: config.baud} | network,
        nvm=sections,
        power_up=config.register_values(profile) | {"spi_previous_command": config.spi_previous_command},
        facts={"lookup_address": config.flash.address},
        verbs=verbs.table,
        time_out=time_out,
        follow=verbs.follow,
    )
    return bench.make(spec, config.axis_plan(profile, seed), group)


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
    around: Around = VIRTUAL,
) -> BenchRuntime:
    """Make all twins of a configuration at simulated time 0, none of which has run yet. ``memories`` has each
    device's non-volatile sections; ``store`` keeps what they write."""
    bench, joined = empty_bench(config, store, around), joined_devices(config)
    for index, (name, device) in enumerate(config.twins.items()):
        profile, memory = catalogue.profiles[device.profile], memories.get(name, {})
        seed = axis_seed(config, index)
        group = bench.roster.group_of(joined[name]) if name in joined else bench.open_group()
        bench.add(group, make_device(bench, name, device, profile, memory, seed, group))
    join_devices(bench, config)
    return bench


def empty_bench(config: BenchConfig, store: Store, around: Around = VIRTUAL) -> BenchRuntime:
    """Make a bench without devices. The core has room for twice those of the configuration, and for
    ``LEAST_AXES``, so that a reload can add some, and for the groups of segments without stations."""
    room = max(2 * len(config.devices), LEAST_AXES)
    return BenchRuntime(config.bench, Core(room + len(config.segments)), store, around)


def joined_devices(config: BenchConfig) -> dict[str, str]:
    """Map each twin that shares the time of earlier ones to the first of them."""
    return partners(config.twins, config.joints())


def join_devices(bench: BenchRuntime, config: BenchConfig) -> None:
    """Join devices of the bench by wires and segments; those that are joined are in one group."""
    for wire in config.wires:
        (source, output), (target, input_name) = wire.ends()
        axes = {name: bench.devices[name].axis for name in (source, target)}
        bench.core.wire((axes[source], output), (axes[target], input_name))
    for segment_name, wire_config in config.segments.items():
        _add_segment(bench, segment_name, wire_config)


def _add_segment(bench: BenchRuntime, name: str, config: SegmentConfig) -> None:
    uarts = config.uarts()
    group = bench.roster.group_of(uarts[0][0]) if uarts else bench.open_group()
    segment = make_segment(group)
    bench.roster.add_segment(name, segment, group)
    for device, uart in uarts:
        bench.devices[device].uarts[uart].join(segment, f"{device}.{uart}")
    for tap_name, tap in config.taps.items():
        label = f"{name}.{tap_name}"
        made = Tap(label, segment, group, config.baud, only_listens=tap.listen, is_real=tap.real)
        bench.roster.add_tap(made, group)
        segment.set_echo(label, tap.echo)
