"""Replay on the virtual clock of a run in real time, on a machine that is busy."""

import os
import subprocess
import sys
import time

from e2e_support import PATIENCE_S, Place, config

SOAK_S = float(os.environ.get("HIL_SOAK_S", "20"))
"""Length of the run; `make soak` asks for 60."""

RUN = """
import asyncio, sys, time
from pathlib import Path
from hil.config import parse
from hil.compose import find_catalogue
from hil.cli.bench.started import started as say_started
from hil.host.log_writer import LogWriter
from hil.daemon import Daemon

def started(serving):
    loop = asyncio.get_running_loop()
    for k in range(10):  # the event loop does not run for 200 ms
        loop.call_later(seconds * (k + 0.5) / 10, time.sleep, 0.2)
    say_started(serving, LogWriter(2))

path, runtime, state, log = map(Path, sys.argv[1:5])
seconds = float(sys.argv[5])
bench = parse(path.read_text(), str(path), find_catalogue())
daemon = Daemon(bench, config_folder=path.parent, runtime_base=runtime, state_base=state, input_log=log)
asyncio.run(daemon.run(started))
"""
BUSY = "import time\nend = time.monotonic() + {}\nwhile time.monotonic() < end: sum(range(10_000))"
SCRIPT = (
    (b"kpp14.5\nq", b"done...\r\n"),
    (b"kvi0.002\nq", b"done...\r\n"),
    (b"kop1.7\n", b"new PA = 1.7000000477\r\n"),
    (b"x", b""),
    (b"y", b"\r\n"),
    (b"r30\n", b"30.00\r\n"),
    (b"p", b"\r\n"),
    (b"y", b"\r\n"),
    (b"r-12.25\n", b"-12.25\r\n"),
    (b"e", b"ERRFL"),
    (b"sds", b"raw encoder: "),
)
"""Commands, and what ends their answers."""


def test_a_run_in_real_time_replays_identically(place: Place) -> None:
    """m1 does j and the script, m2 calibrates (as far as it gets in a short run), m3 has a paced line."""
    path = place.write(
        config(speed=1, devices={"m1": {}, "m2": {"axis": {"start_deg": 40}}, "m3": {"baud": 57600}})
    )
    log = place.folder / "run.log"
    arguments = [str(path), str(place.runtime), str(place.state), str(log), str(SOAK_S)]
    load = [subprocess.Popen([sys.executable, "-c", BUSY.format(SOAK_S)]) for _ in range(2)]
    try:
        begin = time.monotonic()
        server = place.script(RUN, *arguments).started()
        with server.client("m1") as m1, server.client("m2") as m2, server.client("m3") as m3:
            m2.write(b"c")
            m1.write(b"xyj")
            m1.read_until(b"9...\r\n")
            rounds = 0
            while rounds == 0 or time.monotonic() < begin + SOAK_S - 3:
                for command, end in SCRIPT:
                    m3.write(command)
                    m3.read_until(end)
                rounds += 1
            m1.read_until(b"1...\r\n")
            numbers = [int(m1.read_until(b"\r\n")) for _ in range(650)]
            assert len(set(numbers)) > 100
            m1.write(b"kpd240\nqxyr45\n")
            m1.read_until(b"45.00\r\n")
            m2.read_until(b"\r\n0% .....")
            if begin + SOAK_S > time.monotonic():
                m1.quiet(begin + SOAK_S - time.monotonic())
            status = server.ask("status")
        server.stop()
    finally:
        for process in load:
            process.kill()
            process.wait(PATIENCE_S)
    assert sum(status["lag"][27:]) > 0, "the event loop was never late by 67 ms"
    said = place.cli("replay", str(log))
    assert said.startswith("identical: ")
    print(f"{rounds} rounds; {said}")
