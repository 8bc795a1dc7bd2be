"""Time that looking back at an hour of two boards takes, and the memory of its check points.

``look_back_open_s``: from the start of the process, without check points, to the state at the hour's end.
``look_back_any_s``: the state at any second after that, the slowest of nine; at most 3 s.
``look_back_plot_s``: ten seconds of five fields at full rate, their smallest and largest values for 1200
points, the slowest of nine; at most 0.5 s. ``look_back_memory_MB``: of all check points, what they share
counted once; at most 400.
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from _report import check_work, is_quick, report

from hil.lookback.look_head import GIVEN, HEAD, WORKER
from hil.testing import Bench

S = 1_000_000_000
SECONDS = 600 if is_quick() else 3600
FIELDS = ["m1.e", "m1.r", "m1.u", "m1.yw", "m1.position_deg"]
PLACES = [0.05, 0.9, 0.33, 0.61, 0.12, 0.77, 0.48, 0.99, 0.25]


def record(path: Path) -> None:
    """Record two boards that a person has to do with each five seconds."""
    devices = {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}, "s1": {"profile": "sac"}}
    with Bench({"bench": "two", "devices": devices}) as bench:
        bench.start()
        bench.device("m1").do("enable")
        for turn in range(SECONDS // 5):
            bench.device("m1").do("position", position_deg=(turn % 7) * 20.0)
            bench.port("s1").write(b"?\r")
            bench.run(5000)
        with path.open("w") as file:
            bench.inputs.write_to(file)


class Asker:
    """Asker of the process."""

    def __init__(self, path: Path) -> None:
        command = [sys.executable, "-P", "-m", WORKER, str(path)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def ask(self, what: str, to_ns: int = 0, **given: Any) -> tuple[dict[str, Any], float]:
        """Ask for something; answers it, and how long it took."""
        assert self.process.stdin
        assert self.process.stdout
        begun_s = time.perf_counter()
        asked = {"id": 1, "lane": what, "known_ns": 0, "from_ns": to_ns, "to_ns": to_ns, "most": 400}
        self.process.stdin.write(json.dumps(asked | {"what": what, "points": 1200} | given).encode() + b"\n")
        self.process.stdin.flush()
        _, status, length = HEAD.unpack(self.process.stdout.read(HEAD.size))
        told = self.process.stdout.read(length)
        took_s = time.perf_counter() - begun_s
        assert status == GIVEN, told
        return json.loads(told), took_s

    def close(self) -> None:
        assert self.process.stdin
        assert self.process.stdout
        self.process.stdin.close()
        self.process.wait()
        self.process.stdout.close()


def memory_kB(path: Path) -> int:
    """Memory of all processes of a recording, what they share counted once."""
    total = 0
    for entry in Path("/proc").iterdir():
        try:
            if entry.name.isdigit() and str(path).encode() in (entry / "cmdline").read_bytes():
                total += int((entry / "smaps_rollup").read_text().split("\nPss:")[1].split()[0])
        except OSError:
            continue
    return total


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "hour.hil"
        record(path)
        begun_s = time.perf_counter()
        asker = Asker(path)
        end_ns = SECONDS * S
        asker.ask("state", end_ns)
        opened_s = time.perf_counter() - begun_s
        overview, _ = asker.ask("overview")
        check_work("seconds", overview["end_ns"] / S, SECONDS, 0.02)
        anywhere, plots = [], []
        for place in PLACES:
            at_ns = round(place * overview["end_ns"])
            told, took_s = asker.ask("state", at_ns)
            check_work("time", told["at_ns"], at_ns)
            anywhere.append(took_s)
            from_ns = max(at_ns - 10 * S, 0)
            told, took_s = asker.ask("samples", at_ns, from_ns=from_ns, fields=FIELDS)
            check_work("rows", told["series"][0]["rows"], 1200, 0.05)
            plots.append(took_s)
        told_of: dict[str, object] = {"seconds": SECONDS, "check_points": overview["check_points"]}
        report("look_back_open_s", opened_s, "s", 3.0, None, told_of | {"reference": "3 s"})
        report("look_back_any_s", max(anywhere), "s", 3.0, 1.0, told_of | {"reference": "3 s"})
        report("look_back_plot_s", max(plots), "s", 0.5, 1.0, told_of | {"reference": "0.5 s"})
        used_MB = memory_kB(path) / 1e3
        report("look_back_memory_MB", used_MB, "MB", 400.0, 1.0, told_of | {"reference": "400 MB"})
        asker.close()


if __name__ == "__main__":
    main()
