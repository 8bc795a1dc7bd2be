"""A copy of the process that stands still at a time of the run, and copies itself for each that asks."""

import gc
import json
import os
import select
import socket
import traceback
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hil.config import ConfigError
from hil.lookback.growing_log import GrowingLog
from hil.lookback.look_answers import Unanswerable, answer
from hil.lookback.seen_run import NotWanted, SeenRun
from hil.sim.inputs import InputLogError
from hil.vocab.time import SimTimeNs

ORDER_BYTES = 128 * 1024
DONE, REFUSED = b"+", b"-"
"""First byte of an answer."""


def stand_first(growing: GrowingLog, place: socket.socket) -> None:
    """Build the run and stand at its beginning, until ``place`` is closed. Never returns."""
    try:
        seen = SeenRun(growing)
    except (InputLogError, ConfigError) as error:
        place.send(json.dumps({"problem": str(error)[:4000]}).encode())
        os._exit(1)
    stand(seen, place)


def stand(seen: SeenRun, place: socket.socket) -> None:
    """Stand at the time to which a run has gone, until ``place`` is closed. Never returns."""
    place.send(_report(seen))
    while True:
        gc.freeze()  # collections of the copies leave shared pages alone
        data, files, _, _ = socket.recv_fds(place, ORDER_BYTES, 1)
        if not data:
            os._exit(0)
        order = json.loads(data)
        if os.fork() == 0:
            place.close()
            if order["what"] != "go_on":
                _work(seen, order, files[0])
            place = socket.socket(fileno=files[0])
            _go_on(seen, SimTimeNs(order["to_ns"]), place)
        else:
            os.close(files[0])


def _go_on(seen: SeenRun, to_ns: SimTimeNs, place: socket.socket) -> None:
    """Go on to a time, and report that the new place is there."""
    problem = ""
    try:
        seen.run_until(to_ns, lambda: not _is_left(place.fileno()))
    except NotWanted:
        os._exit(0)
    except InputLogError as error:
        problem = str(error)[:4000]
    place.send(_report(seen, problem))


def _report(seen: SeenRun, problem: str = "") -> bytes:
    told: dict[str, Any] = {"at_ns": seen.run.now_ns, "kB": own_kB(), "notes": seen.take_notes()}
    return json.dumps(told | ({"problem": problem} if problem else {})).encode()


def _work(seen: SeenRun, asked: Mapping[str, Any], to: int) -> None:
    """Answer a request and end."""
    try:
        answered = DONE + answer(seen, asked, lambda: not _is_left(to))
    except NotWanted:
        os._exit(0)
    except (Unanswerable, InputLogError) as error:
        answered = REFUSED + str(error).encode()
    except Exception as error:  # ours: this look fails, and the check point goes on
        traceback.print_exc()
        answered = REFUSED + f"it failed: {type(error).__name__}: {error}"[:1000].encode()
    try:
        with open(to, "wb") as file:
            file.write(answered)
    except BrokenPipeError:
        pass
    os._exit(0)


def _is_left(file: int) -> bool:
    """True if the other end is closed."""
    poll = select.poll()
    poll.register(file, 0)
    return bool(poll.poll(0))


def own_kB() -> int:
    """Memory of this process that it shares with none, in kB."""
    text = Path("/proc/self/smaps_rollup").read_text()
    rows = dict(line.split(":", 1) for line in text.splitlines()[1:])
    return sum(int(rows[name].split()[0]) for name in ("Private_Dirty", "Private_Clean"))
