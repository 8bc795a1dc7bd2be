"""Report of a benchmark's figure: a line for people, a JSON file for programs."""

import json
import os
import platform
import sys
from pathlib import Path

RESULTS = Path(__file__).parent / "results"


def report(
    name: str, value: float, unit: str, reference: float, limit_ratio: float | None, extra: dict[str, object]
) -> None:
    """Report the figure, its reference from the same run, and their ratio; with a limit, whether it holds.

    ``extra`` stands in the JSON file beside them; ``extra["reference"]`` says what the reference is.
    """
    ratio = value / reference if reference else float("inf")
    verdict = ""
    if limit_ratio is not None:
        verdict = f" (<= {limit_ratio:g}: {'yes' if ratio <= limit_ratio else 'NO'})"
    print(
        f"{name}: {value:.4g} {unit}, reference {reference:.4g} {unit}, ratio {ratio:.3f}{verdict}",
        flush=True,
    )
    RESULTS.mkdir(exist_ok=True)
    result = {
        "name": name,
        "benchmark": Path(sys.argv[0]).name,
        "is_quick": is_quick(),
        "value": value,
        "unit": unit,
        "reference": reference,
        "ratio": ratio,
        "limit_ratio": limit_ratio,
        "machine": {
            "kernel": platform.release(),
            "cpus": os.cpu_count(),
            "python": platform.python_version(),
        },
        "extra": extra,
    }
    (RESULTS / f"{name}.json").write_text(json.dumps(result, indent=1) + "\n")


def check_work(what: str, done: float, expected: float, tolerance: float = 0.0) -> None:
    """End the benchmark if the work done is not what its figure is for.

    ``tolerance``: part of ``expected`` by which ``done`` may differ, either way.
    """
    if abs(done - expected) > tolerance * expected:
        sys.exit(f"{what}: {done:,.6g} instead of {expected:,.6g}: a figure would be that of other work")


def is_quick() -> bool:
    """True if a short run is wanted: fewer repetitions, the same figure."""
    return "--quick" in sys.argv[1:]
