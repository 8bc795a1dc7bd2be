"""Settings of all tests: of hypothesis, the order of their files, and a check that hil makes no input that a
replay would refuse."""

import os
from contextlib import suppress
from pathlib import Path

import pytest

with suppress(ImportError):  # a user's tests in a folder of the clone need the kit alone
    from hypothesis import HealthCheck, settings

    # How long an example takes says what else this machine does.
    settings.register_profile("hil", deadline=None, suppress_health_check=[HealthCheck.too_slow])
    settings.load_profile("hil")

with suppress(ImportError):
    from hil.sim.bench import BenchRuntime
    from hil.sim.input_check import assert_taken_back

    BenchRuntime.check_input = staticmethod(assert_taken_back)
    os.environ["HIL_CHECK_INPUTS"] = "1"  # for daemons

with suppress(ImportError):
    from hil.host import process

    process.POLITE = 0  # `hil export` runs in this process, too, and would slow down all that comes later

MOST_SECOND_TRIES = 10
"""Number of tests that may need a second try in one run (decision 48)."""


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fail a run in which too many tests needed a second try: what they wait for has become late."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    again = reporter.stats.get("rerun", []) if reporter else []
    if len(again) > MOST_SECOND_TRIES and not session.exitstatus:
        reporter.write_line(f"\n{len(again)} tests needed a second try; {MOST_SECOND_TRIES} may.", red=True)
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


END_TO_END = "test_e2e_"
END_TO_END_SHARE = 0.75
"""Share of a test run within which all end-to-end files begin: the last minutes have short files only."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Spread the end-to-end files, which wait, among the files that compute, so that both cores have work."""
    files = list(dict.fromkeys(item.path for item in items))
    waiting = [file for file in files if file.name.startswith(END_TO_END)]
    computing = [file for file in files if not file.name.startswith(END_TO_END)]
    begins: dict[Path, float] = {}
    for share, some in ((END_TO_END_SHARE, waiting), (1.0, computing)):
        begins.update({file: share * number / len(some) for number, file in enumerate(some)})
    items.sort(key=lambda item: begins[item.path])
