"""Pytest plugin of the option ``--hil``, the kind of bench that tests get, and of what that kind cannot do at
the end of a run."""

from collections import Counter
from typing import Any

import pytest

from hil.testing.kind_account import LIVE, PASSED_OVER, REAL_BOARDS, SKIPPED, VIRTUAL, kind_of
from hil.vocab.near_words import did_you_mean, nearest


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option."""
    parser.getgroup("hil").addoption(
        "--hil",
        metavar="KIND",
        default=VIRTUAL,
        help="benches of the fixture `bench`: `virtual`, in memory, the default; `live`, each in a process in"
        " real time; or the file of a configuration whose devices have `at:`, which are real boards then",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Read the option. Raises UsageError: there is no such kind, or the file has problems."""
    given = config.getoption("--hil", VIRTUAL)  # none for a plugin that is loaded late
    if given in (VIRTUAL, LIVE):
        return
    from hil.config import ConfigError
    from hil.testing.real_boards import RealBoards

    path = config.invocation_params.dir / given
    if not path.is_file():
        meant = did_you_mean(nearest(given, (VIRTUAL, LIVE)))
        there = "write virtual, live, or the file of a configuration whose devices have at:"
        said = " ".join(filter(None, (meant, there)))
        raise pytest.UsageError(f"--hil={given}: {said}; it was looked for at {path}")
    try:
        config.stash[REAL_BOARDS] = RealBoards(path)
    except (ConfigError, ValueError) as error:
        raise pytest.UsageError(f"--hil={given}:\n{error}") from None


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Tell how many tests this kind of bench could not do, and why."""
    given = kind_of(config)
    for outcome, attribute, what in (
        ("skipped", SKIPPED, "skipped"),
        ("passed", PASSED_OVER, "passed in spite of a refusal"),
    ):
        reports = terminalreporter.stats.get(outcome, [])
        reasons = Counter(getattr(each, attribute) for each in reports if hasattr(each, attribute))
        if total := reasons.total():
            tests = "1 test" if total == 1 else f"{total} tests"
            terminalreporter.write_line(f"hil: {tests} {what} at --hil={given}:")
            for reason, count in reasons.most_common():
                terminalreporter.write_line(f"  {count}: {reason}")
