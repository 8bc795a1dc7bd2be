"""Multi-axis runs: what a document says (``document.py``), the whole motion that follows from it before
anything moves (``plan.py``), and how that is carried out (``execute.py``).

Imports ``hil.config`` for documents and places, ``hil.core`` for trajectories, ``hil.sim`` for inputs;
knows no clock: ``hil.daemon`` and ``hil.testing`` drive it.
"""

from hil.runs.clock import ClockOffset
from hil.runs.document import AxisRules, RunDocument, parse_run, run_from_data
from hil.runs.execute import Baton, Ended, Execution, Progress, RunBench, Soon
from hil.runs.on_bench import BenchAxes, Named
from hil.runs.plan import AxisNow, Event, Phrase, Plan, plan_run

__all__ = [
    "AxisNow",
    "AxisRules",
    "Baton",
    "BenchAxes",
    "ClockOffset",
    "Ended",
    "Event",
    "Execution",
    "Named",
    "Phrase",
    "Plan",
    "Progress",
    "RunBench",
    "RunDocument",
    "Soon",
    "parse_run",
    "plan_run",
    "run_from_data",
]
