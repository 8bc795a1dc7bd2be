"""Options and hooks of pytest for many seeds; the test kit's plugin brings them."""

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import pytest

from hil.testing.seeds.seed_options import WHOLE, one_seed, seeds_given, shard_given, window_given
from hil.testing.seeds.seed_run import SETTINGS, SeedSettings

Read = TypeVar("Read")
_OPTIONS = (
    ("--hil-seeds", "N", "run each test that takes bench with N seeds, 0 to N-1, or with those of A..B"),
    ("--hil-seed", "SEED", "run each test that takes bench with this seed alone"),
    ("--hil-arrival-window", "TIME", "let bytes that tests write arrive within this time, as 2ms, by chance"),
    (
        "--hil-shard",
        "K/N",
        "run the Kth of N parts, as 3/40, and write its results, for hil seeds merge",
    ),
    (
        "--hil-results",
        "FILE",
        "write a line of JSON for each result; default of a shard: hil-results-K-of-N.jsonl",
    ),
    ("--hil-farm", "ADDRESS", "run seeds at the workers of a Dask scheduler, as tcp://scheduler:8786"),
)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options of seeds."""
    for name, metavar, text in _OPTIONS:
        parser.getgroup("hil").addoption(name, metavar=metavar, help=text)


@pytest.fixture
def hil_seed() -> int:
    """Seed of this run of the test: of ``--hil-seeds`` one after the other; 0 without."""
    return 0


def pytest_configure(config: pytest.Config) -> None:
    """Read the options, and take part where there is one."""
    settings = _settings(config)
    config.stash[SETTINGS] = settings
    is_worker = hasattr(config, "workerinput")
    if settings.seeds or settings.results or settings.shard.of > 1:
        from hil.testing.seeds.seeded_items import SeededItems

        config.pluginmanager.register(SeededItems(settings), "hil-seeded-items")
        if settings.farm and not is_worker:
            try:
                from hil.testing.seeds.farm import Farm
            except ModuleNotFoundError as error:
                why = f"--hil-farm needs the extra farm: pip install 'hil-motion[farm]' ({error})"
                raise pytest.UsageError(why) from None

            config.pluginmanager.register(Farm(config, settings), "hil-farm")
        if not is_worker:
            from hil.testing.seeds.seed_recorder import SeedRecorder

            config.pluginmanager.register(SeedRecorder(config, settings), "hil-seed-recorder")


def _settings(config: pytest.Config) -> SeedSettings:
    many, one = _read(config, "--hil-seeds", seeds_given), _read(config, "--hil-seed", one_seed)
    if many and one and one[0] not in many:
        raise pytest.UsageError(f"--hil-seed {one[0]} is not among the seeds of --hil-seeds")
    shard = _read(config, "--hil-shard", shard_given)
    results = config.getoption("--hil-results", None)
    if shard and not results:
        results = f"hil-results-{shard.number}-of-{shard.of}.jsonl"
    settings = SeedSettings(
        one or many,
        _read(config, "--hil-arrival-window", window_given) or 0.0,
        shard or WHOLE,
        config.invocation_params.dir / Path(results) if results else None,
        config.getoption("--hil-farm", None) or "",
    )
    if settings.farm and not settings.seeds:
        raise pytest.UsageError("--hil-farm runs tests at many seeds: say how many with --hil-seeds")
    if settings.farm and config.getoption("numprocesses", None):
        raise pytest.UsageError("--hil-farm and -n are two ways to run side by side: leave one out")
    kind = config.getoption("--hil", None)
    if kind and kind != "virtual" and (settings.seeds or settings.window_ms):
        raise pytest.UsageError(
            f"seeds and windows of arrival are of benches in memory: --hil={kind} knows no chance that could"
            " be drawn again; leave --hil-seeds, --hil-seed and --hil-arrival-window out"
        )
    return settings


def _read(config: pytest.Config, name: str, read: Callable[[str], Read]) -> Read | None:
    given = config.getoption(name, None)  # none for a plugin that is loaded late
    if given is None:
        return None
    try:
        return read(given)
    except ValueError as error:
        raise pytest.UsageError(f"{name}: {error}") from None
