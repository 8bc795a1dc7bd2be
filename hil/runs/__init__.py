"""Multi-axis runs: what a document says (``run_document.py``), the whole motion that follows from it before
anything moves (``planner.py``), and how that is carried out (``execute.py``, each axis by ``run_axis.py``).

Imports ``hil.config`` for documents and places, ``hil.core`` for trajectories, ``hil.sim`` for inputs;
knows no clock: ``hil.live`` and ``hil.testing`` drive it.
"""

from hil.runs.axes import AxisNow, Refused, Rows, RunBench
from hil.runs.baton import Baton, Soon, Told
from hil.runs.clock import ClockOffset
from hil.runs.execute import Execution
from hil.runs.on_bench import BenchAxes
from hil.runs.plan import Event, Phrase, Plan
from hil.runs.planner import plan_run
from hil.runs.progress import AxisReport, BenchReport, Ended, How, Progress
from hil.runs.run_document import AxisRules, RunDocument, parse_run, run_from_data

__all__ = [
    "AxisNow",
    "AxisReport",
    "AxisRules",
    "Baton",
    "BenchAxes",
    "BenchReport",
    "ClockOffset",
    "Ended",
    "Event",
    "Execution",
    "How",
    "Phrase",
    "Plan",
    "Progress",
    "Refused",
    "Rows",
    "RunBench",
    "RunDocument",
    "Soon",
    "Told",
    "parse_run",
    "plan_run",
    "run_from_data",
]
