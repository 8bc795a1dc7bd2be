"""Lets the tests import the model of axes."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[3] / "runs" / "tests"))  # --import-mode=importlib leaves it out
