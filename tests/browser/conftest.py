"""Tests of the page in a browser. Their helpers are in ``browser_pages.py``."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))  # --import-mode=importlib leaves it out
