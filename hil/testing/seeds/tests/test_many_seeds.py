"""``pytest --hil-seeds``: items, what is told of failures, the smallest set of faults, and repetition."""

import json
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # --import-mode=importlib leaves it out

from seed_project import make_project, pytest_in

pytestmark = pytest.mark.long


@pytest.fixture
def project(tmp_path):
    return make_project(tmp_path / "project")


def rows(project: Path, name: str = "r.jsonl") -> list[dict]:
    return [json.loads(line) for line in (project / name).read_text().splitlines()]


@pytest.mark.thorough
def test_each_seed_that_fails_is_told_with_its_smallest_set(project):
    said = pytest_in(project, "--hil-seeds", "60", "--hil-results", "r.jsonl", code=1)
    head, *results, end = rows(project)
    assert head["shard"] == head["of"] == 1
    assert (end["end"], end["pieces"], end["mine"]) == (181, 181, 181)
    failed = [each for each in results if each["outcome"] == "failed"]
    without = [each["seed"] for each in failed if "without" in each["test"]]
    assert without == [3, 13, 23, 33, 43, 53]
    answers = [each for each in failed if "answer" in each["test"]]
    assert 1 <= len(answers) <= 15
    assert all(each["smallest"] == ["byte_flip at s1"] and each["faults"] == 4 for each in answers)
    seeds = ", ".join(str(each["seed"]) for each in answers)
    assert f"test_line.py::test_answer failed at {len(answers)} of 60 seeds: {seeds}\n" in said
    assert f"smallest set of faults: byte_flip at s1; 1 of 4 faults (at {seeds})" in said
    assert "test_line.py::test_without failed at 6 of 60 seeds: 3, 13, 23, 33, 43, 53\n" in said
    assert "it fails without faults (at 3, 13, 23, 33, 43, 53)" in said
    assert f"3 tests at seeds: 180 runs, {len(failed)} failed" in said
    # One report for each test, and one line of it; not one for each seed.
    assert said.count("assert b.seed % 10 != 3") == 1
    assert said.count("FAILED ") == 2
    assert f"{len(failed)} failed, {181 - len(failed)} passed" in said
    first = answers[0]["seed"]
    again = f"test_line.py::test_answer[seed-{first}]"
    assert f"again: pytest '{again}' --hil-seed {first}\n" in said
    assert "1 failed" in pytest_in(project, again, "--hil-seed", str(first), code=1)
    assert "1 failed" in pytest_in(project, again, "--hil-seeds", "60", code=1)


@pytest.mark.thorough
def test_the_same_seed_gives_the_same_bytes_in_each_way_to_run(project):
    def sent(*options: str, hash_seed: str = "random") -> list[str]:
        (project / "bytes.txt").unlink(missing_ok=True)
        pytest_in(project, "-k", "answer", *options, code=1, hash_seed=hash_seed)
        return sorted(set((project / "bytes.txt").read_text().splitlines()))

    alone = sent("--hil-seeds", "60", hash_seed="0")
    assert len(alone) >= 60
    assert sent("--hil-seeds", "60", hash_seed="1") == alone
    assert sent("--hil-seeds", "60", "-n", "2") == alone


@pytest.mark.thorough
def test_side_by_side_the_same_is_told(project):
    alone = pytest_in(project, "--hil-seeds", "40", "--hil-results", "r.jsonl", code=1)
    beside = pytest_in(project, "--hil-seeds", "40", "--hil-results", "b.jsonl", "-n", "2", code=1)
    told = "= hil seeds ="
    assert (
        beside[beside.index(told) :].rpartition(" in ")[0] == alone[alone.index(told) :].rpartition(" in ")[0]
    )
    for name in ("r.jsonl", "b.jsonl"):
        assert rows(project, name)[:1] == rows(project)[:1]

    def known(name):
        return sorted(str({k: v for k, v in row.items() if k != "duration_s"}) for row in rows(project, name))

    assert known("r.jsonl") == known("b.jsonl")


def test_without_the_option_nothing_changes(project):
    said = pytest_in(project)
    assert "4 passed" in said
    assert "seed" not in said


@pytest.mark.thorough
def test_a_range_of_seeds_and_a_window_of_arrival(project):
    said = pytest_in(
        project, "--hil-seeds", "100..119", "--hil-arrival-window", "2ms", "-k", "test_seed", "-vv"
    )
    assert "test_seed[seed-100]" in said
    assert "test_seed[seed-119]" in said
    assert "20 passed" in said
    test = f"def test_w(bench):\n    assert bench({CELL!r}).arrivals.window_ms == 2\n"
    (project / "test_line.py").write_text(test)
    assert "1 passed" in pytest_in(project, "--hil-arrival-window", "2ms")


CELL = {"bench": "t", "devices": {"m1": {"profile": "mechaduino"}}}

FLAKY = f"""
import itertools
runs = itertools.count()


def test_flaky(bench):
    b = bench({CELL!r})
    b.fault("byte_flip", "m1", rate=0.1)
    b.fault("byte_drop", "m1", rate=0.1)
    assert next(runs) != 4


def test_all(bench):
    one, two = bench({CELL!r}), bench({CELL!r}, seed=5)
    for b in (one, two):
        b.fault("shaft_jam", "m1")
        b.fault("encoder_slip", "m1", counts=5)
        b.fault("encoder_slip", "m1", counts=7)
    assert not ([*one.runtime.faults.active] and "encoder_slip" in [
        fault.kind for fault in two.runtime.faults.active.values() if fault.parameters.get("counts") == 7])


def test_other_error(bench):
    b = bench({CELL!r})
    b.fault("byte_flip", "m1", rate=0.1)
    assert not b.runtime.faults.active
    raise RuntimeError("without it, something else is wrong")
"""


def test_sets_of_more_faults_and_failures_that_are_not_again(tmp_path):
    project = make_project(tmp_path / "project", FLAKY)
    said = pytest_in(project, "--hil-seeds", "10", code=1)
    assert (
        "test_flaky failed at 1 of 10 seeds: 4\n  it did not fail again at this seed: it depends on" in said
    )
    assert "test_all failed at 10 of 10 seeds: 0, 1, 2, 3, 4, 5, 6, 7, 8, 9\n" in said
    assert "faults: encoder_slip at m1, no. 2, encoder_slip at m1, no. 2 of bench 2; 2 of 6 faults" in said
    assert "test_other_error failed at 10 of 10 seeds" in said
    assert "faults: byte_flip at m1; 1 of 1 fault (at" in said


def test_the_first_failure_ends_the_run_early(project):
    said = pytest_in(project, "--hil-seeds", "60", "-x", "-k", "without", code=1)
    assert "1 failed, 3 passed" in said


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("options", "why"),
    [
        (["--hil-seeds", "0"], "--hil-seeds: '0' has no seeds; at least one is needed"),
        (["--hil-seeds", "abc"], "--hil-seeds: seeds are a number of them, as 1000, or from..to"),
        (["--hil-seed", "x"], "--hil-seed: a seed is a whole number, as 17; not 'x'"),
        (["--hil-seeds", "10", "--hil-seed", "10"], "--hil-seed 10 is not among the seeds of --hil-seeds"),
        (["--hil-shard", "5/4"], "--hil-shard: there is no shard 5/4: they are 1/4 to 4/4"),
        (["--hil=live", "--hil-seeds", "3"], "seeds and windows of arrival are of benches in memory"),
        (["--hil-arrival-window", "2"], "--hil-arrival-window: a window of arrival is a time with its unit"),
    ],
)
def test_mistakes_are_told_before_anything_runs(project, options, why):
    said = pytest_in(project, *options, code=4)
    assert f"ERROR: {why}" in said
    assert "Traceback" not in said
