"""Lets the tests import ``drive_rig.py`` beside them."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))  # --import-mode=importlib leaves it out
