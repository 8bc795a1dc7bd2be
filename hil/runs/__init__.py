"""Multi-axis runs: what a document says (``document.py``), and the whole motion that follows from it before
anything moves (``plan.py``). Imports ``hil.config`` for documents and places, and ``hil.core`` for
trajectories; knows no clock and no bench: ``hil.daemon`` carries plans out.
"""

from hil.runs.document import AxisRules, RunDocument, parse_run, run_from_data
from hil.runs.plan import AxisNow, Event, Phrase, Plan, RunRefused, plan_run

__all__ = [
    "AxisNow",
    "AxisRules",
    "Event",
    "Phrase",
    "Plan",
    "RunDocument",
    "RunRefused",
    "parse_run",
    "plan_run",
    "run_from_data",
]
