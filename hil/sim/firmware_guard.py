"""Guards over a firmware's own code: in a daemon a clock, in a replay its log; and the place of its error.

The guard stops a firmware at a point that has no simulated time. So the turn in which it happens counts as if
the firmware had not run in it. The log has what the firmware had already sent.
"""

import json
from collections.abc import Mapping
from contextlib import AbstractContextManager
from typing import Protocol

from hil.sim._each_packet import Nothing
from hil.sim.inputs import Stopped
from hil.vocab.time import SimTimeNs

_ROOT = __file__.removesuffix("hil/sim/firmware_guard.py")
_OURS = f"{_ROOT}hil/", f"{_ROOT}bridges/"
"""Folders of the code that carries a board's out: the bench, and buses."""
_PYTHON = f"{json.__file__.rpartition('/json/')[0]}/"
"""Folder of Python's own library; packages that were installed may be below it."""
_INSTALLED = f"{_PYTHON}site-packages/"


def _is_boards(file: str) -> bool:
    """True if a file is none of ours, and none of Python's."""
    is_pythons = file.startswith(("<", _PYTHON)) and not file.startswith(_INSTALLED)
    return not is_pythons and not file.startswith(_OURS)


def place_of(error: BaseException) -> str:
    """Answer file and line as " (firmware.py:31)": those that the error itself knows, or of the innermost
    call in a board's code, if there is one; "" without a traceback."""
    if place := getattr(error, "place", ""):
        return f" ({place})"
    places: list[tuple[str, int]] = []
    call = error.__traceback__
    while call:
        places.insert(0, (call.tb_frame.f_code.co_filename, call.tb_lineno))
        call = call.tb_next
    if not places:
        return ""
    file, line = next((each for each in places if _is_boards(each[0])), places[0])
    return f" ({file.rpartition('/')[2]}:{line})"


NOTHING = Nothing()


class FirmwareHung(BaseException):
    """Stop of a firmware that used more time than it may. No ``Exception``: a firmware that catches every
    exception must not go on after this one."""


class StopLogged(FirmwareHung):
    """Stop of a firmware in this turn, as the log says."""

    def __init__(self, stopped: Stopped) -> None:
        super().__init__(stopped.reason)
        self.stopped = stopped


class Guarded(Protocol):
    """Device as its guard sees it."""

    name: str
    turns: int
    """Number of turns that its firmware has had, the present one included."""

    @property
    def now_ns(self) -> SimTimeNs:
        """Simulated time that it has reached."""


class Guard(Protocol):
    """Guard of firmware: ``with guard(device):`` around each turn of its own code."""

    def __call__(self, device: Guarded, /) -> AbstractContextManager[object]:
        return NOTHING

    def aside(self) -> AbstractContextManager[object]:
        """Exclude work that is not the firmware's, in the middle of a turn or after it."""
        return NOTHING


class Unguarded(Guard):
    """Guard that watches nothing."""


UNGUARDED = Unguarded()


class LoggedStops(Unguarded):
    """Guard that stops devices in the turns in which a log says so, before their firmwares run in them."""

    def __init__(self, stops: Mapping[tuple[str, int], Stopped]) -> None:
        self.left = dict(stops)
        """Stops that have not come yet, by the devices' names and the turns."""

    def __call__(self, device: Guarded, /) -> AbstractContextManager[object]:
        if stopped := self.left.pop((device.name, device.turns), None):
            raise StopLogged(stopped)
        return NOTHING
