"""The pytest plugin: the fixtures ``bench``, ``segment`` and ``fault``."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from hil.testing.bench import Bench
    from hil.testing.faces import FaultFace


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


@pytest.fixture
def segment(bench: "Callable[..., Bench]") -> "Callable[..., Bench]":
    """Makes a bench of SACs on one segment, past their cold start: ``segment(32)`` has ``s4`` to ``s35`` with
    those addresses on ``bus0``, and a tap ``bus0.master``. ``baud`` is the line's, ``first`` the first
    address."""

    def make(nodes: int, *, baud: int = 38400, first: int = 4, seed: int = 0) -> "Bench":
        from hil.testing.nodes import segment_of

        return segment_of(bench, nodes, baud=baud, first=first, seed=seed)

    return make


@pytest.fixture
def fault() -> "Iterator[Callable[..., FaultFace]]":
    """Makes things go wrong until the test's end: ``fault(b, "packet_no_ack", "s4.network", rate=0.5)``."""
    made: list[FaultFace] = []

    def inject(bench: "Bench", kind: str, target: str, **parameters: float | str) -> "FaultFace":
        made.append(bench.fault(kind, target, **parameters))
        return made[-1]

    yield inject
    for each in reversed(made):
        each.clear()
