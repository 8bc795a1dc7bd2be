"""Pytest fixture ``lab_bench``: a bench of a lab, found by its labels, and leased until the test's end."""

import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from hil.client import Bench

_LOOK_AGAIN_S = 1.0
"""Time between two looks for a bench that is free."""


class NoneFree(Exception):
    """Error of a lab without a bench that can be had: ``str(error)`` says of each why not."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options that say where the lab is, and how long to wait for a bench."""
    group = parser.getgroup("hil")
    group.addoption(
        "--lab-config",
        metavar="FILE",
        help="a user's zenoh.json, which says the lab's door, for the fixture `lab_bench`; without it the"
        " environment's HIL_LAB_CONFIG; without both such tests are skipped",
    )
    group.addoption(
        "--lab-wait",
        metavar="SECONDS",
        type=float,
        default=0.0,
        help="time for which `lab_bench` waits for a bench that is free; then the test fails",
    )


@pytest.fixture
def lab_bench(request: pytest.FixtureRequest) -> "Iterator[Callable[..., Bench]]":
    """Have benches of a lab until the test's end: ``lab_bench(labels={"rig": "press"})``, or
    ``lab_bench("press1")`` by name. Each is a ``hil.client.Bench`` with its axes and runs, leased by the user
    of ``--lab-config`` and given back, also after a failure. ``doors``: those that stay open, as ``ports``.
    """
    given = request.config.getoption("--lab-config", None) or os.environ.get("HIL_LAB_CONFIG")
    if not given:
        pytest.skip("no lab is known: --lab-config or HIL_LAB_CONFIG names a user's zenoh.json")
    config = request.config.invocation_params.dir / given
    wait_s = request.config.getoption("--lab-wait", 0.0)
    with ExitStack() as stack:

        def have(
            name: str = "", *, labels: Mapping[str, str] | None = None, doors: Sequence[str] = ()
        ) -> "Bench":
            __tracebackhide__ = True
            why = f"pytest: {request.node.name}"
            try:
                return free_bench(stack, config, name, labels or {}, why, doors, wait_s)
            except NoneFree as error:
                pytest.fail(str(error), pytrace=False)

        yield have


def free_bench(
    stack: ExitStack,
    config: Path,
    name: str,
    labels: Mapping[str, str],
    why: str,
    doors: Sequence[str],
    wait_s: float,
) -> "Bench":
    """Take the first bench that is free, of those with a name, or with labels; ``stack`` gives it back.

    Raises:
        NoneFree: there is none within this time.
    """
    from hil.client import ClientError, Lab

    deadline_s = time.monotonic() + wait_s
    while True:
        try:
            with Lab(config=config) as lab:
                rows = lab.benches(labels)
        except ClientError as error:
            raise NoneFree(f"the lab is away: {error}") from None
        names = [row["bench"] for row in rows if name in ("", row["bench"])]
        whys = []
        for each in names:
            try:
                return _taken(stack, each, config, why, doors)
            except ClientError as error:
                whys.append(f"{each}: {error}")
        if time.monotonic() >= deadline_s:
            said = " and ".join(filter(None, (name, *(f"{key}={value}" for key, value in labels.items()))))
            none = f"no bench of the lab is {said}" if said else "no bench is in the lab"
            raise NoneFree("\n".join(["no bench is free:", *whys]) if whys else none)
        time.sleep(_LOOK_AGAIN_S)


def _taken(stack: ExitStack, name: str, config: Path, why: str, doors: Sequence[str]) -> "Bench":
    """Connect to a bench and take its lease. Raises ClientError: it cannot be had."""
    from hil.client import connect_sync
    from hil.client.held_bench import held

    with ExitStack() as trying:
        bench = trying.enter_context(connect_sync(name, config=config))
        trying.enter_context(held(bench, why, doors=doors))
        stack.push(trying.pop_all())
    return bench
