"""The pytest plugin: the ``bench`` fixture."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from hil.testing.bench import Bench


@pytest.fixture
def bench() -> "Iterator[Callable[..., Bench]]":
    """Makes benches that are closed after the test: ``bench("bench.yaml")``, ``bench({...}, seed=1)``."""
    from hil.testing.bench import Bench

    made: list[Bench] = []

    def make(config: str | Path | Mapping[str, Any], seed: int = 0) -> Bench:
        made.append(Bench(config, seed))
        return made[-1]

    yield make
    for each in made:
        each.close()
