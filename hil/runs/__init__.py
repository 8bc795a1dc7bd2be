"""Multi-axis runs: the document (``run_document.py``), the plan of its whole motion before anything moves
(``planner.py``), and its execution (``execute.py``, each axis by ``run_axis.py``). Knows no clock:
``hil.live`` and ``hil.testing`` drive it.

May import: hil.config, hil.core, hil.sim, hil.telemetry, hil.vocab, the pure standard library, pydantic,
pydantic_core.

Tests may import too: hil.firmware, hil.testing.
"""

from hil.runs.clock_offset import ClockOffset
from hil.runs.execute import Execution, Soon, Told
from hil.runs.plan import Plan
from hil.runs.plan_points import plan_points
from hil.runs.planner import plan_run
from hil.runs.progress import AxisReport, BenchReport, Progress
from hil.runs.run_axis import bounds_of
from hil.runs.run_document import RunDocument, RunTextError, parse_run, run_from_data
from hil.runs.text_problems import all_problems, checked_run
from hil.runs.twin_axes import TwinAxes

__all__ = [
    "AxisReport",
    "BenchReport",
    "ClockOffset",
    "Execution",
    "Plan",
    "Progress",
    "RunDocument",
    "RunTextError",
    "Soon",
    "Told",
    "TwinAxes",
    "all_problems",
    "bounds_of",
    "checked_run",
    "parse_run",
    "plan_points",
    "plan_run",
    "run_from_data",
]
