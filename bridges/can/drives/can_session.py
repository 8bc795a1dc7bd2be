"""Sessions of a real CANopen drive: it is greeted, watched while it is there, and greeted again."""

import asyncio
import logging
from contextlib import suppress
from dataclasses import replace

from bridges.can.canopen.master.drive_units import UnitsUnknown
from bridges.can.canopen.master.greeting import DriveKnown, GreetingPause, Nmt, Step, Unfit, greet
from bridges.can.canopen.master.node_watch import HEARTBEAT_NS
from bridges.can.canopen.master.sdo_transfer import SdoTransfer
from bridges.can.drives.can_drive import CanDrive
from bridges.can.drives.sdo_dialogue import Aborted
from hil.drives.drive_link import ASKING, NoAnswer
from hil.drives.real_drive import FOUND_S, OLD_NS

_SESSION_LOOK_S = 0.02
FIRST_STATE_S = 1.0
"""Time for the first process data to come after the drive was started."""

log = logging.getLogger("hil")


class CanSession:
    """Keeper of one drive's sessions."""

    def __init__(self, drive: CanDrive) -> None:
        self._drive, self._link = drive, drive.link

    async def run(self) -> None:
        """Keep to the drive forever."""
        drive = self._drive
        while True:
            if self._is_away:
                with suppress(TimeoutError):
                    async with asyncio.timeout(FOUND_S):
                        await drive.found.wait()
                continue
            drive.booted.clear()
            try:
                await self._begin()
                why = await self._watch()
            except (*ASKING, Unfit, UnitsUnknown) as error:
                why = str(error)
            except Exception as error:  # hil's own error: this drive is not used for a while, the others are
                why = f"an error of hil, see its log: {error!r}"
                log.exception("%s: the drive at %s", drive.name, drive.address)
            if not self._is_away:
                drive.lose(why)
                await self._pause()

    @property
    def _is_away(self) -> bool:
        return self._link.state == "away"

    async def _pause(self) -> None:
        """Wait before the next greeting: a boot-up ends that, as the drive is there again."""
        with suppress(TimeoutError):
            async with asyncio.timeout(self._link.waits.take_ns() / 1e9):
                await self._drive.booted.wait()

    async def _begin(self) -> None:
        """Greet the drive, wait for its state, and begin a session."""
        drive = self._drive
        known = await self._greeted()
        drive.known, begun_ns = known, drive.now_ns()
        drive.watch.begin(begun_ns, known.error_control)
        if known.told and not await self._has_told(begun_ns):
            known = drive.known = replace(known, told=(), has_target_pdo=False)
        if not known.told:
            await self._poll(None)
        drive.begin_session()

    async def _greeted(self) -> DriveKnown:
        steps = greet(self._drive.greet_spec)
        step = next(steps)
        while True:
            try:
                try:
                    answer = await self._carry_out(step)
                except Aborted as error:
                    step = steps.throw(error.sdo)
                else:
                    step = steps.send(answer)
            except StopIteration as end:
                known: DriveKnown = end.value
                return known

    async def _carry_out(self, step: Step) -> bytes:
        match step:
            case SdoTransfer():
                return await self._drive.transfer(step, None)
            case Nmt():
                self._drive.command(step.command)
            case GreetingPause():
                await asyncio.sleep(step.ns / 1e9)
        return b""

    async def _has_told(self, since_ns: int) -> bool:
        """Wait for the first process data; False: they do not come."""
        drive = self._drive
        for _ in range(round(FIRST_STATE_S / _SESSION_LOOK_S)):
            await asyncio.sleep(_SESSION_LOOK_S)
            if drive.reading and drive.reading.at_ns > since_ns:
                return True
        return False

    async def _watch(self) -> str:
        """Watch the drive while it is there; answers why it is lost."""
        drive, session = self._drive, self._link.session
        asked_ns = polled_ns = 0
        while drive.is_in(session):
            now_ns = drive.now_ns()
            if why := drive.watch.loss(now_ns) or self._silence(now_ns):
                return why
            if drive.watch.is_guarded and now_ns - asked_ns >= HEARTBEAT_NS:
                asked_ns = now_ns
                drive.ask_for_life()
            if drive.known and not drive.known.told and now_ns - polled_ns >= drive.pace.interval_s * 1e9:
                polled_ns = now_ns
                await self._poll(session)
            await asyncio.sleep(min(_SESSION_LOOK_S, drive.pace.interval_s))
        return self._link.why

    def _silence(self, now_ns: int) -> str | None:
        """Reason why a drive without any process data is lost, or None."""
        drive = self._drive
        if not (drive.known and drive.known.told and drive.reading):
            return None
        age_ns = now_ns - drive.reading.at_ns
        allowed_ns = OLD_NS + (drive.pace.timeout_s + 3 * drive.pace.interval_s) * 1e9
        return f"no process data for {age_ns / 1e6:.0f} ms" if age_ns > allowed_ns else None

    async def _poll(self, session: int | None) -> None:
        """Read the state by SDO, of a drive that lets itself be mapped no process data."""
        drive = self._drive
        assert drive.known is not None, "a drive is greeted first"
        at_ns, raw = drive.now_ns(), {}
        for each in drive.known.read:
            with suppress(Aborted):
                raw[each.field] = await drive.read(each.index, session, is_signed=each.is_signed)
        if not {"statusword", "position"} <= raw.keys():
            raise NoAnswer("it does not tell its statusword and its position")
        drive.take_raw(raw, at_ns)
