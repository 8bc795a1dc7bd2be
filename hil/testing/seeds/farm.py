"""Seeds at the workers of a Dask scheduler: ``pytest --hil-farm tcp://scheduler:8786``.

Chunks of tests and seeds are tasks. A worker runs one in a process of its own, with the search for smallest
sets of faults; a task whose worker dies is run by another, and each result counts once.
"""

import re
import socket
import uuid
from collections.abc import Sequence
from typing import Any

import pytest
from distributed import Client, Event, as_completed

from hil.testing.seeds.farm_worker import SentProject, carry_out, versions
from hil.testing.seeds.seed_run import SeedSettings, parts_of
from hil.testing.seeds.sent_sources import SourcesRefused, mark_of, pack

ANSWER_S = 5
"""Time for the scheduler to answer in."""
WORKERS_S = 20
"""Time for a first worker to come in."""
CHUNKS_OF_A_THREAD = 4
"""Chunks for each thread of a worker: results come as the run goes on, and none waits long for the last."""
MOST_PIECES = 100
PLUGIN, MODULE = "hil", "hil.testing.plugin"
"""Name of the kit's plugin among entry points, and its module: by both names it would be there twice."""


class Farm:
    """Hooks of the process that hands seeds out; it has the terminal, and takes the results as its own."""

    def __init__(self, config: pytest.Config, settings: SeedSettings) -> None:
        self._config, self._settings = config, settings

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool | None:
        """Run tests at seeds at the farm, the others here."""
        if session.config.option.collectonly or session.testsfailed:
            return None
        here = [item for item in session.items if parts_of(item.nodeid)[1] is None]
        for item, following in zip(here, [*here[1:], None], strict=False):
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
            _end_early(session)
        seeded = {item.nodeid: item for item in session.items if parts_of(item.nodeid)[1] is not None}
        if seeded:
            FarmRun(self._config, session, seeded).run(self._settings.farm)
        return True


def _end_early(session: pytest.Session) -> None:
    if session.shouldfail:
        raise session.Failed(session.shouldfail)
    if session.shouldstop:
        raise session.Interrupted(session.shouldstop)


class FarmRun:
    """One run at a farm. ``items``: by their node ids."""

    def __init__(self, config: pytest.Config, session: pytest.Session, items: dict[str, pytest.Item]) -> None:
        self._config, self._session, self._items = config, session, items
        self._done = set[str]()

    def run(self, address: str) -> None:
        """Run all pieces; raises as pytest's own loop does."""
        try:
            packed = pack(self._config.rootpath)
        except SourcesRefused as error:
            raise pytest.UsageError(f"--hil-farm: {error}") from None
        client = client_of(address)
        try:
            _check_workers(client, address)
            self._hand_out(client, packed)
        finally:
            client.close()

    def _hand_out(self, client: Any, packed: bytes) -> None:
        run = f"hil-{uuid.uuid4().hex[:12]}"
        stop = Event(run, client=client)
        mark = mark_of(packed)
        client.register_plugin(SentProject(packed), name=f"hil-{mark}")
        futures = {}
        for number, chunk in enumerate(chunks([*self._items], sum(client.nthreads().values()))):
            of = mark, self._arguments(chunk), chunk, run
            futures[client.submit(carry_out, *of, key=f"{run}-{number}", pure=False)] = chunk
        try:
            for future in as_completed(futures, loop=client.loop):
                self._take(future, futures[future])
                _end_early(self._session)
        finally:
            stop.set()
            client.cancel([*futures], force=True)
        self._log_all([{"crashed": "no result came", "nodeid": each} for each in self._items])

    def _take(self, future: Any, chunk: Sequence[str]) -> None:
        if future.status == "finished":
            self._log_all(future.result())
        else:
            error = future.exception() if future.status == "error" else future.status
            why = f"no worker could run it: {type(error).__name__}: {error}"
            self._log_all([{"crashed": why, "nodeid": piece} for piece in chunk])

    def _log_all(self, told: Sequence[Any]) -> None:
        """Take the reports of pieces of which there are none so far."""
        by_piece: dict[str, list[Any]] = {}
        for each in told:
            by_piece.setdefault(each["nodeid"], []).append(each)
        for piece, reports in by_piece.items():
            if piece in self._items and piece not in self._done and not self._session.shouldfail:
                self._done.add(piece)
                self._log(self._items[piece], reports)

    def _log(self, item: pytest.Item, told: Sequence[Any]) -> None:
        hook = item.ihook
        hook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        for each in told:
            if "crashed" in each:
                report = crashed(item, each["crashed"])
            else:
                report = hook.pytest_report_from_serializable(config=self._config, data=each)
            hook.pytest_runtest_logreport(report=report)
        hook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)

    def _arguments(self, chunk: Sequence[str]) -> list[str]:
        """Arguments of pytest at a worker: those from here that change how a test runs."""
        option, root = self._config.option, self._config.rootpath
        seeds = [seed for piece in chunk if (seed := parts_of(piece)[1]) is not None]
        given = {
            "--hil-seeds": f"{min(seeds)}..{max(seeds)}",
            "--hil-arrival-window": option.hil_arrival_window,
            "--maxfail": option.maxfail or None,
            "--tb": option.tbstyle,
            "--import-mode": option.importmode,
        }
        words = [f"{name}={value}" for name, value in given.items() if value is not None]
        plugins = [PLUGIN, *(name for name in option.plugins or () if name != MODULE)]
        many = {"-p": plugins, "-o": option.override_ini, "-W": option.pythonwarnings}
        words += [word for name, values in many.items() for value in values or () for word in (name, value)]
        if (ini := self._config.inipath) and ini.is_relative_to(root):
            words += ["-c", str(ini.relative_to(root))]
        return [*words, "--rootdir=.", "-p", "no:cacheprovider", "-q"]


def chunks(pieces: Sequence[str], threads: int) -> list[list[str]]:
    """Divide pieces into tasks, small enough that all threads have work to the end."""
    size = max(1, min(MOST_PIECES, -(-len(pieces) // (max(threads, 1) * CHUNKS_OF_A_THREAD))))
    return [list(pieces[start : start + size]) for start in range(0, len(pieces), size)]


def crashed(item: pytest.Item, why: str) -> pytest.TestReport:
    """Report of a test whose process died, as xdist makes it."""
    return pytest.TestReport(item.nodeid, item.location, {}, "failed", why, "???")  # type: ignore[arg-type]


def client_of(address: str) -> Any:
    """Client of a scheduler.

    Raises:
        UsageError: none answers there.
    """
    found = re.fullmatch(r"(?:tcp|tls)://\[?([^/\s]+?)\]?:(\d{1,5})", address)
    if not found:
        raise pytest.UsageError(f"--hil-farm: an address is as in tcp://scheduler:8786, not {address!r}")
    try:
        socket.create_connection((found[1], int(found[2])), ANSWER_S).close()
        return Client(address, timeout=ANSWER_S, set_as_default=False)
    except (OSError, OverflowError) as error:
        raise pytest.UsageError(f"--hil-farm: no Dask scheduler answers at {address} ({error})") from None


def _check_workers(client: Any, address: str) -> None:
    try:
        client.wait_for_workers(1, timeout=WORKERS_S)
    except TimeoutError:
        why = f"{address} has no workers, and none came within {WORKERS_S} s"
        raise pytest.UsageError(f"--hil-farm: {why}; start one: dask worker {address}") from None
    ours = versions()
    for worker, theirs in client.run(versions, on_error="return").items():
        if not isinstance(theirs, dict):
            why = f"the worker at {worker} cannot run tests ({type(theirs).__name__}: {theirs})"
            raise pytest.UsageError(f"--hil-farm: {why}; install hil-motion[testing,farm] there")
        if other := [name for name in ours if ours[name] != theirs.get(name)]:
            said = ", ".join(f"{name} {theirs.get(name)}, not {ours[name]}" for name in other)
            raise pytest.UsageError(f"--hil-farm: the worker at {worker} has {said}; install the same there")
