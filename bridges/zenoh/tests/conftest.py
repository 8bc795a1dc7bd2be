"""Fixtures of the tests on two computers. Their helpers are in ``zenoh_computers.py``."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # --import-mode=importlib leaves it out

from zenoh_computers import two_computers


@pytest.fixture(scope="module")
def computers() -> Iterator[tuple[str, str]]:
    """Names of two computers for all tests of a file."""
    with two_computers("a") as names:
        yield names
