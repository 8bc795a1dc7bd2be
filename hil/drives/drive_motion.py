"""Motion of a real drive, and whether it has come to its end.

A motion is of one session of the drive's link: when the drive is lost, the motion has failed, and nothing of
it is sent when the drive is back.
"""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Coroutine
from dataclasses import dataclass
from typing import Any, Literal

from hil.drives.drive_link import ASKING, PlaceLost, Reading, Stale
from hil.drives.real_drive import RealDrive
from hil.firmware.set_point_paths import at, length_ns, to_rest
from hil.vocab.axis import How
from hil.vocab.path import DEG_PER_S, Path

ARRIVED_DEG = 0.5
"""Maximum distance from the target at which a motion has come to it."""
SHOWS_NS = 200_000_000
"""Time from the command until a drive says that it moves."""
SETTLES_NS = 1_000_000_000
"""Time for the shaft to come to the target when nothing moves any more, or does not come nearer."""
STUCK_NS = 3_000_000_000
"""Time for a drive that says that it moves to come nearer by a tenth of the distance at which it is there."""

Verdict = Literal["under_way", "arrived", "short"]


@dataclass
class Arrival:
    """Watch over one motion to ``target_deg``, from the time on at which its end was commanded
    (``since_ns``). ``within_deg``: maximum distance, a step of the drive's registers included."""

    target_deg: float
    since_ns: int
    within_deg: float = ARRIVED_DEG

    def __post_init__(self) -> None:
        self._progress_ns = self.since_ns
        self._nearest_deg = float("inf")
        self._has_moved = False

    def look(self, reading: Reading) -> Verdict:
        """Say how the motion does, by a reading."""
        if reading.at_ns <= self.since_ns:
            return "under_way"
        off_deg = abs(reading.values["position_deg"] - self.target_deg)
        moves = reading.bits.get("status.moving")  # None: the map has no such bit
        self._has_moved = self._has_moved or bool(moves)
        has_begun = self._has_moved or reading.at_ns > self.since_ns + SHOWS_NS
        if off_deg <= self.within_deg and (moves is None or (not moves and has_begun)):
            return "arrived"
        if off_deg < self._nearest_deg - self.within_deg / 10:
            self._progress_ns = reading.at_ns
            self._nearest_deg = off_deg
        patience_ns = STUCK_NS if moves else SHOWS_NS + SETTLES_NS
        return "short" if reading.at_ns > self._progress_ns + patience_ns else "under_way"


class DriveMotion(ABC):
    """Motion of one drive, the last that it was given."""

    def __init__(self, of: RealDrive) -> None:
        self._of = of
        self.failure: str | None = None
        """Reason why the motion does not do what it was given."""
        self._arrival: Arrival | None = None
        self._task: asyncio.Task[None] | None = None
        self._path: tuple[Path, int] | None = None
        """Path that is streamed, and its beginning."""
        self._begins_ns: int | None = None
        """Beginning of a move that is not given yet."""
        of.listeners.append(self._look)

    # ---- what it does ----

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

    @abstractmethod
    def check(self, *angles_deg: float) -> None:
        """Check that the drive can hold set-points. Raises VerbRefused."""

    def follow(self, path: Path, start_ns: int) -> None:
        """Stream a path's set-points from a time on; they are in effect at once. Raises VerbRefused."""
        self.check(*(piece.r for piece in path))
        self._follow(path, start_ns)

    def move(
        self,
        position_deg: float,
        velocity_rpm: float | None,
        acceleration_rpm_per_s: float | None,
        start_ns: int,
    ) -> None:
        """Send the drive to an angle by its own ramps from a time on. Raises VerbRefused."""
        self.check(position_deg)
        session = self._of.link.session
        self._begin(self._send(position_deg, velocity_rpm, acceleration_rpm_per_s, start_ns, session))
        self._begins_ns = start_ns

    @abstractmethod
    async def stop(self, how: How = "grace", acceleration_rpm_per_s: float | None = None) -> None:
        """Stop the drive. Raises ``ASKING``: that was not confirmed."""

    @abstractmethod
    async def end(self) -> None:
        """Let a drive that stands follow no set-points any more."""

    def abandon(self) -> None:
        """Give the drive nothing more of this motion."""
        if self._task:
            self._task.cancel()
        self._task = self._path = self._arrival = self._begins_ns = None

    def forget(self) -> None:
        """Forget the failure of the motion before."""
        self.failure = None

    def close(self) -> None:
        """Give it nothing more, and look no more at it."""
        self.abandon()
        self._of.listeners.remove(self._look)

    # ---- how ----

    @abstractmethod
    async def _send(
        self,
        position_deg: float,
        velocity_rpm: float | None,
        acceleration_rpm_per_s: float | None,
        start_ns: int,
        session: int,
    ) -> None:
        """Give the drive a move at its time."""

    async def _stream(self, path: Path, start_ns: int, session: int) -> None:
        """Give the drive the set-points of a path; needed of one that follows paths."""
        raise NotImplementedError

    def _follow(self, path: Path, start_ns: int) -> None:
        self._begin(self._stream(path, start_ns, self._of.link.session))
        self._path = path, start_ns

    def _run_down(self, streamed: tuple[Path, int], acceleration_rpm_per_s: float) -> None:
        """Stream the set-points of a ramp to a stand behind those of a path."""
        now_ns = self._of.now_ns()
        set_deg, rate = at(streamed[0], now_ns - streamed[1])
        self._follow(to_rest(set_deg, rate, acceleration_rpm_per_s * DEG_PER_S), now_ns)

    def _begin(self, doing: Coroutine[Any, Any, None]) -> None:
        self.abandon()
        self.failure = None
        self._task = asyncio.get_running_loop().create_task(self._guarded(doing))
        self._task.add_done_callback(lambda _: doing.close())  # if it was abandoned before it began

    async def _guarded(self, doing: Coroutine[Any, Any, None]) -> None:
        try:
            await doing
        except (PlaceLost, Stale) as error:
            self._failed(f"the drive at {self._of.address} is lost: {self._of.link.why or error}")
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
        within_deg = ARRIVED_DEG + 2 * self._of.step_deg
        self._arrival = Arrival(target_deg, self._of.now_ns(), within_deg)
