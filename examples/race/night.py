"""A night of the cell in simulated time, recorded: what `hil serve bench.yaml` records in as many hours."""

import sys
from pathlib import Path

from hil.testing import Bench

HOURS = 1.2

with (
    Bench(Path(__file__).parent / "bench.yaml") as bench,
    Path("night.hil").open("w", encoding="utf-8") as log,
):
    bench.run(float((sys.argv[1:] or [HOURS])[0]) * 3600_000)
    bench.inputs.write_to(log)
