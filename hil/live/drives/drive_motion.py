"""Motion of a real drive, by its own ramps or by a stream of set-points, and whether it has come to its end.

A motion is of one session of the drive's link: when the drive is lost, the motion has failed, and nothing of
it is sent when the drive is back.
"""

import asyncio
from collections.abc import Coroutine
from contextlib import suppress
from typing import Any

from hil.drives.arrival import ARRIVED_DEG, Arrival
from hil.drives.control_bits import value_write
from hil.drives.poll_plan import Reading
from hil.firmware.set_point_paths import at, length_ns, to_rest
from hil.live.drives.drive_line import URGENT, Stale
from hil.live.drives.modbus_client import NoAnswer, PlaceLost
from hil.live.drives.real_drive import ASKING, RealDrive
from hil.vocab.axis import How
from hil.vocab.path import DEG_PER_S, Path
from hil.vocab.verbs import VerbRefused

PULSE_S = 0.05
"""Time for which a bit that acts as it becomes 1 stays so: longer than a drive's own cycle."""
LATE_NS = 500_000_000
"""Time without a confirmed set-point after which a stream has failed."""


class DriveMotion:
    """Motion of one drive, the last that it was given."""

    def __init__(self, drive: RealDrive) -> None:
        self._drive = drive
        self.failure: str | None = None
        """Reason why the motion does not do what it was given."""
        self._arrival: Arrival | None = None
        self._task: asyncio.Task[None] | None = None
        self._path: tuple[Path, int] | None = None
        """Path that is streamed, and its beginning."""
        self._begins_ns: int | None = None
        """Beginning of a move that is not given yet."""
        drive.listeners.append(self._look)

    # ---- what it does ----

    @property
    def is_streaming(self) -> bool:
        return self._path is not None

    @property
    def stream_end_ns(self) -> int | None:
        """End of the path that is streamed."""
        return self._path[1] + length_ns(self._path[0]) if self._path else None

    @property
    def is_under_way(self) -> bool:
        """True until the motion has ended, also before it begins."""
        return self._path is not None or self._begins_ns is not None or self._arrival is not None

    @property
    def is_waiting(self) -> bool:
        """True until a move by the drive's own ramps was given to it."""
        return self._begins_ns is not None

    @property
    def target_deg(self) -> float | None:
        """Angle that a motion under way leads to."""
        if self._path:
            return self._path[0][-1].r
        return self._arrival.target_deg if self._arrival else None

    def _look(self, reading: Reading) -> None:
        if self._arrival is None:
            return
        verdict = self._arrival.look(reading)
        if verdict == "under_way":
            return
        if verdict == "short":
            here_deg, wanted_deg = reading.values["position_deg"], self._arrival.target_deg
            said = f"the drive does not follow: it stands at {here_deg:.2f} deg, and was sent to"
            self.failure = self.failure or f"{said} {wanted_deg:.2f}"
        self._arrival = None

    # ---- what it is given ----

    def check(self, *angles_deg: float) -> None:
        """Check that its registers can hold set-points. Raises VerbRefused."""
        place = self._drive.map.values["set_point_deg"]
        for angle_deg in angles_deg:
            try:
                value_write(self._drive.map, place, angle_deg)
            except ValueError as error:
                raise VerbRefused("bad_parameter", f"set_point_deg: {error}") from None

    def follow(self, path: Path, start_ns: int) -> None:
        """Stream a path's set-points from a time on; they are in effect at once. Raises VerbRefused."""
        self.check(*(piece.r for piece in path))
        self._begin(self._stream(path, start_ns, self._drive.link.session))
        self._path = path, start_ns

    def move(
        self,
        position_deg: float,
        velocity_rpm: float | None,
        acceleration_rpm_per_s: float | None,
        start_ns: int,
    ) -> None:
        """Send the drive to an angle by its own ramps from a time on. Raises VerbRefused."""
        self.check(position_deg)
        ramps = {"set_velocity_rpm": velocity_rpm, "acceleration_rpm_per_s": acceleration_rpm_per_s}
        given = {name: value for name, value in ramps.items() if value and name in self._drive.map.values}
        self._begin(self._send(position_deg, given, start_ns, self._drive.link.session))
        self._begins_ns = start_ns

    async def stop(self, how: How = "grace", acceleration_rpm_per_s: float | None = None) -> None:
        """Stop the drive: by its own bit, or with a stream's last set-points, or where it is.

        Raises:
            ASKING: that was not confirmed.
        """
        streamed = self._path
        self.abandon()
        drive = self._drive
        session = drive.link.session
        if "stop" in drive.map.control:
            await self._pulse("stop", session, URGENT, start=False, follow=False)
            return
        if streamed and how == "grace" and acceleration_rpm_per_s:
            set_deg, rate = at(streamed[0], drive.now_ns() - streamed[1])
            path = to_rest(set_deg, rate, acceleration_rpm_per_s * DEG_PER_S)
            self._begin(self._stream(path, drive.now_ns(), session))
            self._path = path, drive.now_ns()
            return
        here_deg = drive.position_deg
        if not streamed and here_deg is not None:
            await drive.write_value("set_point_deg", here_deg, session, URGENT)
            if "start" in drive.map.control:
                await self._pulse("start", session, URGENT)

    def abandon(self) -> None:
        """Give the drive nothing more of this motion."""
        if self._task:
            self._task.cancel()
        self._task = self._path = self._arrival = self._begins_ns = None

    def forget(self) -> None:
        """Forget the failure of the motion before."""
        self.failure = None

    async def end(self) -> None:
        """Let a drive that stands follow no set-points any more."""
        drive = self._drive
        if not self.is_under_way and drive.link.is_there and "follow" in drive.map.control:
            with suppress(*ASKING):
                await drive.write_bits(drive.link.session, follow=False)

    def close(self) -> None:
        """Give it nothing more, and look no more at it."""
        self.abandon()
        self._drive.listeners.remove(self._look)

    # ---- how ----

    def _begin(self, doing: Coroutine[Any, Any, None]) -> None:
        self.abandon()
        self.failure = None
        self._task = asyncio.get_running_loop().create_task(self._guarded(doing))

    async def _guarded(self, doing: Coroutine[Any, Any, None]) -> None:
        try:
            await doing
        except (PlaceLost, Stale) as error:
            self._failed(f"the drive at {self._drive.spec.address} is lost: {self._drive.link.why or error}")
        except ASKING as error:
            self._failed(str(error))
        except ValueError as error:
            self._failed(f"set_point_deg: {error}")
        except asyncio.CancelledError:
            raise
        except Exception as error:  # hil's own error: that axis stops its run, the others go on
            self._failed(f"an error of hil, see its log: {error!r}")
            raise

    def _failed(self, why: str) -> None:
        self.failure = self.failure or why
        self._path = self._arrival = self._begins_ns = None

    def _await_end(self, target_deg: float) -> None:
        within_deg = ARRIVED_DEG + 2 * abs(self._drive.map.values["position_deg"].scale)
        self._arrival = Arrival(target_deg, self._drive.now_ns(), within_deg)

    async def _send(self, position_deg: float, ramps: dict[str, float], start_ns: int, session: int) -> None:
        drive = self._drive
        for name, value in ramps.items():
            await drive.write_value(name, value, session)
        await drive.write_bits(session, follow=False, start=False)
        await drive.write_value("set_point_deg", position_deg, session)
        await asyncio.sleep(max(start_ns - drive.now_ns(), 0) / 1e9)
        await drive.write_bits(session, URGENT, start=True)
        self._await_end(position_deg)
        self._begins_ns = None
        await asyncio.sleep(PULSE_S)
        await drive.write_bits(session, start=False)

    async def _pulse(self, bit: str, session: int, order: int, **others: bool) -> None:
        """Let a bit become 1, and 0 again."""
        await self._drive.write_bits(session, order, **{bit: True}, **others)
        await asyncio.sleep(PULSE_S)
        await self._drive.write_bits(session, order, **{bit: False})

    async def reset(self) -> None:
        """Clear the drive's fault. Raises ``ASKING``."""
        self.abandon()
        await self._pulse("reset", self._drive.link.session, URGENT)

    async def _stream(self, path: Path, start_ns: int, session: int) -> None:
        drive, now_ns = self._drive, self._drive.now_ns
        end_ns, period_ns = start_ns + length_ns(path), round(drive.spec.setpoint_s * 1e9)
        await drive.write_value("set_point_deg", at(path, now_ns() - start_ns)[0], session)
        await drive.write_bits(session, follow=True, start=False, stop=False)
        await asyncio.sleep(max(start_ns - now_ns(), 0) / 1e9)
        confirmed_ns = due_ns = now_ns()
        while True:
            # One that comes late is that of its own time, and none is sent twice to catch up.
            at_ns = min(now_ns(), end_ns)
            try:
                await drive.write_value("set_point_deg", at(path, at_ns - start_ns)[0], session, tries=1)
                confirmed_ns = now_ns()
                if at_ns >= end_ns:
                    break
            except NoAnswer:
                if now_ns() - confirmed_ns > LATE_NS:
                    raise
            due_ns = max(due_ns + period_ns, now_ns())
            await asyncio.sleep((min(due_ns, max(end_ns, now_ns())) - now_ns()) / 1e9)
        self._await_end(path[-1].r)
        self._path = None
