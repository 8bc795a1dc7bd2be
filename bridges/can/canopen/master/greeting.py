"""Greeting of a drive: all that has to be known of it, and how it is set up, before it is used.

A generator: it yields what is to be done, and gets the bytes that were read, or ``TransferAborted`` raised
in it.
"""

from collections.abc import Generator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from bridges.can.canopen.can_ids import INVALID, NO_RTR, RPDO, TPDO
from bridges.can.canopen.canopen_codes import NmtCommand
from bridges.can.canopen.cia402_words import CYCLIC_POSITION, PROFILE_POSITION, mode_bit
from bridges.can.canopen.master.drive_units import FACTOR_OBJECTS, DriveUnits, GivenUnits, units_of
from bridges.can.canopen.master.node_watch import HEARTBEAT_NS, MISSING
from bridges.can.canopen.master.process_data import (
    NEEDED,
    TARGET,
    TOLD,
    MappedValue,
    ObjectWrite,
    mapping_writes,
    parameter_index,
)
from bridges.can.canopen.master.sdo_transfer import SdoTransfer, TransferAborted

SETTLES_NS = 20_000_000
"""Time for a node to change its state."""
EVERY_SYNC, MOST_SYNCS = 1, 240
"""Transmission types: with each SYNC, with each 240th."""
MASTER_LATE_NS = 5 * HEARTBEAT_NS
"""Time without the master's heartbeat after which a drive stops by itself."""
IDENTITY = ("vendor", "product", "revision", "serial")
"""Numbers of 1018h, sub-index 1 to 4."""


class Nmt(NamedTuple):
    """Command to the node."""

    command: int


class GreetingPause(NamedTuple):
    """Wait."""

    ns: int


AS_IT_SAYS = GivenUnits()
Step = SdoTransfer | Nmt | GreetingPause
Greeting = Generator[Step, bytes, "DriveKnown"]


class Unfit(Exception):
    """Drive that cannot be used; ``str(error)`` says why."""


@dataclass(frozen=True)
class GreetSpec:
    """Greeting of a drive. ``syncs``: number of SYNCs from one state to the next."""

    node: int
    sync_ns: int
    syncs: int = 1
    master: int | None = None
    """Node whose heartbeat it is to watch; None: nobody's."""
    given: GivenUnits = AS_IT_SAYS


@dataclass(frozen=True)
class DriveKnown:
    """All that is known of a drive after its greeting."""

    units: DriveUnits
    modes: int
    """Its 6502h: supported modes."""
    identity: Mapping[str, int] = field(default_factory=dict)
    name: str = ""
    """Its 1008h."""
    told: tuple[tuple[MappedValue, ...], ...] = ()
    """Objects of its TPDOs from the first on; empty: it lets itself be mapped no PDOs, and is read by SDO."""
    read: tuple[MappedValue, ...] = ()
    """Objects of its state that it has."""
    has_target_pdo: bool = False
    """True if an RPDO carries the set-point, taken with SYNC."""
    error_control: str = ""
    """``heartbeat``, ``guarding``, or empty: it has neither."""
    watches: bool = False
    """True if it watches the master's heartbeat."""

    @property
    def texts(self) -> dict[str, str]:
        """The drive's identity as it tells it, by names."""
        numbers = {name: f"{number:08X}h" for name, number in self.identity.items()}
        return ({"name": self.name} if self.name else {}) | numbers

    def has_mode(self, mode: int) -> bool:
        return bool(self.modes & mode_bit(mode))

    @property
    def follows_paths(self) -> bool:
        """True if it takes a stream of set-points, one with each SYNC."""
        return self.has_target_pdo and bool(self.told) and self.has_mode(CYCLIC_POSITION)


def greet(spec: GreetSpec) -> Greeting:
    """Greet a drive.

    Raises:
        Unfit, UnitsUnknown: it cannot be used.
    """
    device_type = yield from _number(0x1000, 0)
    if device_type is None or device_type & 0xFFFF != 402:
        raise Unfit(f"it is no drive of CiA 402: its device type is {device_type or 0:08X}h")
    identity = {}
    for subindex, name in enumerate(IDENTITY, 1):
        if (number := (yield from _number(0x1018, subindex))) is not None:
            identity[name] = number
    title = yield from _text(0x1008)
    modes = yield from _number(0x6502, 0)
    modes = mode_bit(PROFILE_POSITION) if modes is None else modes
    if not modes & (mode_bit(PROFILE_POSITION) | mode_bit(CYCLIC_POSITION)):
        raise Unfit(f"it has neither profile position nor cyclic synchronous position (6502h: {modes:08X}h)")
    objects = {}
    for index, subindex in FACTOR_OBJECTS:
        if (number := (yield from _number(index, subindex))) is not None:
            objects[index, subindex] = number
    units = units_of(objects, spec.given)
    yield Nmt(NmtCommand.PRE_OPERATIONAL)
    yield GreetingPause(SETTLES_NS)
    error_control = yield from _error_control()
    watches = yield from _watch_of_master(spec.master)
    read = yield from _state_objects(has_current=units.current_A is not None)
    told = yield from _map_told(spec, read)
    has_target = False
    if told and modes & mode_bit(CYCLIC_POSITION):
        has_target = yield from _map_target(spec)
    yield Nmt(NmtCommand.START)
    yield GreetingPause(SETTLES_NS)
    return DriveKnown(units, modes, identity, title, told, read, has_target, error_control, watches)


def sync_period_ns(wanted_ns: int) -> int:
    """Period of SYNC nearest to one that is wanted which 60C2h can say: whole milliseconds, or tenths up to
    25.5 ms."""
    step_ns = 100_000 if wanted_ns <= 25_500_000 else 1_000_000
    return min(max(round(wanted_ns / step_ns), 1), 255) * step_ns


def interpolation_time(period_ns: int) -> tuple[int, int]:
    """Values of 60C2h, sub-index 1 and 2: a number, and its power of ten in seconds."""
    if period_ns % 1_000_000 == 0 and period_ns <= 255_000_000:
        return period_ns // 1_000_000, -3
    return period_ns // 100_000, -4


def _number(index: int, subindex: int) -> Generator[Step, bytes, int | None]:
    """Read a whole number; None: the drive does not have it."""
    try:
        data = yield SdoTransfer(index, subindex)
    except TransferAborted:
        return None
    return int.from_bytes(data, "little")


def _text(index: int) -> Generator[Step, bytes, str]:
    try:
        data = yield SdoTransfer(index)
    except TransferAborted:
        return ""
    return "".join(c for c in data.split(b"\0")[0].decode("latin-1") if c.isprintable())[:64]


def _write(what: ObjectWrite) -> Step:
    data = (what.value & ((1 << 8 * what.size) - 1)).to_bytes(what.size, "little")
    return SdoTransfer(what.index, what.subindex, data)


def _try(*writes: ObjectWrite) -> Generator[Step, bytes, bool]:
    """Write all of these; False: the drive refused one, and those behind it were not tried."""
    for what in writes:
        try:
            yield _write(what)
        except TransferAborted:
            return False
    return True


def _error_control() -> Generator[Step, bytes, str]:
    interval_ms = HEARTBEAT_NS // 1_000_000
    if (yield from _try(ObjectWrite(0x1017, 0, interval_ms, 2))):
        return "heartbeat"
    if (yield from _try(ObjectWrite(0x100C, 0, interval_ms, 2), ObjectWrite(0x100D, 0, MISSING, 1))):
        return "guarding"
    return ""


def _watch_of_master(master: int | None) -> Generator[Step, bytes, bool]:
    """Let the drive watch the master's heartbeat, and do as its 6007h says without it."""
    if master is None:
        return False
    late_ms = MASTER_LATE_NS // 1_000_000
    return (yield from _try(ObjectWrite(0x1016, 1, master << 16 | late_ms, 4)))


def _state_objects(*, has_current: bool) -> Generator[Step, bytes, tuple[MappedValue, ...]]:
    """Objects of the drive's state that it has."""
    found = []
    for each in (each for objects in TOLD for each in objects):
        if each.field == "current" and not has_current:
            continue
        if (yield from _number(each.index, 0)) is not None:
            found.append(each)
        elif each in NEEDED:
            raise Unfit(f"it has no {each.field} ({each.index:04X}h)")
    return tuple(found)


def _map_told(
    spec: GreetSpec, read: tuple[MappedValue, ...]
) -> Generator[Step, bytes, tuple[tuple[MappedValue, ...], ...]]:
    """Map TPDO 1 and 2, and switch off those behind them."""
    kind = min(max(spec.syncs, EVERY_SYNC), MOST_SYNCS)
    told = []
    for number, objects in enumerate(TOLD):
        wanted = tuple(each for each in objects if each in read)
        is_mapped = bool(wanted) and (yield from _map(spec.node, number, wanted, kind))
        if number == 0 and not is_mapped:
            return ()
        if is_mapped:
            told.append(wanted)
    for number in range(len(told), len(TPDO)):
        identifier = TPDO[number] + spec.node | INVALID
        yield from _try(ObjectWrite(parameter_index(number), 1, identifier, 4))
    return tuple(told)


def _map_target(spec: GreetSpec) -> Generator[Step, bytes, bool]:
    """Map the first RPDO to the set-point, and say how far apart set-points are. Drives of a fixed
    interpolation time have no 60C2h; 1006h is for those that supervise SYNC."""
    value, exponent = interpolation_time(spec.sync_ns)
    yield from _try(ObjectWrite(0x60C2, 2, exponent, 1), ObjectWrite(0x60C2, 1, value, 1))
    yield from _try(ObjectWrite(0x1006, 0, spec.sync_ns // 1000, 4))
    return (yield from _map(spec.node, 0, (TARGET,), EVERY_SYNC, is_rpdo=True))


def _map(
    node: int, number: int, objects: tuple[MappedValue, ...], kind: int, *, is_rpdo: bool = False
) -> Generator[Step, bytes, bool]:
    index = parameter_index(number, is_rpdo=is_rpdo)
    if (now := (yield from _number(index, 1))) is None:
        return False
    identifier = (RPDO if is_rpdo else TPDO)[number] + node
    if not is_rpdo:
        identifier |= now & NO_RTR  # whether remote frames ask for it is the drive's own
    return (yield from _try(*mapping_writes(identifier, number, objects, kind, is_rpdo=is_rpdo)))
