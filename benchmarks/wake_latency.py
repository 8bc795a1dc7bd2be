"""Wake-up latency of the core's thread beside a busy asyncio loop, against cyclictest on the same CPU at the
same time; and the ticks that are missed for a held GIL, a garbage collection and a hung callback.

Each run has two wakers on one CPU, both SCHED_FIFO 80, started in turn first or second: the core and a
cyclictest, or, for the band of what chance does, two cyclictests.
"""

import json
import os
import re
import statistics
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from _processes import have, load
from _report import is_quick, report

PRIORITY = 80
LONGEST_US = 100_000
MISSED_LIMIT = 1e-4
DISTURBANCES = ("none", "gil", "gc", "hung")


@dataclass
class Wakes:
    """Latencies of one waker in one run."""

    p999_us: float
    max_us: float
    wakes: int
    missed: int

    @property
    def missed_share(self) -> float:
        return self.missed / (self.wakes + self.missed)


def percentile(counts: list[tuple[float, float, int]], part: float) -> float:
    """Value below which the fraction ``part`` of all counts lies, interpolated linearly within a bucket.
    ``counts``: rows of (from, to, count)."""
    wanted = part * sum(count for _, _, count in counts)
    for low, high, count in counts:
        if count and wanted <= count:
            return low + (high - low) * wanted / count
        wanted -= count
    return counts[-1][1]


def cyclictest(cpu: int, interval_us: int, seconds: float) -> subprocess.Popen[str]:
    command = ["cyclictest", "-q", "-m", f"-p{PRIORITY}", f"-a{cpu}", "-t1", f"-i{interval_us}"]
    loops = round(seconds * 1e6 / interval_us)
    return subprocess.Popen([*command, f"-l{loops}", f"-h{LONGEST_US}"], stdout=subprocess.PIPE, text=True)


def of_cyclictest(process: subprocess.Popen[str], interval_us: int) -> Wakes:
    text = process.communicate()[0]
    counts = [
        (us, us + 1, n) for us, n in ((int(a), int(b)) for a, b in re.findall(r"^(\d+) (\d+)$", text, re.M))
    ]
    found = re.search(r"# Max Latencies: (\d+)", text)
    if not found:
        raise RuntimeError(f"cyclictest said {text[-300:]!r}")
    wakes = sum(n for _, _, n in counts)
    missed = sum(us // interval_us * n for us, _, n in counts)
    return Wakes(percentile(counts, 0.999), float(found[1]), wakes, missed)


CORE = Path(__file__).with_name("_busy_core.py")


def core(cpu: int, rate_hz: int, seconds: float, disturbance: str) -> subprocess.Popen[str]:
    """Start a process of the core's waker, which is ready to run and waits for a line."""
    command = [sys.executable, str(CORE), str(cpu), str(rate_hz), str(seconds), disturbance]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdout
    process.stdout.readline()
    return process


def go(process: subprocess.Popen[str]) -> None:
    assert process.stdin
    process.stdin.write("go\n")
    process.stdin.flush()


def of_core(process: subprocess.Popen[str]) -> Wakes:
    from hil.core.core import bucket_edges_ns

    stats = json.loads(process.communicate()[0])
    counts = [
        (low / 1000, high / 1000, n)
        for (low, high), n in ((bucket_edges_ns(b), n) for b, n in enumerate(stats["wake_latency"]))
    ]
    return Wakes(
        percentile(counts, 0.999), stats["longest_latency_ns"] / 1000, stats["ticks"], stats["missed"]
    )


def pair(
    cpu: int, rate_hz: int, seconds: float, core_first: bool, disturbance: str = "none"
) -> tuple[Wakes, Wakes]:
    """Wakes of the core and of a cyclictest beside it."""
    interval_us = round(1e6 / rate_hz)
    ours = core(cpu, rate_hz, seconds, disturbance)
    if core_first:
        go(ours)
    theirs = cyclictest(cpu, interval_us, seconds)
    if not core_first:
        go(ours)
    return of_core(ours), of_cyclictest(theirs, interval_us)


def two_cyclictests(cpu: int, rate_hz: int, seconds: float) -> tuple[Wakes, Wakes]:
    interval_us = round(1e6 / rate_hz)
    one, other = cyclictest(cpu, interval_us, seconds), cyclictest(cpu, interval_us, seconds)
    return of_cyclictest(one, interval_us), of_cyclictest(other, interval_us)


def compare(rate_hz: int, loaded: bool, cpu: int, runs: int, seconds: float) -> None:
    ours, theirs, band = [], [], []
    with load(loaded):
        for run in range(runs):
            a, b = pair(cpu, rate_hz, seconds, core_first=run % 2 == 0)
            ours.append(a)
            theirs.append(b)
            band.append(two_cyclictests(cpu, rate_hz, seconds))
    name = f"wake_latency_{rate_hz}Hz_{'loaded' if loaded else 'idle'}"
    missed = statistics.mean(w.missed_share for w in ours) - statistics.mean(w.missed_share for w in theirs)
    for what in ("p999_us", "max_us"):
        ratios = [getattr(a, what) / getattr(b, what) for a, b in zip(ours, theirs, strict=True)]
        of_band = [getattr(a, what) / getattr(b, what) for a, b in band]
        limit = max(max(of_band), 1 / min(of_band))
        extra: dict[str, object] = {
            "reference": "a cyclictest on the same CPU at the same time; medians of the runs",
            "band_of_cyclictest_against_cyclictest": [1 / limit, limit],
            "median_of_ratios": statistics.median(ratios),
            "ratios": ratios,
            "missed_beyond_cyclictest": missed,
        }
        report(
            f"{name}_{what.removesuffix('_us')}",
            statistics.median(getattr(w, what) for w in ours),
            "us",
            statistics.median(getattr(w, what) for w in theirs),
            limit,
            extra,
        )
    verdict = "yes" if missed <= MISSED_LIMIT else "NO"
    print(
        f"  missed beyond cyclictest's: {100 * missed:.4f} % (<= {100 * MISSED_LIMIT:g} %: {verdict})",
        flush=True,
    )


def disturb(rate_hz: int, cpu: int, runs: int, seconds: float) -> None:
    """Measure the ticks that each disturbance makes the core miss beyond those of the cyclictest beside
    it."""
    beyond: dict[str, list[int]] = {name: [] for name in DISTURBANCES}
    for run in range(runs):
        for name in DISTURBANCES:
            ours, theirs = pair(cpu, rate_hz, seconds, run % 2 == 0, name)
            beyond[name].append(ours.missed - theirs.missed)
    for name in DISTURBANCES[1:]:
        value, reference = statistics.median(beyond[name]), statistics.median(beyond["none"])
        print(
            f"missed_ticks_{name}_{rate_hz}Hz: {value:g} ticks beyond cyclictest's in {seconds:g} s, "
            f"{reference:g} without (none more: {'yes' if value <= max(reference, 0) else 'NO'})",
            flush=True,
        )
        report(
            f"missed_{name}_{rate_hz}Hz",
            value,
            "ticks",
            reference,
            None,
            {"all": beyond, "reference": "no disturbance"},
        )


def main() -> None:
    """Measure every rate, without and with load; then the disturbances."""
    if not (have("cyclictest", "rt-tests") and have("stress-ng", "stress-ng")):
        return
    cpu = max(os.sched_getaffinity(0))
    runs, seconds = (3, 1.5) if is_quick() else (7, 4.0)
    for rate_hz in (1000, 6500):
        for loaded in (False, True):
            compare(rate_hz, loaded, cpu, runs, seconds)
    for rate_hz in (1000, 6500):
        disturb(rate_hz, cpu, 1 if is_quick() else 3, 3.0)


if __name__ == "__main__":
    main()
