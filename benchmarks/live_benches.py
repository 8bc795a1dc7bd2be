"""Time until a live bench of the kit answers, beyond its board's own start; and many of them side by side."""

import statistics
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from _report import is_quick, report

from hil.testing import live

LIMIT_S = 1.5
SPEED = 20
BOARD_S = 1.15 / SPEED
"""Start of a SAC, with the time in which the last of its boot text leaves."""
CONFIG = {"bench": "t", "speed": SPEED, "devices": {"s1": {"profile": "sac"}}}
SIDE_BY_SIDE = 20


def ready_s(_: int = 0) -> float:
    """Time until a bench answers, without its board's start; a command is typed, too."""
    began_s = time.perf_counter()
    with live(CONFIG) as bench:
        took_s = time.perf_counter() - began_s - BOARD_S
        assert bench.type("s1", b"\r", until=b"SAC>").endswith(b"SAC>")
    return took_s


def folders() -> list[Path]:
    return list(Path(tempfile.gettempdir()).glob("hil-????????"))


def main() -> None:
    """Medians; with a number as argument so many rounds side by side."""
    rounds = int(sys.argv[1]) if sys.argv[1:] and sys.argv[1].isdecimal() else 1 if is_quick() else 10
    before = set(folders())
    alone = [ready_s() for _ in range(5)]
    together: list[float] = []
    with ThreadPoolExecutor(SIDE_BY_SIDE) as pool:
        for _ in range(rounds):
            together += pool.map(ready_s, range(SIDE_BY_SIDE))
    extra = {
        "reference": "the limit: 1.5 s",
        "alone_s": alone,
        "side_by_side": SIDE_BY_SIDE,
        "rounds": rounds,
        "together_median_s": statistics.median(together),
        "together_max_s": max(together),
        "left_behind": len(set(folders()) - before),
    }
    report("live_benches", statistics.median(alone), "s", LIMIT_S, 1.0, extra)
    print(
        f"  {SIDE_BY_SIDE} side by side, {rounds} rounds: median {statistics.median(together):.2f} s,"
        f" longest {max(together):.2f} s",
        flush=True,
    )


if __name__ == "__main__":
    main()
