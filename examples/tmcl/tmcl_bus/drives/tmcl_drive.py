"""Real TMCL module: what it is asked, and what it tells."""

import asyncio
import logging
from collections.abc import Callable, Mapping
from contextlib import suppress

from hil.drives.drive_fields import MOST_RPM, MOST_RPM_PER_S, common_verbs, drive_fields
from hil.drives.drive_link import ASKING, Denied, Garbled, NoAnswer, PlaceLost, Reading, Stale
from hil.drives.real_drive import FOUND_S, DrivePace, RealDrive
from hil.vocab.parameters import Parameter
from hil.vocab.verbs import Verb
from tmcl_bus.drives.tmcl_drive_address import TmclDriveAddress
from tmcl_bus.drives.tmcl_line import TmclLine, TmclLines
from tmcl_bus.frames import FULL_STEPS, Command, Request

ACTUAL_POSITION, ACTUAL_SPEED, MOST_SPEED, MOST_ACCELERATION, RESOLUTION = 1, 3, 4, 5, 140
_NEVER = ("enable", "disable")
"""Verbs of other drives: a module holds its motor by itself."""

log = logging.getLogger("hil")


def tmcl_verbs() -> dict[str, Verb]:
    """Verbs of a TMCL module, by name."""
    kept = "left out: as the module has it"
    speed, acceleration = f"speed on the way; {kept}", f"of both ramps; {kept}"
    ramps = (
        Parameter("velocity_rpm", speed, "rpm", 0.01, MOST_RPM, is_optional=True),
        Parameter("acceleration_rpm_per_s", acceleration, "rpm/s", 0.01, MOST_RPM_PER_S, is_optional=True),
    )
    verbs = common_verbs(ramps, "end all motion by the module's own ramp")
    return {verb.name: verb for verb in verbs if verb.name not in _NEVER}


class TmclDrive(RealDrive):
    """Module whose motor has 200 full steps in a turn."""

    follows_paths = False
    is_on = True
    fault = None

    def __init__(
        self, name: str, address: TmclDriveAddress, pace: DrivePace, now_ns: Callable[[], int]
    ) -> None:
        super().__init__(name, address, pace, now_ns)
        self._at = address
        self.fields, self.verbs = drive_fields(("velocity_rpm",)), tmcl_verbs()
        self.per_turn = FULL_STEPS << 8
        """Microsteps in a turn, as it told them."""
        self._version = 0
        self._line: TmclLine | None = None
        self._task: asyncio.Task[None] | None = None

    # ---- begin and end ----

    def start(self, lines: TmclLines) -> None:
        """Begin to ask it."""
        self._line = lines.join(self, self._at.place, self.pace.timeout_s)
        self._task = asyncio.get_running_loop().create_task(self._poll())

    async def close(self, lines: TmclLines) -> None:
        """End, and leave the line."""
        if self._task:
            self._task.cancel()
            with suppress(asyncio.CancelledError):
                await self._task
        line, self._line = self._line, None
        if line:
            await lines.leave(self, line)
        self.link.place_lost("it is not asked any more")

    # ---- what is asked ----

    async def ask(self, command: Command, type_: int, value: int, session: int | None) -> int:
        """Ask it something; answers the reply's value. ``session``: the one in which it is wanted; None: any.
        Raises ``ASKING``."""
        if session is not None and not self.is_in(session):
            raise Stale("the module was lost before it could be asked")
        if self._line is None:
            raise PlaceLost("it is not asked any more")
        loop, link, was_there = asyncio.get_running_loop(), self.link, self.link.is_there
        begun_s = loop.time()
        try:
            reply = await self._line.ask(Request(self._at.module, command, type_, 0, value), self._at.host)
        except NoAnswer as error:
            link.counters.time_outs += 1
            link.unanswered(str(error))
            raise
        except Garbled as error:
            link.counters.garbled += 1
            link.unanswered(str(error))
            raise
        except Denied:
            link.counters.exceptions += 1
            raise
        finally:
            if was_there:
                self.note(was_there)
        link.answered(round(loop.time() * 1e9), round((loop.time() - begun_s) * 1e9))
        return reply.value

    async def tell(self, command: Command, type_: int, value: int, session: int) -> None:
        """Give it a command. Raises ``ASKING``."""
        await self.ask(command, type_, value, session)
        self.link.counters.writes += 1

    async def _poll(self) -> None:
        """Read it forever."""
        while True:
            pause_s = self.pace.interval_s
            try:
                await self._once()
            except ASKING as error:
                if not self.link.is_there:
                    if isinstance(error, Denied):
                        self.link.refused(str(error))
                    pause_s = self.link.waits.take_ns() / 1e9
            except Exception as error:  # hil's own error: this module is not used for a while, the others are
                self.link.refused(f"an error of hil, see its log: {error!r}")
                log.exception("%s: the module at %s", self.name, self.address)
                pause_s = self.link.waits.take_ns() / 1e9
            await asyncio.sleep(pause_s)

    async def _once(self) -> None:
        link = self.link
        if link.state == "away":
            with suppress(TimeoutError):
                async with asyncio.timeout(FOUND_S):
                    await self.found.wait()
            return
        if link.is_there:
            self.note_reading(await self._read(link.session))
            return
        self._version = await self.ask(Command.GFV, 1, 0, None)
        self.per_turn = FULL_STEPS << await self.ask(Command.GAP, RESOLUTION, 0, None)
        reading = await self._read(None)
        self.sent = None
        link.greeted()
        self.note(False)
        self.note_reading(reading)

    async def _read(self, session: int | None) -> Reading:
        at_ns = self.now_ns()
        position = await self.ask(Command.GAP, ACTUAL_POSITION, 0, session)
        speed = await self.ask(Command.GAP, ACTUAL_SPEED, 0, session)
        values = {"position_deg": position * self.step_deg, "velocity_rpm": speed / self.per_turn * 60}
        return Reading(at_ns, values, {"status.moving": speed != 0})

    # ---- what it tells ----

    @property
    def step_deg(self) -> float:
        return 360 / self.per_turn

    @property
    def commanded_deg(self) -> float | None:
        return self.sent.deg if self.sent else None

    @property
    def identity(self) -> Mapping[str, str]:
        return {"version": f"{self._version >> 8 & 0xFF}.{self._version & 0xFF}"} if self._version else {}
