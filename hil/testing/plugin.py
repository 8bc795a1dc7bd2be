"""Pytest plugin: the fixtures ``bench``, ``live_bench``, ``segment``, ``canbus``, ``drive`` and ``fault``; a
test that fails while live benches run has their logs and traffic in its report."""

import sys
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from hil.testing.bench import Bench
    from hil.testing.can_faces import CanBusFace, DriveFace
    from hil.testing.faces import FaultFace
    from hil.testing.given import GivenConfig
    from hil.testing.served_bench import ServedBench

NODE = "sac"
COLD_START_MS = 1100


@pytest.fixture
def bench() -> "Iterator[Callable[..., Bench]]":
    """Make benches that are closed after the test: ``bench("bench.yaml")``, ``bench({...}, seed=1)``."""
    from hil.config import ConfigError
    from hil.testing.bench import Bench

    made: list[Bench] = []

    def make(config: "GivenConfig", seed: int = 0) -> Bench:
        __tracebackhide__ = True
        try:
            made.append(Bench(config, seed))
        except ConfigError as error:
            raise error.with_traceback(None) from None
        return made[-1]

    yield make
    for each in made:
        each.close()


@pytest.fixture
def live_bench(tmp_path: Path) -> "Iterator[Callable[..., ServedBench]]":
    """Run benches in processes of their own, in real time, until the test's end: ``live_bench("bench.yaml")``
    answers when its boards do. Options as of ``hil.testing.live``. Logs and captures stay in ``tmp_path``."""
    from hil.testing.given import path_of
    from hil.testing.served_bench import LiveError, live

    with ExitStack() as stack:
        number = 0

        def run(config: "GivenConfig", **options: Any) -> "ServedBench":
            __tracebackhide__ = True
            nonlocal number
            path_of(config)  # refused here, without the frames of contexts
            number += 1
            keep = tmp_path / f"live_bench{number}"
            try:
                return stack.enter_context(live(config, **{"keep": keep} | options))
            except LiveError as error:
                raise error.with_traceback(None) from None

        yield run


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Add what live benches said and what passed over their lines to the report of a test that failed."""
    report = yield
    served = "hil.testing.served_bench"
    if report.failed and (module := sys.modules.get(served)):  # noqa: TID251 -- most tests do without it
        for each in module.OPEN:
            try:
                report.sections += each.report()
            except (OSError, module.subprocess.SubprocessError) as error:  # the test's own failure is told
                report.sections.append(("hil", f"no report of a live bench: {error}"))
    return report


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
def canbus(bench: "Callable[..., Bench]") -> "Callable[..., CanBusFace]":
    """Make a bench of CANopen drives on one bus, and a node of the test's own beside them: ``canbus(4)`` has
    ``m1`` to ``m4`` with the node ids 1 to 4 on ``can0``, and ``.bench``. ``profile``: of all, ``bit_rate``:
    of the bus, ``switches``: of each, as the configuration has them."""

    def make(
        drives: int = 1,
        *,
        profile: str = "mechaduino",
        bit_rate: int = 1_000_000,
        first_id: int = 1,
        switches: Mapping[str, Any] | None = None,
        seed: int = 0,
    ) -> "CanBusFace":
        from hil.testing.can_faces import canbus_config

        config = canbus_config(drives, profile, bit_rate, first_id, switches or {})
        return bench(config, seed).canbus()

    return make


@pytest.fixture
def drive(canbus: "Callable[..., CanBusFace]") -> "Callable[..., DriveFace]":
    """Make a CANopen drive on a bus with a node of the test's own, as ``canbus``, past its board's start:
    ``drive()``, ``drive(profile="sac")``. Its axis is ``.canbus.bench.axis(drive.axis)``."""

    def make(**of: Any) -> "DriveFace":
        made = canbus(1, **of).drives()[0]
        made.await_ready()
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
