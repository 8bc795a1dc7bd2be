"""Fixtures of the tests that run the whole program. Their helpers are in ``e2e_support.py`` and
``bench_sites.py``."""

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # --import-mode=importlib leaves it out
sys.path.append(str(Path(__file__).parents[1] / "virtual_ports/usb/tests"))  # a kernel in Python

from bench_sites import Site, on_hosts, side_by_side
from e2e_support import STRANGER_UID, Place


@pytest.fixture
def place() -> Iterator[Place]:
    """A folder with a runtime and a state directory; daemons started in it are gone afterwards."""
    with Place() as made:
        yield made


@pytest.fixture
def open_place(place: Place) -> Place:
    """A place that a stranger can use, too."""
    for folder in (place.runtime, place.state):
        folder.mkdir(parents=True, exist_ok=True)
        if os.getuid() == 0:
            os.chown(folder, STRANGER_UID, STRANGER_UID)
    return place


@pytest.fixture
def site(place: Place) -> Iterator[Site]:
    """Benches and a router side by side."""
    with side_by_side(place) as made:
        yield made


@pytest.fixture
def hosts(place: Place) -> Iterator[Site]:
    """A router and benches, each on a computer of its own."""
    with on_hosts(place) as made:
        yield made
