"""Multi-axis runs: what a document says (``document.py``), the whole motion that follows from it before
anything moves (``plan.py``), and how that is carried out (``execute.py``).

Knows no clock: ``hil.live`` and ``hil.testing`` drive it.

May import: hil.config, hil.core, hil.sim, hil.telemetry, hil.vocab, hil.wire, the pure standard library,
pydantic, pydantic_core.
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
