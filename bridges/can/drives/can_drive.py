"""Real CANopen drive: what is read and written of its objects, and what its frames tell."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Coroutine, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from bridges.can.canopen.can_ids import ERROR_CONTROL, RPDO, SDO_REQUEST
from bridges.can.canopen.master.drive_state import EmergencyLog, fault_text, reading_of
from bridges.can.canopen.master.drive_units import GivenUnits
from bridges.can.canopen.master.greeting import AS_IT_SAYS, DriveKnown, GreetSpec
from bridges.can.canopen.master.node_watch import NodeWatch
from bridges.can.canopen.master.process_data import SyncBeat, packed_target, values_in
from bridges.can.canopen.master.sdo_transfer import SdoTransfer
from bridges.can.drives.can_drive_address import CanDriveAddress
from bridges.can.drives.can_line import CanLine
from bridges.can.drives.sdo_dialogue import SdoDialogue
from bridges.can.frames.can_frame import CanFrame
from hil.drives.drive_fields import MOST_RPM, MOST_RPM_PER_S, common_verbs, drive_fields, drive_verb
from hil.drives.drive_link import ASKING, PlaceLost
from hil.drives.real_drive import DrivePace, RealDrive, SentSetPoint
from hil.vocab.parameters import Parameter
from hil.vocab.verbs import Verb


def can_verbs() -> dict[str, Verb]:
    """Verbs of a CANopen drive, by name."""
    kept = "left out: as the drive has it"
    ramps = (
        Parameter(
            "velocity_rpm", f"largest speed on the way; {kept}", "rpm", 0.01, MOST_RPM, is_optional=True
        ),
        Parameter(
            "acceleration_rpm_per_s",
            f"of both ramps; {kept}",
            "rpm/s",
            0.01,
            MOST_RPM_PER_S,
            is_optional=True,
        ),
    )
    verbs = common_verbs(ramps, "end all motion by the drive's quick stop, and hold the shaft there")
    method = Parameter(
        "method", f"number of CiA 402 (6098h); {kept}", "", -128, 127, is_whole=True, is_optional=True
    )
    verbs.append(drive_verb("home", "find the origin by the drive's homing", method))
    verbs.append(drive_verb("clear_fault", "clear the drive's fault"))
    verbs.append(drive_verb("reset", "let the drive start again, as after power-up (NMT reset node)"))
    return {verb.name: verb for verb in verbs}


TOLD = ("velocity_rpm", "current_A", "fault_code")
OWN_FIELDS = (
    ("statusword", "i32", "", "object 6041h of a CANopen drive"),
    ("mode", "i32", "", "object 6061h of a CANopen drive: its mode of operation"),
    ("emergencies", "i64", "", "emergency messages of a CANopen drive"),
)
NOT_WATCHED = "it does not watch its master: it has no 1016h"

log = logging.getLogger("hil")


@dataclass(frozen=True)
class CanSpec:
    """Configuration of a real CANopen drive."""

    name: str
    address: CanDriveAddress
    pace: DrivePace
    units: GivenUnits = AS_IT_SAYS


class CanDrive(RealDrive):
    """Drive of CiA 402 on a CAN bus."""

    def __init__(self, spec: CanSpec, now_ns: Callable[[], int]) -> None:
        super().__init__(spec.name, spec.address, spec.pace, now_ns)
        self.spec, self.node, self.master = spec, spec.address.node, spec.address.master
        self.fields, self.verbs = drive_fields(TOLD, own=OWN_FIELDS), can_verbs()
        self.known: DriveKnown | None = None
        """Identity that its greeting found; also of a session that has ended."""
        self.watch = NodeWatch(round((spec.pace.timeout_s) * 1e9))
        self.set_points: Callable[[int], float] | None = None
        """Set-points that go out with SYNC: degrees at a time."""
        self.is_stopping = False
        """True while its loop is off for a stop alone, which ends with the loop on."""
        self.booted = asyncio.Event()
        """Set when it tells its boot-up."""
        self.emergencies = EmergencyLog()
        self._line: CanLine | None = None
        self._task: asyncio.Task[None] | None = None
        self._sdo = SdoDialogue(self._send_request, self._unanswered, self.link, spec.pace.timeout_s)
        self._raw: dict[str, int] = {}
        self._seen: set[int] = set()
        self._beat = SyncBeat()

    # ---- begin and end ----

    def start(self, join: Callable[["CanDrive"], CanLine], session: Coroutine[Any, Any, None]) -> None:
        """Begin with it, on the bus that ``join`` gives. ``session``: what keeps to it forever."""
        self._line = join(self)
        self._task = asyncio.get_running_loop().create_task(session)

    async def close(self, leave: Callable[["CanDrive", CanLine], Awaitable[None]]) -> None:
        """End, and leave the bus."""
        if self._task:
            self._task.cancel()
            with suppress(asyncio.CancelledError):
                await self._task
        if self.link.is_there and self.known and self.known.watches:
            with suppress(*ASKING):  # what the daemon does not do any more is no fault of the drive's
                await self.transfer(SdoTransfer(0x1016, 1, bytes(4)), None)
        line, self._line = self._line, None
        if line:
            await leave(self, line)
        self.link.place_lost("it is not asked any more")

    @property
    def greet_spec(self) -> GreetSpec:
        """Specification of the greeting, from the configuration."""
        sync_ns = self.line.sync_ns
        syncs = max(round(self.pace.interval_s * 1e9 / sync_ns), 1)
        return GreetSpec(self.node, sync_ns, syncs, self.master, self.spec.units)

    @property
    def line(self) -> CanLine:
        """Its bus. Raises PlaceLost."""
        if self._line is None:
            raise PlaceLost("it is not asked any more")
        return self._line

    def begin_session(self) -> None:
        """Begin a session: what was told in the one before counts no more."""
        self.sent = self.set_points = None
        self.link.greeted()
        self.note(False)

    def lose(self, why: str) -> None:
        """Note that the drive is lost."""
        was_there = self.link.is_there
        self.set_points = None
        self.watch.end()
        self.link.refused(why)
        self.note(was_there)

    def place_lost(self, why: str) -> None:
        self.set_points = None
        self.watch.end()
        self._sdo.place_lost(why)
        super().place_lost(why)

    # ---- its objects ----

    async def read(self, index: int, session: int | None, *, is_signed: bool = False) -> int:
        """Read a whole number. Raises ``ASKING``."""
        data = await self.transfer(SdoTransfer(index), session)
        return int.from_bytes(data, "little", signed=is_signed)

    async def write(self, index: int, value: int, size: int, session: int | None) -> None:
        """Write a whole number of ``size`` bytes. Raises ``ASKING``."""
        data = (value & ((1 << 8 * size) - 1)).to_bytes(size, "little")
        await self.transfer(SdoTransfer(index, 0, data), session)
        self.link.counters.writes += 1

    async def transfer(self, what: SdoTransfer, session: int | None) -> bytes:
        """Carry out a transfer. ``session``: the one in which it is wanted; None: any. Raises ``ASKING``."""
        return await self._sdo.carry_out(what, lambda: session is None or self.is_in(session))

    def _send_request(self, data: bytes) -> None:
        self.line.send(SDO_REQUEST + self.node, data)

    def _unanswered(self, why: str) -> None:
        was_there = self.link.is_there
        self.link.unanswered(why)
        self.note(was_there)

    def command(self, command: int) -> None:
        """Send a command of network management. Raises PlaceLost."""
        self.line.send(0, bytes([command, self.node]))

    def ask_for_life(self) -> None:
        """Send the request of guarding. Raises PlaceLost."""
        self.line.ask_remotely(ERROR_CONTROL + self.node, 1)

    # ---- its frames ----

    @property
    def wants_sync(self) -> bool:
        return self.watch.is_on and bool(self.known and self.known.told)

    def before_sync(self) -> tuple[CanFrame, ...]:
        line, known, set_points = self._line, self.known, self.set_points
        if line is None:
            return ()
        beat_ns = self._beat.next(self.now_ns(), line.sync_ns)
        self._seen.clear()
        if set_points is None or known is None:
            return ()
        # The drive is there one period later: at the next SYNC.
        units = known.units.position(set_points(beat_ns + line.sync_ns))
        self.sent = SentSetPoint(set_points(beat_ns), beat_ns)
        return (CanFrame(RPDO[0] + self.node, packed_target(units)),)

    def hear_answer(self, data: bytes) -> None:
        self._sdo.hear(data)

    def hear_process_data(self, number: int, data: bytes) -> None:
        known = self.known
        if known is None or not self.wants_sync or number >= len(known.told):
            return
        values = values_in(known.told[number], data)
        if values is None:
            self.link.counters.garbled += 1
            return
        self._raw |= values
        self._seen.add(number)
        if len(self._seen) == len(known.told):
            self._seen.clear()
            now_s = asyncio.get_running_loop().time()
            self.link.answered(round(now_s * 1e9), max(self.now_ns() - self._beat.synced_ns, 0))
            self.take_raw(self._raw, self._beat.synced_ns)

    def take_raw(self, raw: Mapping[str, int], at_ns: int) -> None:
        """Take over the values of its objects, by their names, as they were at a time."""
        assert self.known is not None, "a drive that was not greeted tells nothing"
        self.note_reading(reading_of(raw, self.known.units, at_ns))

    def hear_error_control(self, data: bytes) -> None:
        if self.watch.hear(data, self.now_ns()):
            self.booted.set()

    def hear_emergency(self, data: bytes) -> None:
        if said := self.emergencies.hear(data):
            log.warning("%s: %s", self.name, said)

    # ---- what it tells ----

    @property
    def follows_paths(self) -> bool:
        return self.known is not None and self.known.follows_paths

    @property
    def step_deg(self) -> float:
        return 1 / self.known.units.position_per_deg if self.known else 0.0

    @property
    def is_on(self) -> bool:
        return self.is_stopping or (self.reading is not None and self.reading.bits["status.enabled"])

    @property
    def fault(self) -> str | None:
        return fault_text(self.reading, self.emergencies.text) if self.reading else None

    @property
    def commanded_deg(self) -> float | None:
        return self.sent.deg if self.sent else None

    @property
    def notes(self) -> tuple[str, ...]:
        found = [f"emergency {self.emergencies.text}"] if self.emergencies.text else []
        is_unwatched = self.master is not None and self.known is not None and not self.known.watches
        return (*found, *([NOT_WATCHED] if is_unwatched else []))

    @property
    def identity(self) -> Mapping[str, str]:
        if self.known is None:
            return {}
        return self.known.texts

    def values(self) -> dict[str, float]:
        return super().values() | {"emergencies": self.emergencies.count}
