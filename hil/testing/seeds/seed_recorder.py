"""Results of tests at seeds, collected in the process that tells them: summary, and a file."""

from collections.abc import Generator
from typing import Any

import pytest

from hil.testing.seeds.seed_results import FAILED, PASSED, SKIPPED, ResultsFile, SeedResult
from hil.testing.seeds.seed_run import SeedSettings, parts_of
from hil.testing.seeds.seed_summary import summary


class SeedRecorder:
    """Hooks of the process that has the terminal."""

    def __init__(self, config: pytest.Config, settings: SeedSettings) -> None:
        self._config, self._settings = config, settings
        self._reports: dict[str, list[pytest.TestReport]] = {}
        self._results: dict[str, SeedResult] = {}
        self._told: list[Any] | None = None
        self._file = ResultsFile(settings.results, settings.shard) if settings.results else None

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Collect the reports of a test; the last one ends it."""
        parts = self._reports.setdefault(report.nodeid, [])
        parts.append(report)
        if report.when not in ("setup", "call") and report.nodeid not in self._results:
            result = _result(report.nodeid, parts)
            self._results[report.nodeid] = result
            if self._file:
                self._file.add(result)
            if result.outcome != FAILED:
                del self._reports[report.nodeid]

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any, error: object) -> None:
        """Learn from a worker of xdist of what this is a part."""
        self._told = getattr(node, "workeroutput", {}).get("hil_run") or self._told

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session, exitstatus: int) -> None:
        """Write the end of the file. A shard that has nothing to do, as there are more of them than tests and
        seeds, is no failure."""
        items = self._config.pluginmanager.get_plugin("hil-seeded-items")
        told = self._told or (items and items.pieces and items.run_told()) or None
        if self._file:
            self._file.close(told)
        if exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED and told and self._settings.shard.of > 1:
            session.exitstatus = pytest.ExitCode.OK

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_terminal_summary(self, terminalreporter: Any) -> Generator[None, None, None]:
        """Show the report of one seed of each test that failed, and a summary of all."""
        stats = terminalreporter.stats
        whole = {kind: stats[kind] for kind in ("failed", "error") if kind in stats}
        for kind, reports in whole.items():
            stats[kind] = _first_of_each(reports)
        yield
        stats.update(whole)
        if self._settings.seeds:
            terminalreporter.section("hil seeds")
            for line in summary(self._results.values()):
                terminalreporter.write_line(line)


def _first_of_each(reports: list[pytest.TestReport]) -> list[pytest.TestReport]:
    """Report of the first seed of each test; in the order in which they came."""
    first: dict[str, tuple[int, pytest.TestReport]] = {}
    for report in reports:
        test, seed = parts_of(report.nodeid)
        key = test if seed is not None else f"{test} {report.when}"
        if key not in first or (seed is not None and seed < first[key][0]):
            first[key] = seed or 0, report
    kept = {id(report) for _, report in first.values()}
    return [report for report in reports if id(report) in kept]


def _result(node_id: str, reports: list[pytest.TestReport]) -> SeedResult:
    failed = next((each for each in reports if each.failed), None)
    skipped = any(each.skipped for each in reports)
    test, seed = parts_of(node_id)
    told: dict[str, Any] = getattr(failed, "hil_smallest", {})
    smallest = told.get("smallest")
    return SeedResult(
        node_id,
        test,
        seed,
        FAILED if failed else SKIPPED if skipped else PASSED,
        what=_line_of(failed) if failed else "",
        smallest=None if smallest is None else tuple(smallest),
        faults=told.get("faults", 0),
        note=told.get("note", ""),
        duration_s=round(sum(each.duration for each in reports), 6),
    )


def _line_of(report: pytest.TestReport) -> str:
    """Error of a report in a line."""
    crash = getattr(report.longrepr, "reprcrash", None)
    lines = (crash.message if crash else report.longreprtext).splitlines()
    return next((line.strip() for line in lines if line.strip()), "")
