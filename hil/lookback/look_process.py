"""Process that answers about any time of a recording: ``python -m hil.lookback.look_process FILE``.

It reads requests, a line of JSON each, and answers with ``HEAD`` and a text: JSON, or why there is no answer.
A request has ``id``, ``what``, ``lane`` (a newer one takes the place of another that waits, or is worked at),
``known_ns`` (time up to which the recording is there: the daemon knows) and what it is about. ``overview`` is
answered at once; the others by copies of the nearest check point before their time. It ends with its asker.
"""

import json
import os
import resource
import selectors
import signal
import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hil.lookback.check_points import CheckPoint, CheckPoints
from hil.lookback.growing_log import GrowingLog
from hil.lookback.look_answers import FOUND_NS, WHATS
from hil.lookback.look_head import DROPPED, GIVEN, HEAD, REFUSED
from hil.lookback.run_marks import RunMarks
from hil.lookback.standing import DONE
from hil.sim.inputs import InputLogError

AT_ONCE = 2
"""Number of requests that are worked at, at a time."""
_LOOK_S = 0.5
"""Interval at which a recording that grows is looked at."""
_READ_BYTES = 1 << 16
NICE = 10
"""A tenth of a processor beside others that want all of it; at 19 the first look took half a minute there."""
MOST_TRIES = 5
ENDED = b"the process that worked at it was ended, perhaps for lack of memory; ask again"


@dataclass
class LookWork:
    """Request that a copy works at, and what it has answered so far."""

    asked: Mapping[str, Any]
    point: CheckPoint
    parts: list[bytes] = field(default_factory=list)


class LookProcess:
    """Process of one recording. ``requests``, ``answers``: its files."""

    def __init__(self, growing: GrowingLog, requests: int, answers: int) -> None:
        self._growing = growing
        self._requests, self._answers = requests, answers
        self._rest = b""
        self._marks = RunMarks()
        self._marked = self._noted = self._happened = 0
        self._points = CheckPoints(growing)
        self._known_ns = 0
        self._waiting: dict[str, Mapping[str, Any]] = {}
        """Requests by lane."""
        self._work: dict[int, LookWork] = {}
        self._selector = selectors.DefaultSelector()
        self._selector.register(requests, selectors.EVENT_READ)

    def run(self) -> None:
        """Answer until the asker has gone."""
        while True:
            self._read_on()
            self._points.go_on(self._known_ns)
            self._begin_waiting()
            self._points.go_on(self._known_ns)  # where one was found to have been ended
            coming = self._points.coming
            if coming:
                self._selector.register(coming, selectors.EVENT_READ)
            found = self._selector.select(_LOOK_S if self._growing.is_growing else None)
            if coming:
                self._selector.unregister(coming)
            for key, _ in found:
                if key.fileobj == self._requests:
                    if not self._take_requests():
                        return
                elif key.fileobj is coming:
                    self._points.arrive()
                else:
                    self._take_answer(key.fd)

    def _read_on(self) -> None:
        growing = self._growing
        first = growing.read_on()
        inputs = growing.log.inputs
        if first < len(inputs):
            self._points.take_back(min(logged.at_ns for logged in inputs[first:]))
        if not growing.is_growing and self._known_ns > growing.last_ns:  # what is damaged was left out
            self._known_ns = growing.last_ns
            self._points.take_back(self._known_ns + 1)
        if len(inputs) < self._marked:
            self._marks, self._marked, self._noted, self._happened = RunMarks(), 0, 0, 0
        for logged in inputs[self._marked :]:
            self._marks.add(logged)
        self._marked = len(inputs)
        for event in growing.log.events[self._happened :]:
            self._marks.happen(event)
        self._happened = len(growing.log.events)
        self._marks.note(self._points.notes[self._noted :])
        self._noted = len(self._points.notes)
        self._known_ns = max(self._known_ns, growing.last_ns)

    def _take_requests(self) -> bool:
        data = os.read(self._requests, _READ_BYTES)
        *lines, self._rest = (self._rest + data).split(b"\n")
        for line in lines:
            self._take(json.loads(line))
        return bool(data)

    def _take(self, asked: Mapping[str, Any]) -> None:
        if self._growing.is_growing:
            self._known_ns = max(self._known_ns, asked["known_ns"])
        if asked["what"] == "overview":
            self._read_on()
            self._tell(asked["id"], GIVEN, json.dumps(self._overview(asked)).encode())
        elif asked["what"] not in WHATS:
            self._tell(asked["id"], REFUSED, f"there is no {asked['what']}".encode())
        else:
            self._drop(asked["lane"])
            self._waiting[asked["lane"]] = asked

    def _drop(self, lane: str) -> None:
        """Drop what was asked before in a lane."""
        if before := self._waiting.pop(lane, None):
            self._tell(before["id"], DROPPED, b"a newer request took its place")
        for file, work in list(self._work.items()):
            if work.asked["lane"] == lane:
                self._end(file)
                self._tell(work.asked["id"], DROPPED, b"a newer request took its place")

    def _overview(self, asked: Mapping[str, Any]) -> dict[str, Any]:
        log, growing, points = self._growing.log, self._growing, self._points
        told: dict[str, Any] = {
            "end_ns": self._known_ns,
            "ready_ns": max(points.last_ns, 0),
            "is_growing": growing.is_growing,
            "problem": growing.problem or points.problem,
            "begun": log.begun,
            "speed": log.speed,
            "program": log.program,
            "check_points": len(points),
            "kB": points.kB,
            "revision": self._marks.count,
        }
        if asked.get("revision") != self._marks.count:
            told["marks"] = self._marks.told(self._known_ns, asked["most"])
        return told

    def _begin_waiting(self) -> None:
        """Hand out what waits, as far as it can be worked at."""
        for lane, asked in list(self._waiting.items()):
            if len(self._work) >= AT_ONCE:
                return
            points = self._points
            to_ns = min(asked["to_ns"], self._known_ns)
            asked = {
                **asked,
                "to_ns": to_ns,
                "from_ns": min(asked["from_ns"], to_ns),
                "known_ns": self._known_ns,
            }
            if asked.get("back"):
                asked["from_ns"] = max(to_ns - FOUND_NS, 0)
            next_ns = points.last_ns + points.spacing_ns
            if asked["from_ns"] >= next_ns and points.coming:
                continue  # it will be nearer
            while (point := points.before(asked["from_ns"])) and not self._hand_out(lane, asked, point):
                pass
            if point is None and points.problem:
                del self._waiting[lane]
                self._tell(asked["id"], REFUSED, points.problem.encode())

    def _hand_out(self, lane: str, asked: Mapping[str, Any], point: CheckPoint) -> bool:
        """Let a copy of a check point work at a request; answers whether the check point was still there."""
        ours, theirs = os.pipe()
        try:
            point.order(dict(asked), theirs)
        except OSError:  # it was ended by somebody; the next one before it will do
            os.close(ours)
            self._points.forget(point)
            return False
        finally:
            os.close(theirs)
        del self._waiting[lane]
        self._work[ours] = LookWork(asked, point)
        self._selector.register(ours, selectors.EVENT_READ)
        return True

    def _take_answer(self, file: int) -> None:
        if file not in self._work:
            return  # it was dropped in this turn
        work = self._work[file]
        if data := os.read(file, _READ_BYTES):
            work.parts.append(data)
            return
        self._end(file)
        answered = b"".join(work.parts)
        tries = work.asked.get("tries", 0)
        if answered[:1] == DONE:
            self._tell(work.asked["id"], GIVEN, answered[1:])
        elif not answered and tries < MOST_TRIES:
            self._points.forget(work.point)  # perhaps it was ended, too
            self._waiting.setdefault(work.asked["lane"], {**work.asked, "tries": tries + 1})
        else:
            why = answered[1:] or ENDED
            self._tell(work.asked["id"], REFUSED, why)

    def _end(self, file: int) -> None:
        self._selector.unregister(file)
        os.close(file)
        del self._work[file]

    def _tell(self, number: int, status: int, text: bytes) -> None:
        data = memoryview(HEAD.pack(number, status, len(text)) + text)
        while data:
            data = data[os.write(self._answers, data) :]


def be_last() -> None:
    """Let others have the processors first, and be the first that memory is taken from."""
    os.setpriority(os.PRIO_PROCESS, 0, max(NICE, os.getpriority(os.PRIO_PROCESS, 0)))
    with suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
    with suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("1000")
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def main() -> None:
    be_last()
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # copies are waited for by nobody
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # of the terminal: the asker decides
    try:
        growing = GrowingLog(Path(sys.argv[1]))
    except (InputLogError, OSError) as error:
        sys.exit(str(error))
    with suppress(BrokenPipeError):
        LookProcess(growing, 0, 1).run()


if __name__ == "__main__":
    main()
