"""Begin and end of `make bench`: the noise of the machine, and all figures in one table.

    _table.py begin     forgets the figures of earlier runs and measures the noise
    _table.py end       measures it again, prints the table; exits with 1 if a goal is missed by more than it
    _table.py docs      writes the table into docs/benchmarks.md

Noise is what a ratio of two equal things differs from 1 in nine of ten pairs, taken in turns, at the worse of
both times.
"""

import json
import os
import platform
import sys
import time
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from _report import RESULTS

PAGE = Path(__file__).parents[1] / "docs" / "benchmarks.md"
BEGIN, END = "<!-- figures: written by `make bench-docs` -->\n", "<!-- end of the figures -->\n"
RUN = RESULTS / "run.json"
PAIRS = 21
LOOPS = 200_000
"""Turns of a loop, some 10 ms."""


def main() -> None:
    match sys.argv[1:]:
        case ["begin"]:
            begin()
        case ["end"]:
            sys.exit(end())
        case ["docs"]:
            PAGE.write_text(written(PAGE.read_text()))
        case _:
            sys.exit(f"usage: {sys.argv[0]} begin | end | docs")


def begin() -> None:
    RESULTS.mkdir(exist_ok=True)
    for old in RESULTS.glob("*.json"):
        old.unlink()
    about = {
        "processor": processor(),
        "cpus": os.cpu_count(),
        "kernel": platform.release(),
        "python": platform.python_version(),
        "began": datetime.now(UTC).isoformat(timespec="minutes"),
        "loads": [os.getloadavg()[0]],
        "noise": noise(),
    }
    RUN.write_text(json.dumps(about, indent=1) + "\n")


def end() -> int:
    """Print the table. Answers the exit code."""
    if not RUN.exists():
        sys.exit("no run has begun: `make bench` begins one")
    about = json.loads(RUN.read_text())
    about["loads"].append(os.getloadavg()[0])
    about["noise"] = max(about["noise"], noise())
    RUN.write_text(json.dumps(about, indent=1) + "\n")
    found = figures()
    rows = [row(each, about["noise"]) for each in found]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)] if rows else []
    print("\n" + machine(about))
    for cells in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(cells, widths, strict=True)).rstrip())
    missed = [each["name"] for each in found if verdict(each, about["noise"]) == "MISSED"]
    print(f"{len(missed)} of {len(found)} figures missed their goals", *missed)
    return 1 if missed else 0


def figures() -> list[dict[str, Any]]:
    """Figures of this run, by benchmark and name."""
    found = [json.loads(path.read_text()) for path in RESULTS.glob("*.json") if path != RUN]
    return sorted(found, key=lambda each: (each["benchmark"], each["name"]))


def row(figure: dict[str, Any], noise_share: float) -> tuple[str, ...]:
    """Cells of a figure: name, figure, reference, ratio, goal, verdict."""
    unit, limit = figure["unit"], figure["limit_ratio"]
    return (
        figure["name"],
        f"{figure['value']:.4g} {unit}",
        f"{figure['reference']:.4g} {unit}",
        f"{figure['ratio']:.3g}",
        "-" if limit is None else f"<= {limit:.3g}",
        verdict(figure, noise_share),
    )


def verdict(figure: dict[str, Any], noise_share: float) -> str:
    """Say whether the goal is met: a count has no noise."""
    limit, ratio = figure["limit_ratio"], figure["ratio"]
    if limit is None:
        return ""
    if ratio <= limit:
        return "met"
    allowed = limit if figure["extra"].get("exact") else limit * (1 + noise_share)
    return "within noise" if ratio <= allowed else "MISSED"


def machine(about: dict[str, Any]) -> str:
    """Say on what, beside what and when it was measured."""
    loads = " to ".join(f"{load:.1f}" for load in about["loads"])
    return (
        f"{about['processor']}, {about['cpus']} CPUs, Linux {about['kernel']}, Python {about['python']};"
        f" load {loads}, noise {about['noise']:.1%}; {about['began']}"
    )


def written(page: str) -> str:
    """Page with the table of this run in the place of the one before. Raises SystemExit: there is no run."""
    found = figures() if RUN.exists() else []
    if not found:
        sys.exit("there are no figures: run `make bench` first")
    about = json.loads(RUN.read_text())
    kind = "a quick run" if any(each["is_quick"] for each in found) else "a whole run"
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}\n{machine(about)}; {kind}.\n\n{''.join(markdown(found, about))}\n{END}{after}"


def markdown(found: Iterable[dict[str, Any]], about: dict[str, Any]) -> Iterator[str]:
    """Lines of the table of the page."""
    yield "| figure | | reference | ratio | goal | |\n|---|---|---|---|---|---|\n"
    for figure in found:
        name, *cells = row(figure, about["noise"])
        yield f"| `{name}` | {' | '.join(cells)} |\n"


def noise() -> float:
    """Share by which the ratio of two equal loops differs from 1 in nine of ten pairs."""
    apart = sorted(abs(spin() / spin() - 1) for _ in range(PAIRS))
    return apart[PAIRS * 9 // 10]


def spin() -> float:
    """CPU time of a loop, in seconds."""
    began = time.process_time()
    total = 0
    for number in range(LOOPS):
        total += number & 3
    return time.process_time() - began


def processor() -> str:
    """Name of the processor, as the kernel tells it."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


if __name__ == "__main__":
    main()
