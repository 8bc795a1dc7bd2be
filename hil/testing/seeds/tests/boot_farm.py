"""A farm on three computers: a scheduler and two workers, each in a network namespace of its own, and one
that is killed while it works. For root: ``make test-system``."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # --import-mode=importlib leaves it out

from farm_support import READY_S, start_scheduler, start_worker
from seed_project import TESTS, make_project, pytest_in

pytest.importorskip("distributed")
SCHEDULER, ONE, TWO = "hil-farm-0", "hil-farm-1", "hil-farm-2"
HOST, PORT = "10.213.7.1", 8786
ADDRESS = f"tcp://{HOST}:{PORT}"
SLOW = (
    TESTS
    + """

def test_slow(bench):
    import time
    time.sleep(0.1)
    assert bench(LINE).seed != 7
"""
)


def ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True, capture_output=True)


def within(space: str) -> list[str]:
    return ["ip", "netns", "exec", space]


@pytest.fixture
def spaces() -> Iterator[None]:
    """Three namespaces that are joined by a bridge in the first, and this one."""
    if os.geteuid():
        pytest.skip("network namespaces are for root")
    try:
        ip("netns", "add", SCHEDULER)
    except (OSError, subprocess.CalledProcessError) as error:
        pytest.skip(f"no network namespaces here: {error}")
    try:
        ip("-n", SCHEDULER, "link", "add", "bridge", "type", "bridge")
        ip("-n", SCHEDULER, "address", "add", f"{HOST}/24", "dev", "bridge")
        ip("-n", SCHEDULER, "link", "set", "bridge", "up")
        for number, space in ((1, ONE), (2, TWO), (3, "")):
            end = f"hil-farm-v{number}"
            ip("link", "add", end, "type", "veth", "peer", "name", "port", "netns", SCHEDULER)
            ip("-n", SCHEDULER, "link", "set", "port", "name", f"port{number}", "master", "bridge", "up")
            at: list[str] = []
            if space:
                ip("netns", "add", space)
                ip("link", "set", end, "netns", space)
                at = ["-n", space]
            ip(*at, "address", "add", f"10.213.7.{number + 1}/24", "dev", end)
            ip(*at, "link", "set", end, "up")
        for space in (SCHEDULER, ONE, TWO):
            ip("-n", space, "link", "set", "lo", "up")
        yield
    finally:
        for space in (ONE, TWO, SCHEDULER):
            subprocess.run(["ip", "netns", "del", space], check=False, capture_output=True)
        subprocess.run(["ip", "link", "del", "hil-farm-v3"], check=False, capture_output=True)


def results(file: Path) -> list[dict]:
    if not file.exists():
        return []
    return [row for line in file.read_text().splitlines() if "piece" in (row := json.loads(line))]


def runs_of(worker: subprocess.Popen) -> list[int]:
    """Processes of pytest that a worker has now."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((path / "stat").read_text().rpartition(")")[2].split()[1])
            if parent == worker.pid and b"farm_process" in (path / "cmdline").read_bytes():
                found.append(int(path.name))
        except OSError:  # it has ended meanwhile
            continue
    return found


def test_a_worker_is_killed_and_nothing_is_lost_or_twice(spaces, tmp_path):
    project = make_project(tmp_path / "project", SLOW)
    pytest_in(project, "--hil-seeds", "100", "--hil-results", "here.jsonl", code=1)
    made = [start_scheduler(tmp_path, HOST, PORT, within(SCHEDULER))]
    try:
        one = start_worker(tmp_path, "one", ADDRESS, within(ONE), "--host", "10.213.7.2")
        two = start_worker(tmp_path, "two", ADDRESS, within(TWO), "--host", "10.213.7.3")
        made += [one, two]
        assert len(two_spaces(one, two)) == 2
        command = ["--hil-seeds", "100", "--hil-farm", ADDRESS, "--hil-results", "farm.jsonl"]
        with begun(project, *command) as running:
            deadline = time.monotonic() + 3 * READY_S
            while not (len(results(project / "farm.jsonl")) > 20 and runs_of(two.process)):
                assert running.poll() is None, running.communicate()
                assert time.monotonic() < deadline, results(project / "farm.jsonl")
                time.sleep(0.05)
            orphans = runs_of(two.process)
            two.kill()
            said = running.communicate(timeout=300)[0]
            assert running.returncode == 1, said
    finally:
        for each in made:
            each.kill()
    assert not [pid for pid in orphans if Path(f"/proc/{pid}").exists()]
    here, there = results(project / "here.jsonl"), results(project / "farm.jsonl")
    assert len(there) == len({each["piece"] for each in there}) == len(here) == 401

    def known(rows: list[dict]) -> list[str]:
        return sorted(str({**row, "duration_s": 0}) for row in rows)

    assert known(there) == known(here)
    assert "test_slow failed at 1 of 100 seeds: 7\n" in said
    log = (tmp_path / "scheduler.log").read_text()
    assert "Remove worker" in log


def two_spaces(*workers) -> set[str]:
    return {os.readlink(f"/proc/{each.process.pid}/ns/net") for each in workers}


def begun(project: Path, *options: str) -> subprocess.Popen:
    env = os.environ | {
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
    }
    plugins = ("-p", "hil.testing.plugin", "-p", "no:cacheprovider", "--rootdir", ".")
    command = [sys.executable, "-m", "pytest", "-q", *plugins, *options]
    return subprocess.Popen(
        command, env=env, cwd=project, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
