"""A run in real time that is looked at all the time, and its replay: looking is no input."""

import os
import subprocess
import time
import urllib.request
from typing import Any

from e2e_support import HIL, PATIENCE_S, Client, Place, config, until

from device_profiles.sac.packet import encode

LOOKS_S = float(os.environ.get("HIL_LOOKS_S", "6"))
SAC: dict[str, Any] = {"profile": "sac", "flash": {}}
STATIONS = ("s1", "s2", "s3", "s4")
BENCH = config(
    speed=2,
    devices=dict.fromkeys(STATIONS, SAC),
    segments={"bus0": {"stations": list(STATIONS), "taps": {"master": {}}}},
    bridges={"metrics": {"listen": "127.0.0.1:0"}},
    faults=[
        {"fault": "node_babble", "target": "s1.network", "bytes": 3, "every_ms": 11},
        {"fault": "node_babble", "target": "s2.network", "bytes": 3, "every_ms": 13},
    ],
)


def test_a_bench_that_is_looked_at_replays_identically(place: Place) -> None:
    log = place.folder / "run.log"
    server = place.serve(BENCH, "--log", str(log))
    until(lambda: server.ask("status")["sim_ns"] > 1_200_000_000, "the cold start")
    metrics = server.ask("status")["bridges"]["metrics"]["root"]
    capture = subprocess.Popen(
        [HIL, "capture", "bus0", "-w", str(place.folder / "c.pcapng"), "--runtime-dir", str(place.runtime)]
    )
    looks = 0
    end_s = time.monotonic() + LOOKS_S
    with Client(str(place.runtime / "t" / "bus0.master")) as master:
        while time.monotonic() < end_s:
            if looks % 7 == 0:
                master.write(encode(85, 1, b"v150") + encode(85, 1, b"y"))
            server.ask("status")
            server.ask("segments")
            if looks % 5 == 0:
                with urllib.request.urlopen(metrics, timeout=PATIENCE_S) as answer:
                    assert b"hil_segment_collisions_total" in answer.read()
            looks += 1
    (row,) = server.ask("segments")
    server.stop()
    assert capture.wait(PATIENCE_S) == 1  # the bench ended before it
    assert row["collisions"] > 0
    assert row["packets"] > 0
    said = place.cli("replay", str(log))
    assert said.startswith("identical: "), said
    print(f"{looks} looks; {row}; {said}")
