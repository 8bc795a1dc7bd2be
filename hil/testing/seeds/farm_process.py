"""Main module of a process at a worker of a farm: pytest on some pieces, with a line for each report."""

import json
import os
import sys
import threading
from typing import Any, TextIO

import pytest


class TellsReports:
    """Plugin of pytest that writes reports for another process."""

    def __init__(self, file: TextIO) -> None:
        self._file = file
        self._config: pytest.Config | None = None

    def pytest_configure(self, config: pytest.Config) -> None:
        """Take the configuration, by which reports are written."""
        self._config = config

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        """Say which test begins: if the process dies, it was in this one."""
        self._tell({"began": nodeid})

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Write a report at once."""
        assert self._config
        hook = self._config.hook
        self._tell(hook.pytest_report_to_serializable(config=self._config, report=report))

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        """Say which test has ended."""
        self._tell({"ended": nodeid})

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Say why a file cannot be collected here."""
        if report.failed:
            sys.stderr.write(report.longreprtext + "\n")

    def end(self) -> None:
        """Say that nothing more comes."""
        self._tell({"end": True})

    def _tell(self, what: Any) -> None:
        self._file.write(json.dumps(what, default=repr) + "\n")
        self._file.flush()


def main() -> None:
    """Read from standard input what to run; its end is the end of this process."""
    arguments, pieces = json.loads(sys.stdin.readline())
    with os.fdopen(os.dup(1), "w") as file:
        os.dup2(2, 1)  # what pytest and the tests print is no report
        threading.Thread(target=_end_with_input, daemon=True).start()
        tells = TellsReports(file)
        code = pytest.main([*arguments, *pieces], plugins=[tells])
        if code in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED, pytest.ExitCode.INTERRUPTED):
            tells.end()
    sys.exit(int(code))


def _end_with_input() -> None:
    os.read(0, 1)
    os._exit(1)


if __name__ == "__main__":
    main()
