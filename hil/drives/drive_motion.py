"""Motion of a real drive, and whether it has come to its end.

A motion is of one session of the drive's link: when the drive is lost, the motion has failed, and nothing of
it is sent when the drive is back.
"""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Coroutine
from typing import Any

from hil.drives.arrival import ARRIVED_DEG, Arrival
from hil.drives.drive_errors import ASKING, PlaceLost, Stale
from hil.drives.reading import Reading
from hil.drives.real_drive import RealDrive
from hil.firmware.set_point_paths import length_ns
from hil.vocab.axis import How
from hil.vocab.path import Path


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

    @abstractmethod
    def follow(self, path: Path, start_ns: int) -> None:
        """Stream a path's set-points from a time on. Raises VerbRefused."""

    @abstractmethod
    def move(
        self,
        position_deg: float,
        velocity_rpm: float | None,
        acceleration_rpm_per_s: float | None,
        start_ns: int,
    ) -> None:
        """Send the drive to an angle by its own ramps from a time on. Raises VerbRefused."""

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
