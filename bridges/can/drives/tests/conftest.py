"""Lets the tests import their models, and the world of drives."""

import sys
from pathlib import Path

# --import-mode=importlib leaves them out
for folder in (Path(__file__).parent, Path(__file__).parents[4] / "hil" / "drives" / "tests"):
    sys.path.insert(0, str(folder))
