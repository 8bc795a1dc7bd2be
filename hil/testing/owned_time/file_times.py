"""Times of files as a program on simulated time sees them: ``os.stat`` and ``os.utime`` on its clock.

Files have the wall's times, in ticks of Linux. What was there before the program keeps its age at the
program's start; what is written while it runs has about the time at which it was, always the same one.
"""

import os
import time
from collections.abc import Callable
from typing import Any

from hil.vocab.time import NS_PER_MS

_wall_ns, _utime, _stat = time.time_ns, os.utime, os.stat
_JUST_NOW_NS = 10 * NS_PER_MS
"""Maximum age of a file that is written now: Linux stamps it with the time of its last tick (CONFIG_HZ)."""
_KINDS = ("atime", "mtime", "ctime")
_FIRST_TIME = 7
"""Place of the first time, in seconds, in a ``stat_result``."""


class FileTimes:
    """Times of files. ``date_ns``: answers the simulated date, which takes no time."""

    def __init__(self, date_ns: Callable[[], int]) -> None:
        self._date_ns = date_ns
        self._start_wall_ns, self._start_ns = _wall_ns(), date_ns()
        self._known = dict[int, int]()
        """Simulated dates by the wall's, of those that were asked for."""

    def of_os(self) -> dict[str, Any]:
        """Functions of ``os`` by name."""
        calls = {name: self._asking(getattr(os, name)) for name in ("stat", "lstat", "fstat")}
        return {**calls, "utime": self.utime}

    def _asking(self, ask: Callable[..., os.stat_result]) -> Callable[..., os.stat_result]:
        def stat(*place: Any, **options: Any) -> os.stat_result:
            """Status of a file, with times of the program's clock."""
            parts: Any = ask(*place, **options).__reduce__()[1]
            plain, named = [*parts[0]], parts[1]
            for number, kind in enumerate(_KINDS):
                at_ns = self._simulated_ns(named[f"st_{kind}_ns"])
                named[f"st_{kind}_ns"], named[f"st_{kind}"] = at_ns, at_ns / 1e9
                plain[_FIRST_TIME + number] = at_ns // 10**9
            return os.stat_result(plain, named)

        return stat

    def _simulated_ns(self, wall_ns: int) -> int:
        if wall_ns in self._known:
            return self._known[wall_ns]
        if wall_ns <= self._start_wall_ns - _JUST_NOW_NS:
            return self._start_ns + wall_ns - self._start_wall_ns
        now_wall_ns, now_ns = _wall_ns(), self._date_ns()
        if now_wall_ns - wall_ns > _JUST_NOW_NS:
            share = max(wall_ns - self._start_wall_ns, 0) / (now_wall_ns - self._start_wall_ns)
            now_ns = self._start_ns + round(share * (now_ns - self._start_ns))
        self._known[wall_ns] = now_ns
        return now_ns

    def utime(
        self,
        path: Any,
        times: tuple[float, float] | None = None,
        *,
        ns: tuple[int, int] | None = None,
        **options: Any,
    ) -> None:
        """Set the times of a file, as ``os.utime``."""
        if times is not None and ns is None:
            ns = round(times[0] * 1e9), round(times[1] * 1e9)
        if ns is None:
            _utime(path, **options)
            self._known[_stat(path, **options).st_mtime_ns] = self._date_ns()
            return
        walls = [each - self._start_ns + self._start_wall_ns for each in ns]
        self._known |= dict(zip(walls, ns, strict=True))
        _utime(path, ns=(walls[0], walls[1]), **options)
