"""``pytest --hil-farm``: the same results as here, processes that die, an early end, and mistakes."""

import json
import socket
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # --import-mode=importlib leaves it out

from farm_support import start_scheduler, start_worker
from seed_project import make_project, pytest_in

from hil.testing.seeds.farm import chunks
from hil.testing.seeds.seed_merge import merge

distributed = pytest.importorskip("distributed")
DIES = """
import os

CELL = {"bench": "t", "devices": {"m1": {"profile": "mechaduino"}}}


def test_dies(bench):
    if bench(CELL).seed in (3, 17):
        os.kill(os.getpid(), 9)


def test_lives(bench):
    assert bench(CELL).seed != 5
"""


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port: int = listener.getsockname()[1]
        return port


@pytest.fixture(scope="module")
def farm(tmp_path_factory):
    """A scheduler with two workers here; its address."""
    folder, port = tmp_path_factory.mktemp("farm"), free_port()
    address = f"tcp://127.0.0.1:{port}"
    made = [start_scheduler(folder, "127.0.0.1", port)]
    try:
        made += [start_worker(folder, name, address) for name in ("one", "two")]
        yield address
    finally:
        for each in made:
            each.kill()


def known(file: Path) -> list[str]:
    """Results of a file without their durations."""
    rows = [json.loads(line) for line in file.read_text().splitlines()]
    return sorted(str({name: row[name] for name in row if name != "duration_s"}) for row in rows)


@pytest.mark.thorough
@pytest.mark.long
def test_a_farm_has_the_results_of_one_computer(farm, tmp_path):
    project = make_project(tmp_path / "project")
    pytest_in(project, "--hil-seeds", "60", "--hil-results", "here.jsonl", code=1)
    said = pytest_in(project, "--hil-seeds", "60", "--hil-farm", farm, "--hil-results", "farm.jsonl", code=1)
    assert known(project / "farm.jsonl") == known(project / "here.jsonl")
    assert "test_line.py::test_without failed at 6 of 60 seeds: 3, 13, 23, 33, 43, 53\n" in said
    assert "smallest set of faults: byte_flip at s1; 1 of 4 faults" in said
    assert said.count("assert b.seed % 10 != 3") == 1


@pytest.mark.thorough
@pytest.mark.long
def test_all_workers_have_work(farm, tmp_path):
    name = "def test_who(bench):\n    open(f'{FILE}-{os.getppid()}', 'w').close()\n"
    project = make_project(tmp_path / "project", f"import os\nFILE = {str(tmp_path / 'by')!r}\n{name}")
    pytest_in(project, "--hil-seeds", "40", "--hil-farm", farm)
    assert len([*tmp_path.glob("by-*")]) == 2


@pytest.mark.thorough
@pytest.mark.long
def test_a_test_that_kills_its_process_is_named_and_the_others_run(farm, tmp_path):
    project = make_project(tmp_path / "project", DIES)
    said = pytest_in(project, "--hil-seeds", "20", "--hil-farm", farm, "--hil-results", "r.jsonl", code=1)
    assert "test_line.py::test_dies failed at 2 of 20 seeds: 3, 17\n" in said
    assert "the process that ran it ended with -9" in said
    assert "test_line.py::test_lives failed at 1 of 20 seeds: 5\n" in said
    assert len(merge([project / "r.jsonl"]).results) == 40


@pytest.mark.thorough
@pytest.mark.long
def test_the_first_failure_ends_the_run_at_the_farm(farm, tmp_path):
    project = make_project(tmp_path / "project")
    options = ("--hil-seeds", "400", "-k", "without", "-x", "--hil-results", "r.jsonl")
    said = pytest_in(project, *options, "--hil-farm", farm, code=1)
    assert "stopping after 1 failures" in said
    assert len(merge([project / "r.jsonl"]).results) < 200


@pytest.mark.thorough
@pytest.mark.long
def test_a_file_that_cannot_be_imported_there_is_said(farm, tmp_path):
    here = f"import os\nassert os.getcwd() == {str(tmp_path / 'project')!r}, 'only there'\n"
    tests = "def test_a(bench):\n    pass\n"
    project = make_project(tmp_path / "project", here + tests)
    said = pytest_in(project, "--hil-seeds", "3", "--hil-farm", farm, code=1)
    assert "test_line.py::test_a failed at 3 of 3 seeds: 0, 1, 2\n" in said
    assert "only there" in said


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("options", "why"),
    [
        (["--hil-farm", "tcp://127.0.0.1:1"], "--hil-farm runs tests at many seeds: say how many with"),
        (["--hil-farm", "x", "--hil-seeds", "3", "-n", "2"], "--hil-farm and -n are two ways"),
        (
            ["--hil-farm", "tcp://127.0.0.1:1", "--hil-seeds", "3"],
            "no Dask scheduler answers at tcp://127.0.0.1:1 ([Errno 111] Connection refused)",
        ),
        (["--hil-farm", "tcp://127.0.0.1:99999", "--hil-seeds", "3"], "no Dask scheduler answers at"),
        (["--hil-farm", "tcp://no.such.host.invalid:1", "--hil-seeds", "3"], "no Dask scheduler answers at"),
        (["--hil-farm", "there", "--hil-seeds", "3"], "as in tcp://scheduler:8786, not 'there'"),
    ],
)
def test_mistakes_are_told(tmp_path, options, why):
    project = make_project(tmp_path / "project", "def test_a(bench):\n    pass\n")
    said = pytest_in(project, *options, code=4)
    assert "ERROR: --hil-farm" in said
    assert why in said
    assert "Traceback" not in said


def test_chunks_have_all_pieces_once():
    for count, threads in ((1, 1), (7, 2), (100, 3), (5000, 2), (12, 100)):
        pieces = [f"p{number}" for number in range(count)]
        made = chunks(pieces, threads)
        assert [each for chunk in made for each in chunk] == pieces
        assert max(map(len, made)) <= 100
        assert len(made) >= min(count, threads * 2)
