"""Kind of bench that a run of pytest has, and an account of tests that ask for what it cannot do."""

from collections.abc import Mapping
from typing import Any

import pytest

from hil.testing.unsupported import RAISED, UnsupportedHere

VIRTUAL, LIVE = "virtual", "live"
REAL_BOARDS = pytest.StashKey[Any]()
"""``RealBoards`` of this run, if a file was given."""
IN_MEMORY, PORT_KEYS = "memory", ("port", "network", "kind")
"""Kind of ports that the test kit alone has, and the keys of a configuration that name a kind."""
SKIPPED, PASSED_OVER = "hil_unsupported", "hil_passed_over"
"""Attributes of reports: the reason why a test was skipped, and the last one that it has passed over."""


def kind_of(config: pytest.Config) -> str:
    """Kind of the fixture ``bench``, as it was given."""
    given: str = config.getoption("--hil", VIRTUAL)
    return given


def account(item: pytest.Item, call: pytest.CallInfo[Any], report: pytest.TestReport) -> None:
    """Let a test be skipped that has asked for what its bench cannot do, and note if it went on instead."""
    error = call.excinfo.value if call.excinfo else None
    if isinstance(error, UnsupportedHere) and call.when != "teardown":
        path, line, _ = item.reportinfo()
        report.outcome = "skipped"
        report.longrepr = str(path), (line or 0) + 1, f"Skipped: {error}"
        setattr(report, SKIPPED, str(error))
    elif call.when == "call" and report.passed and RAISED and kind_of(item.config) != VIRTUAL:
        setattr(report, PASSED_OVER, RAISED[-1])
    if call.when != "setup" or error:
        RAISED.clear()


def with_ptys(config: Any) -> Any:
    """Configuration that a dict is for a bench in real time, with ptys for ports in memory."""
    if not isinstance(config, Mapping):
        return config
    return {
        key: "pty" if value == IN_MEMORY and key in PORT_KEYS else with_ptys(value)
        for key, value in config.items()
    }
