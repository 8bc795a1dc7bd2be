"""Pytest plugin: the fixtures ``bench``, ``recorded_bench``, ``segment`` and ``fault``, those of benches in
real time, of sketches and of buses; a test that fails has in its report where its benches stand, and what has
passed on their lines."""

import os
import sys
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from hil.discovery.installed import BUSES, modules_of
from hil.testing.junit_properties import note_benches
from hil.testing.kind_account import LIVE, VIRTUAL, account, kind_of, with_ptys
from hil.testing.known_names import Uncalled
from hil.testing.seeds.seed_run import is_again, run_of
from hil.testing.unsupported import UnsupportedHere

if TYPE_CHECKING:
    from hil.testing.bench import Bench
    from hil.testing.faces import FaultFace
    from hil.testing.given import GivenConfig
    from hil.testing.recorded_bench import RecordedBench

NODE = "sac"
COLD_START_MS = 1100
pytest_plugins = [
    "hil.testing.kind_option",
    "hil.testing.lab_fixture",
    "hil.testing.served_fixtures",
    "hil.testing.sketch_fixture",
    "hil.testing.seeds.seed_plugin",
    *modules_of("bridges", BUSES, "testing.fixtures"),
]
"""Further plugins of the kit, and those of the buses, which pytest loads with this one."""


BENCHES = pytest.StashKey["list[Bench]"]()
"""Benches in memory that a test has, until its end."""


@pytest.fixture
def bench(request: pytest.FixtureRequest, hil_seed: int) -> "Iterator[Callable[..., Bench]]":
    """Make benches that are closed after the test: ``bench("bench.yaml")``, ``bench({...}, seed=1)``; further
    options as of ``hil.testing.Bench``. They are in memory, or of the kind that ``--hil`` says, where seeds
    mean nothing."""
    if (kind := kind_of(request.config)) != VIRTUAL:
        served = request.getfixturevalue("live_bench" if kind == LIVE else "real_bench")

        def make_served(config: "GivenConfig", seed: int = 0, **options: Any) -> Any:
            __tracebackhide__ = True
            if options:
                raise UnsupportedHere(kind, f"{', '.join(options)}: only a bench in memory has this")
            return served(config if kind != LIVE else with_ptys(config))

        yield make_served
        return
    from hil.config import ConfigError
    from hil.testing.bench import Bench

    made: list[Bench] = request.node.stash.setdefault(BENCHES, [])
    run = run_of(request.node, hil_seed)

    def make(config: "GivenConfig", seed: int = 0, **options: Any) -> Bench:
        __tracebackhide__ = True
        try:
            made.append(Bench(config, **run.options(seed) | options))
        except ConfigError as error:
            raise error.with_traceback(None) from None
        return made[-1]

    yield Uncalled("bench", make)
    while made:
        made.pop().close()


@pytest.fixture
def recorded_bench(request: pytest.FixtureRequest) -> "Iterator[Callable[..., RecordedBench]]":
    """Make benches of recordings, with the options of ``hil.testing.RecordedBench``, that are closed after
    the test: ``recorded_bench("bug.hilz", until_ms=12_500)``."""
    from hil.testing.recorded_bench import RecordedBench

    made: list[Bench] = request.node.stash.setdefault(BENCHES, [])

    def make(path: str | os.PathLike[str], until_ms: float | None = None, **options: Any) -> RecordedBench:
        __tracebackhide__ = True
        bench = RecordedBench(path, until_ms, **options)
        made.append(bench)
        return bench

    yield make
    while made:
        made.pop().close()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option ``--hil-artifacts``."""
    parser.getgroup("hil").addoption(
        "--hil-artifacts",
        metavar="DIR",
        type=Path,
        help="keep for each test that fails, in a folder of its own: input logs for hil replay, captures,"
        " pictures of the last two seconds, and a page with all of it",
    )


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Explain a test that failed: where its benches stand, what they said, what passed on their lines."""
    served = sys.modules.get("hil.testing.served_bench")  # noqa: TID251 -- most tests do without it
    benches, live = item.stash.get(BENCHES, []), served.OPEN if served else []
    note_benches(item, benches, live)
    report = yield
    account(item, call, report)
    if report.failed and (benches or live) and not is_again(item):
        from hil.testing.failures.explained import explain

        given = item.config.getoption("--hil-artifacts", None)  # none for a plugin that is loaded late
        artifacts = given and item.config.invocation_params.dir / given  # wherever the test has gone
        report.sections += explain(item.nodeid, report.longreprtext, benches, live, artifacts)
    return report


def pytest_assertrepr_compare(op: str, left: object, right: object) -> list[str] | None:
    """Say in which fields two snapshots differ that a test compares."""
    fields = sys.modules.get("hil.core.fields")  # noqa: TID251 -- no snapshot is compared without it
    if op != "==" or not fields or not all(isinstance(each, fields.Snapshot) for each in (left, right)):
        return None
    was, now = left.as_dict(), right.as_dict()  # type: ignore[attr-defined]
    differ = [name for name in was | now if repr(was.get(name)) != repr(now.get(name))]
    return [f"{left} == {right}", *(f"{name}: {was.get(name)} != {now.get(name)}" for name in differ)]


@pytest.fixture
def segment(bench: "Callable[..., Bench]") -> "Callable[..., Bench]":
    """Make a bench of SACs on one segment, past their cold start: ``segment(32)`` has ``s4`` to ``s35`` with
    those addresses on ``bus0``, and a tap ``bus0.master``. ``baud`` is the line's, ``first`` the first
    address, 4 to 255."""

    def make(nodes: int, *, baud: int = 38400, first: int = 4, seed: int = 0) -> "Bench":
        if nodes < 1 or first < 4 or first + nodes > 256:
            raise ValueError(f"{nodes} nodes from address {first} on do not fit: addresses are 4 to 255")
        names = {f"s{address}": address for address in range(first, first + nodes)}
        wire = {"stations": list(names), "taps": {"master": {"port": "memory"}}, "baud": baud}
        devices = {name: {"profile": NODE} for name in names}
        made = bench({"bench": "nodes", "devices": devices, "segments": {"bus0": wire}}, seed)
        made.run(ms=COLD_START_MS)
        for line in (b"$CM%d\r", b"$Cn" + str(baud).encode() + b"\r", b"$R\r"):
            for name, address in names.items():
                made.port(name).write(line % address if b"%" in line else line)
            made.run(ms=100)
        for name in names:
            made.port(name).read()
        made.tap("bus0.master").read()
        return made

    return make


@pytest.fixture
def fault() -> "Iterator[Callable[..., FaultFace]]":
    """Inject faults until the test's end: ``fault(b, "packet_no_ack", "s4.network", rate=0.5)``."""
    made: list[FaultFace] = []

    def inject(bench: "Bench", kind: str, target: str, **parameters: float | str) -> "FaultFace":
        made.append(bench.fault(kind, target, **parameters))
        return made[-1]

    yield inject
    for each in reversed(made):
        each.clear()
