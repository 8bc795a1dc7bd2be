"""Real drive as an axis of runs, as ``hil.vocab.axis.Axis``.

A drive that takes a stream of set-points gets one, and keeps to the plan's path; another one is
sent to its angles, and makes ramps of its own.
"""

import asyncio
import logging
from collections.abc import Sequence
from contextlib import suppress

from hil.drives.drive_link import ASKING, Reading
from hil.drives.drive_motion import ARRIVED_DEG, DriveMotion
from hil.drives.real_drive import OLD_NS, RealDrive
from hil.runs import bounds_of
from hil.vocab.axis import NOT_JOINED, TURNS_RPM, AxisNow, AxisState, How, Sample
from hil.vocab.path import Path
from hil.vocab.time import SimTimeNs
from hil.vocab.verbs import VerbRefused

LEAD_NS = 250_000_000
"""Time to prepare a drive before a phrase: three writes, also on a serial line with others."""

log = logging.getLogger("hil")


class DriveAxis:
    """Axis of one drive. It is given to a run as a twin is, and holds its verbs up meanwhile."""

    refusal: str | None = None

    def __init__(self, drive: RealDrive, motion: DriveMotion) -> None:
        self.drive, self.motion = drive, motion
        self.is_held = False
        """True while a run has it."""
        self._session = 0
        self._why: str | None = None
        self._samples: list[Sample] = []
        self._start_deg: float | None = None
        self._stopping: asyncio.Task[None] | None = None
        self._was_on = False
        drive.listeners.append(self._sample)

    @property
    def follows_paths(self) -> bool:
        return self.drive.follows_paths

    @property
    def lead_ns(self) -> int:
        return LEAD_NS + round(self.drive.pace.timeout_s * 1e9)

    # ---- what is known of it ----

    def now(self) -> AxisNow:
        """The axis as a plan begins with it."""
        return AxisNow(
            self._planned_from_deg(),
            self.follows_paths,
            tuple(self.drive.fields),
            (),
            *self._obstacle(),
            bounds=bounds_of(self.drive.verbs, follows_paths=self.follows_paths),
            is_awaited=True,
        )

    def _planned_from_deg(self) -> float:
        """Angle from which a motion is planned. A shaft that only trembles is where it was."""
        here_deg = self.drive.position_deg
        if here_deg is None:
            return 0.0
        commanded_deg = self.drive.commanded_deg if self.drive.is_on else None
        for known_deg in (commanded_deg, self._start_deg):
            if known_deg is not None and abs(known_deg - here_deg) <= ARRIVED_DEG:
                self._start_deg = known_deg
                return known_deg
        self._start_deg = here_deg
        return here_deg

    def _obstacle(self) -> tuple[str | None, str]:
        """Reason why the axis cannot take part, if there is one, and what helps."""
        drive = self.drive
        if not drive.link.is_there:
            return f"it is a real drive, and not there: {drive.link.why}", "connect it, or leave it out"
        if not drive.has_angle:
            return "it only turns, and knows no angle", "leave it out; `hil axis NAME run` lets it turn"
        if drive.fault:
            return drive.fault, f"`hil axis {drive.name} clear-fault` first"
        if not drive.is_on:
            return "its loop is off", f"`hil axis {drive.name} enable` first"
        stop = f"wait for its end, or `hil axis {drive.name} stop` first"
        return ("it moves", stop) if self._is_moving else (None, "")

    @property
    def _is_moving(self) -> bool:
        reading = self.drive.reading
        if reading is None or not self.drive.link.is_there:
            return False
        moves = reading.bits.get("status.moving")
        turns = abs(reading.values.get("velocity_rpm", 0.0)) > TURNS_RPM
        is_stopping = self._stopping is not None and not self._stopping.done()
        return self.motion.is_under_way or is_stopping or (turns if moves is None else moves)

    @property
    def failure(self) -> str | None:
        drive = self.drive
        if why := self._why or self.motion.failure:
            return why
        if not drive.link.is_there:
            return f"the drive at {drive.address} is lost: {drive.link.why}"
        if not self.is_held:
            return None
        if drive.link.session != self._session:
            return "the drive was lost, and is back: what it was given is not known to it"
        if drive.fault:
            return drive.fault
        if self._was_on and not drive.is_on:
            return "its loop is off; somebody disabled it"
        reading = drive.reading
        age_ns = drive.now_ns() - reading.at_ns if reading else 0
        if age_ns > OLD_NS + drive.pace.timeout_s * 1e9 + drive.pace.interval_s * 1e9:
            return f"the drive at {drive.address} has told nothing for {age_ns / 1e6:.0f} ms"
        return None

    def state(self) -> AxisState:
        drive, motion = self.drive, self.motion
        reading = drive.reading
        at_ns = reading.at_ns if reading else 0
        if (end_ns := motion.stream_end_ns) is not None:  # its last set-point may be on its way
            at_ns = min(at_ns, end_ns)
        return AxisState(
            SimTimeNs(at_ns),
            drive.commanded_deg,
            drive.position_deg,
            self._is_moving,
            motion.is_under_way,
            drive.is_on and drive.link.is_there,
            drive.is_on,
        )

    def field(self, name: str) -> float:
        return self.drive.values()[name]

    def samples(self) -> Sequence[Sample]:
        taken, self._samples = self._samples, []
        return taken

    def _sample(self, reading: Reading) -> None:
        if not self.is_held or not self.follows_paths:
            return
        commanded_deg = self.drive.sent.deg if self.drive.sent else None
        if commanded_deg is not None and self.motion.is_under_way:
            self._samples.append((reading.at_ns, commanded_deg, reading.values["position_deg"]))

    # ---- what a run does with it ----

    def hold(self) -> None:
        self._session, self._why, self._samples = self.drive.link.session, None, []
        self.motion.forget()
        self.is_held, self._was_on = True, self.drive.is_on

    def release(self) -> None:
        self.is_held = False
        asyncio.get_running_loop().create_task(self._let_go(self._stopping))

    async def _let_go(self, stopping: "asyncio.Task[None] | None") -> None:
        if stopping:
            await asyncio.wait([stopping])
        if not self.is_held:
            await self.motion.end()

    def follow(self, path: Path, start_ns: int) -> int:
        self._check_session()
        self.motion.follow(path, start_ns)
        return start_ns

    def join(self, path: Path, start_ns: int) -> None:
        raise VerbRefused("cannot", NOT_JOINED)

    def move(self, position_deg: float, velocity_rpm: float, start_ns: int) -> None:
        self._check_session()
        self.motion.move(position_deg, velocity_rpm, None, start_ns)

    def _check_session(self) -> None:
        if why := self.failure:
            raise VerbRefused("not_now", why)

    def stop(self, how: How, acceleration_rpm_per_s: float) -> None:
        """Break off what the drive does, and stop it; one that is lost gets nothing more."""
        if not self.drive.link.is_there or self.drive.link.session != self._session:
            self.motion.abandon()
            return
        doing = self._stop(how, acceleration_rpm_per_s)
        self._stopping = asyncio.get_running_loop().create_task(doing)

    async def _stop(self, how: How, acceleration_rpm_per_s: float) -> None:
        try:
            await self.motion.stop(how, acceleration_rpm_per_s)
        except ASKING as error:
            self._why = self._why or f"it could not be told to stop: {error}"
            log.warning("%s: it could not be told to stop: %s", self.drive.name, error)

    def stopped_by(self, verb: str) -> None:
        """Note that somebody stops the drive that a run has: the run fails."""
        if self.is_held:
            self._why = self._why or f"somebody gave it the verb {verb}"

    def set_pin(self, pin: str, level: int, at_ns: int) -> None:
        raise VerbRefused("cannot", "a real drive has no inputs that hil drives")

    async def end(self) -> None:
        """Stop what moves, as the daemon ends or the drive is taken away."""
        if self.motion.is_under_way and self.drive.link.is_there:
            with suppress(*ASKING, TimeoutError):
                async with asyncio.timeout(2 * self.drive.pace.timeout_s + 1.0):
                    await self.motion.stop("prejudice")
        self.motion.close()
        self.drive.listeners.remove(self._sample)
