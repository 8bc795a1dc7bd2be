"""Lets the tests import their models, and that of a bench that those of ``hil.sim`` have."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "sim" / "tests")]  # --import-mode=importlib leaves them out
