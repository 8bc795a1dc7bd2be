"""Check points of a run: copies of the process that stand at times of it, from which others go on."""

import json
import os
import socket
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from hil.lookback.growing_log import GrowingLog
from hil.lookback.standing import stand_first
from hil.vocab.time import NS_PER_S, SimTimeNs

MOST, MOST_KB = 64, 200_000
"""Maximum number of check points, and of the memory that they do not share, in kB."""
FIRST_SPACING_NS = 5 * NS_PER_S
TRIES = 3
ENDED = "the process that follows the recording was ended again and again, perhaps for lack of memory"
_REPORT_BYTES = 256 * 1024


@dataclass
class CheckPoint:
    """Copy that stands at a time. ``kB``: memory that it did not share when it came there."""

    at_ns: SimTimeNs
    place: socket.socket
    kB: int

    def order(self, order: dict[str, Any], file: int) -> None:
        """Have a copy made, which gets a file. Raises OSError: it is no more."""
        socket.send_fds(self.place, [json.dumps(order).encode()], [file])


class CheckPoints:
    """Check points of a log, in the order of their times, and the one that is on its way to its place."""

    def __init__(self, growing: GrowingLog) -> None:
        self._growing = growing
        self._standing: list[CheckPoint] = []
        self.coming: socket.socket | None = None
        """Place of the next one, which is readable when it has come there."""
        self._coming_ns = SimTimeNs(0)
        self.spacing_ns = FIRST_SPACING_NS
        self.problem = ""
        """Reason why the run cannot be followed further, for people."""
        self.notes: list[dict[str, Any]] = []
        """Notes of all of them, in their order."""
        self._noted_ns = SimTimeNs(-1)
        self._ended = 0
        """Number of those on their way that were ended by somebody, one after the other."""

    def __len__(self) -> int:
        return len(self._standing)

    @property
    def kB(self) -> int:
        """Memory of all of them that they did not share when they came to their places."""
        return sum(each.kB for each in self._standing)

    @property
    def last_ns(self) -> SimTimeNs:
        """Time of the last one; -1: there is none."""
        return self._standing[-1].at_ns if self._standing else SimTimeNs(-1)

    def before(self, at_ns: int) -> CheckPoint | None:
        """Last check point at or before a time, or None."""
        return next((each for each in reversed(self._standing) if each.at_ns <= at_ns), None)

    def go_on(self, known_ns: int) -> None:
        """Let the next one go to its place, if the run is known so far."""
        if self.coming or self.problem:
            return
        if not self._standing or self._standing[0].at_ns > 0:  # the first was ended by somebody: begin again
            self.close()
            self.spacing_ns = max(FIRST_SPACING_NS, known_ns // (MOST * 3 // 4))
            self._begin()
            return
        last = self._standing[-1]
        to_ns = SimTimeNs(last.at_ns + self.spacing_ns)
        if to_ns > known_ns:
            return
        ours, theirs = _pair()
        with theirs:
            try:
                last.order({"what": "go_on", "to_ns": to_ns}, theirs.fileno())
            except OSError:
                ours.close()
                self.forget(last)
                return
        self.coming, self._coming_ns = ours, to_ns

    def arrive(self) -> None:
        """Take the report of the one that was on its way."""
        place, self.coming = self.coming, None
        assert place
        try:
            data = place.recv(_REPORT_BYTES)
        except ConnectionResetError:
            data = b""
        told = json.loads(data or "{}")  # nothing: it was ended by somebody
        self._ended = 0 if data else self._ended + 1
        self.problem = told.get("problem", "") or (ENDED if self._ended >= TRIES else "")
        if not data or self.problem:
            place.close()
            return
        at_ns = SimTimeNs(told["at_ns"])
        if at_ns > self._noted_ns:
            self.notes += told["notes"]
            self._noted_ns = at_ns
        self._standing.append(CheckPoint(at_ns, place, told["kB"]))
        if len(self) > MOST or self.kB > MOST_KB:
            self._thin_out()

    def forget(self, gone: CheckPoint) -> None:
        """Take away a check point, which may have been ended by somebody."""
        gone.place.close()
        if gone in self._standing:
            self._standing.remove(gone)

    def take_back(self, at_ns: int) -> None:
        """End those that went to a time or past it, for something that is of this time came to the log
        later."""
        self.problem = ""
        if self.coming and self._coming_ns >= at_ns:
            self.coming.close()
            self.coming = None
        for each in [each for each in self._standing if each.at_ns >= at_ns]:
            self.forget(each)

    def close(self) -> None:
        """End all of them."""
        self.take_back(-1)

    def _thin_out(self) -> None:
        """End each second one; the first and the last stay."""
        self.spacing_ns *= 2
        for each in self._standing[1:-1:2]:
            self.forget(each)

    def _begin(self) -> None:
        """Make the first one, at the beginning of the run: a copy of this process."""
        ours, theirs = _pair()
        if os.fork() == 0:
            try:
                _leave_files({self._growing.fileno(), theirs.fileno()})
                stand_first(self._growing, theirs)
            finally:
                os._exit(1)
        theirs.close()
        self.coming, self._coming_ns = ours, SimTimeNs(0)


def _leave_files(kept: set[int]) -> None:
    """Close the files of this process except some: others wait for their ends."""
    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 0)
    os.dup2(nothing, 1)
    for file in map(int, os.listdir("/proc/self/fd")):
        if file > 2 and file not in kept:
            with suppress(OSError):  # the list's own
                os.close(file)


def _pair() -> tuple[socket.socket, socket.socket]:
    return socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
