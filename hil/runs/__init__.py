"""Multi-axis runs: the document (``run_document.py``), the plan of its whole motion before anything moves
(``planner.py``), and its execution (``execute.py``, each axis by ``run_axis.py``). Knows no clock:
``hil.live`` and ``hil.testing`` drive it.

May import: hil.config, hil.core, hil.sim, hil.telemetry, hil.vocab, the pure standard library, pydantic,
pydantic_core.
"""

from hil.runs.axes import AxisNow, Refused, Rows
from hil.runs.clock_offset import ClockOffset
from hil.runs.execute import Execution, Soon, Told
from hil.runs.on_bench import BenchAxes
from hil.runs.plan import Plan
from hil.runs.planner import plan_run
from hil.runs.progress import AxisReport, BenchReport, How, Progress
from hil.runs.run_document import RunDocument, parse_run, run_from_data

__all__ = [
    "AxisNow",
    "AxisReport",
    "BenchAxes",
    "BenchReport",
    "ClockOffset",
    "Execution",
    "How",
    "Plan",
    "Progress",
    "Refused",
    "Rows",
    "RunDocument",
    "Soon",
    "Told",
    "parse_run",
    "plan_run",
    "run_from_data",
]
