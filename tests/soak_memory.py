"""A bench that runs as long as the mixed soak does, with pages and watchers alone, of which some do not read:
its memory afterwards has to be that of before."""

import json
import threading
import time
from pathlib import Path

from e2e_support import PATIENCE_S, Place, Server
from soak_benches import Config
from soak_clients import Actor, Looker, Recorder, Scene
from soak_doors import Drawer, pages

from hil.operations.table import WATCH_IDLE_S

WARM_S = 30.0
"""Time in which everything is loaded. Measured on two busy CPUs: 67 MB at the start became 74 MB in
it, and 83 MB in four minutes."""
LEAST_S = 3 * WARM_S
"""Shortest soak that says anything of the memory."""
QUIET_S = WATCH_IDLE_S + 2.0
"""Time in which watches end that nobody asks any more."""
MOST_MB = 20.0
CONFIG: Config = {
    "bench": "memory",
    "devices": {
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "s1": {"profile": "sac"},
        "s2": {"profile": "sac"},
    },
    "segments": {"bus0": {"stations": ["s1", "s2"], "taps": {"a": {"port": "pty"}}}},
    "faults": [{"fault": "node_babble", "target": "bus0.a", "bytes": 100, "every_ms": 33}],
}


class MemorySoak(threading.Thread):
    """The bench and its clients, until ``end``. ``troubles``: what was wrong; ``said``: the figures."""

    def __init__(self, place: Place, first_port: int, seconds: float) -> None:
        super().__init__(name="memory", daemon=True)
        self._place, self._port, self._seconds = place, first_port, seconds
        web = {"web": {"listen": first_port}, "metrics": {"listen": f"127.0.0.1:{first_port + 1}"}}
        self._server = place.serve(json.dumps(CONFIG | {"bridges": web}), bench="memory")
        self._over = threading.Event()
        self.troubles: list[str] = []
        self.said = "no figures"

    def run(self) -> None:
        server = self._server
        self._busy(server, 0, min(WARM_S, self._seconds / 3))
        before_MB = _rss_MB(server)
        self._busy(server, 1, None)
        after_MB = _rss_MB(server)
        self.said = f"memory with pages and watchers alone: {before_MB:.0f} MB, then {after_MB:.0f} MB"
        if after_MB > before_MB + MOST_MB and self._seconds >= LEAST_S:
            self.troubles.append(f"{self.said}: {MOST_MB:g} MB more are allowed")
        if "Traceback" in server.output:
            self.troubles.append("a traceback in the log of the memory's bench")

    def end(self) -> None:
        """End it, and wait for its figures."""
        self._over.set()
        self.join(3 * PATIENCE_S)

    def _busy(self, server: Server, seed: int, seconds: float | None) -> None:
        file = self._place.folder / "memory.yaml"
        metrics = f"http://127.0.0.1:{self._port + 1}/metrics"
        scene = Scene(seed, CONFIG, file, server.control, "", metrics)
        url = f"http://127.0.0.1:{self._port}/ws"
        every: list[Actor] = [*pages(scene, url), *pages(scene, url), Drawer(scene, "drawer")]
        every += [Looker(scene, "looker"), Recorder(scene, "recorder")]
        for actor in every:
            actor.start()
        self._over.wait(seconds)
        scene.over.set()
        for actor in every:
            actor.join(PATIENCE_S)
        self.troubles += scene.troubles
        time.sleep(QUIET_S)  # what clients left behind is put away


def _rss_MB(server: Server) -> float:
    lines = Path(f"/proc/{server.pid}/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS")) / 1024
