"""Lets the tests import the model of a bench that those of ``hil.sim`` have."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "sim" / "tests"))  # --import-mode=importlib leaves it out
