"""Lets the tests import their helpers, and those of the SAC's tests."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
for folder in (HERE, HERE.parents[2] / "device_profiles" / "sac" / "tests"):
    sys.path.insert(0, str(folder))  # --import-mode=importlib leaves it out
