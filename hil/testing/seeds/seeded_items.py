"""Tests at seeds: an item of pytest for each test and seed, run again with fewer faults where it fails."""

import gc
from collections.abc import Generator, Iterable, Sequence
from typing import Any, NamedTuple

import pytest
from _pytest.runner import runtestprotocol  # as plugins have it that run tests again

from hil.testing.seeds.seed_results import digest, of_shard
from hil.testing.seeds.seed_run import PARAMETER, RUN, AskedFault, SeedRun, SeedSettings, parts_of
from hil.testing.seeds.smallest_faults import find_smallest


class Failure(NamedTuple):
    """By which a failure is the same: part of the test, type of the error, line of the test's file."""

    when: str
    error: str
    line: int


FAILURE = pytest.StashKey[Failure | None]()


class SeededItems:
    """Hooks where tests run: in the only process, or in one of many."""

    def __init__(self, settings: SeedSettings) -> None:
        self._settings = settings
        self._ids = [f"seed-{seed}" for seed in settings.seeds or ()]
        self._found: dict[str, list[tuple[AskedFault, ...]]] = {}
        """Smallest sets that were found so far, by tests."""
        self.pieces: list[str] = []
        """All pieces of the run, of which a shard has some."""
        self.mine = 0

    @pytest.hookimpl(trylast=True)
    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """Make an item for each seed of a test that takes ``bench``."""
        if self._settings.seeds and PARAMETER in metafunc.fixturenames:
            metafunc.parametrize(PARAMETER, self._settings.seeds, ids=self._ids)

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, config: pytest.Config, items: list[pytest.Item]) -> None:
        """Leave to other shards what is theirs."""
        self.pieces = [item.nodeid for item in items]
        if self._settings.shard.of > 1:
            mine = set(of_shard(self.pieces, self._settings.shard))
            config.hook.pytest_deselected(items=[item for item in items if item.nodeid not in mine])
            items[:] = [item for item in items if item.nodeid in mine]
        self.mine = len(items)

    def pytest_collection_finish(self) -> None:
        """Keep the garbage collector from going through thousands of items again and again, for a fifth of
        the time: they stay to the end."""
        if self._settings.seeds:
            gc.collect()
            gc.freeze()

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Tell xdist's controller, which has no items, of what this is a part."""
        gc.unfreeze()
        if (output := getattr(session.config, "workeroutput", None)) is not None:
            output["hil_run"] = self.run_told()

    def run_told(self) -> list[Any]:
        """Number of all pieces, their mark, and the number of those of this shard."""
        return [len(self.pieces), digest(self.pieces), self.mine]

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        """Note by which a failure is known again."""
        report = yield
        if report.failed and not item.stash.get(FAILURE, None):
            item.stash[FAILURE] = _failure(item, call)
        return report

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
        """Run a test at its seed, and search for the smallest set of faults if it fails."""
        if parts_of(item.nodeid)[1] is None:
            return None
        hook = item.ihook
        hook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        reports = _run(item, nextitem)
        failed = next((report for report in reports if report.failed), None)
        if failed and not item.config.getoption("usepdb", False):
            told = self._search(item, nextitem)
            failed.__dict__["hil_smallest"] = told  # goes with the report to another process
        for report in reports:
            hook.pytest_runtest_logreport(report=report)
        hook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
        return True

    def _search(self, item: pytest.Item, nextitem: pytest.Item | None) -> dict[str, Any]:
        first, run = item.stash[FAILURE], item.stash.get(RUN, None)
        if first is None or run is None:
            return {"note": "its bench was not made"}
        asked = list(dict.fromkeys(run.asked))
        if not asked:
            return {"smallest": [], "faults": 0}

        def fails(some: Sequence[AskedFault]) -> bool:
            return _fails_again(item, nextitem, run, first, frozenset(asked).difference(some))

        if not fails(asked):
            note = "it did not fail again at this seed: it depends on more than its seed"
            return {"faults": len(asked), "note": note}
        found_before = self._found.setdefault(parts_of(item.nodeid)[0], [])
        smallest = find_smallest(asked, fails, found_before)
        faults = tuple(each for each in asked if each in smallest.faults)
        if faults not in found_before:
            found_before.append(faults)
        note = "" if smallest.is_proved else f"the search ended after {smallest.tries} runs"
        return {"smallest": [str(each) for each in faults], "faults": len(asked), "note": note}


def _run(item: pytest.Item, nextitem: pytest.Item | None) -> list[pytest.TestReport]:
    item.stash[FAILURE] = None
    return runtestprotocol(item, log=False, nextitem=nextitem)


def _fails_again(
    item: pytest.Item,
    nextitem: pytest.Item | None,
    run: SeedRun,
    first: Failure,
    left_out: Iterable[AskedFault],
) -> bool:
    run.begin(frozenset(left_out))
    _run(item, nextitem)
    return item.stash[FAILURE] == first


def _failure(item: pytest.Item, call: pytest.CallInfo[None]) -> Failure:
    if call.excinfo is None:
        return Failure(call.when, "", 0)  # it passed, and should not have
    own = [entry.lineno for entry in call.excinfo.traceback if entry.path == item.path]
    return Failure(call.when, call.excinfo.typename, own[-1] if own else 0)
