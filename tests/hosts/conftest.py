"""Fixtures of tests over several computers. They are for root alone: ``make test-hosts``."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # --import-mode=importlib leaves it out

from host_network import CannotBe, HostNetwork, built, leave_the_machine


@pytest.fixture(scope="session")
def switch_program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The built switch; from here on this process has a network of its own."""
    try:
        leave_the_machine()
    except CannotBe as why:
        pytest.skip(str(why))
    return built(tmp_path_factory.mktemp("switch"))


@pytest.fixture
def network(switch_program: Path) -> Iterator[HostNetwork]:
    """Makes computers on a switch; what ran there, and they, are gone afterwards."""
    made = HostNetwork(switch_program)
    try:
        yield made
    finally:
        made.close()
