"""How a benchmark says what it found: one line, and the same as JSON in ``results/``."""

import json
from pathlib import Path

RESULTS = Path(__file__).parent / "results"


def report(
    name: str, value: float, unit: str, reference: float, limit_ratio: float | None, extra: dict[str, object]
) -> None:
    """Print a figure beside its reference from the same run, and write ``results/<name>.json``.

    ``limit_ratio``: what value / reference may be at most; None: there is no limit.
    """
    ratio = value / reference
    line = f"{name}: {value:.4g} {unit}, reference {reference:.4g} {unit}, ratio {ratio:.2f}"
    met = None if limit_ratio is None else ratio <= limit_ratio
    if limit_ratio is not None:
        line += f" (<= {limit_ratio}: {'yes' if met else 'no'})"
    print(line, flush=True)
    RESULTS.mkdir(exist_ok=True)
    result = {
        "name": name, "value": value, "unit": unit, "reference": reference, "ratio": ratio,
        "limit_ratio": limit_ratio, "met": met, "extra": extra,
    }  # fmt: skip
    (RESULTS / f"{name}.json").write_text(json.dumps(result, indent=2) + "\n")
