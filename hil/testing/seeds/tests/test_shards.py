"""``pytest --hil-shard`` and ``hil seeds merge``: all pieces, none twice, and what is missing is named."""

import json
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # --import-mode=importlib leaves it out

from hypothesis import given
from hypothesis import strategies as st
from seed_project import make_project, pytest_in

from hil.testing.seeds.seed_merge import merge
from hil.testing.seeds.seed_options import Shard
from hil.testing.seeds.seed_results import ResultsRefused, of_shard

SHARDS = 4


@given(st.lists(st.text("ab[]-:", max_size=5), unique=True), st.integers(1, 7), st.randoms())
def test_shards_have_all_pieces_and_none_twice_in_whatever_order(pieces, of, chance):
    parts = []
    for number in range(1, of + 1):
        chance.shuffle(pieces)
        parts.append(of_shard(pieces, Shard(number, of)))
    assert sorted(each for part in parts for each in part) == sorted(pieces)
    assert max(map(len, parts)) - min(map(len, parts)) <= 1


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """A run of four shards, one of them side by side, and the same run in one."""
    folder = make_project(tmp_path_factory.mktemp("seeds") / "project")
    for number in range(1, SHARDS + 1):
        also = ("-n", "2") if number == 2 else ()
        pytest_in(folder, "--hil-seeds", "30", "--hil-shard", f"{number}/{SHARDS}", *also, code=None)
    pytest_in(folder, "--hil-seeds", "30", "--hil-results", "whole.jsonl", code=1)
    return folder


def files(project) -> list[Path]:
    return [project / f"hil-results-{number}-of-{SHARDS}.jsonl" for number in range(1, SHARDS + 1)]


def known(result) -> tuple:
    return result.piece, result.seed, result.outcome, result.what, result.smallest, result.note


@pytest.mark.thorough
@pytest.mark.long
def test_shards_together_are_the_whole(project):
    shards, whole = merge(files(project)), merge([project / "whole.jsonl"])
    assert shards.problems == whole.problems == []
    assert len(shards.results) == 91
    assert [*map(known, shards.results)] == [*map(known, whole.results)]
    assert not shards.is_good
    text = shards.text()
    assert "test_line.py::test_without failed at 3 of 30 seeds: 3, 13, 23\n  it fails without faults" in text
    assert "91 results of 4 shards: " in text


@pytest.mark.long
def test_what_is_missing_or_twice_is_named(project, tmp_path):
    one, two, three, four = files(project)
    assert "shard 3 is missing" in merge([one, two, four]).problems
    twice = merge([one, two, three, four, three]).problems
    assert twice == [f"shard 3 is there twice: {three}, {three}"]
    lines = three.read_text().splitlines()
    cut = tmp_path / "cut.jsonl"
    cut.write_text("\n".join(lines[:6]) + "\n" + lines[6][:20])
    assert merge([one, two, cut, four]).problems == [f"shard 3 was killed after 5 results: {cut}"]
    end = json.loads(lines[-1]) | {"end": 5}
    cut.write_text("\n".join([*lines[:6], json.dumps(end)]))
    mine = end["mine"]
    assert merge([one, two, cut, four]).problems == [f"shard 3 ended early, with 5 of {mine} results: {cut}"]
    cut.write_text("\n".join([*lines[:-2], lines[1], lines[-1]]))
    assert merge([one, two, cut, four]).problems == [f"{json.loads(lines[1])['piece']} was run in two shards"]


@pytest.mark.thorough
@pytest.mark.long
def test_more_shards_than_tests_and_seeds_are_no_failure(tmp_path):
    project = make_project(tmp_path / "project")
    for number in range(1, 6):
        also = ("-n", "2") if number == 5 else ()
        of = ("--hil-seeds", "3", "-k", "test_seed", "--hil-shard", f"{number}/5")
        pytest_in(project, *of, *also)
    merged = merge([project / f"hil-results-{number}-of-5.jsonl" for number in range(1, 6)])
    assert (len(merged.results), merged.is_good) == (3, True)


@pytest.mark.long
def test_other_files_are_refused(project, tmp_path):
    other = make_project(tmp_path / "other")
    pytest_in(
        other, "--hil-seeds", "5", "--hil-shard", "2/4", "-k", "seed", "--hil-results", "o.jsonl", code=1
    )
    with pytest.raises(ResultsRefused, match="is of another run than"):
        merge([files(project)[0], other / "o.jsonl"])
    with pytest.raises(ResultsRefused, match="is of another run than"):
        merge([files(project)[0], project / "whole.jsonl"])
    for content, why in ((b"bench: t\n", "no file of results"), (b"", "no file of"), (b"\xff\n", "no text")):
        (tmp_path / "x").write_bytes(content)
        with pytest.raises(ResultsRefused, match=why):
            merge([tmp_path / "x"])
    (tmp_path / "x").write_text('{"format": "hil seeds 1", "shard": 1, "of": 1}\n{"no": 1}\n')
    with pytest.raises(ResultsRefused, match="a line is not as"):
        merge([tmp_path / "x"])


@pytest.mark.long
def test_all_results_are_in_the_xml(project):
    merged = merge(files(project))
    (suite,) = ET.fromstring(merged.junit())
    cases = suite.findall("testcase")
    assert suite.get("tests") == str(len(cases)) == "91"
    failures = [case for case in cases if case.find("failure") is not None]
    assert suite.get("failures") == str(len(failures)) == str(merged.count("failed"))
    assert "test_without[seed-3]" in {case.get("name") for case in failures}


@pytest.mark.thorough
@pytest.mark.long
def test_the_command_says_so_and_ends_with_1(project):
    import subprocess

    hil = [sys.executable, "-c", "from hil.cli.entry import main; main()", "seeds", "merge"]

    def run(*words, code):
        done = subprocess.run([*hil, *map(str, words)], capture_output=True, text=True, check=False)
        assert done.returncode == code, done.stderr
        return done.stdout + done.stderr

    assert "test_without failed at 3 of 30 seeds" in run(*files(project), code=1)
    assert "shard 2 is missing" in run(files(project)[0], code=1)
    answer = json.loads(run("--json", *files(project), code=1))
    assert answer["problems"] == []
    assert {each["seed"] for each in answer["failures"] if "without" in each["test"]} == {3, 13, 23}
    assert (
        "<testsuite "
        in (run(*files(project), "--junit", project / "j.xml", code=1) and "")
        + (project / "j.xml").read_text()
    )
    assert "o.jsonl: No such file" in run(project / "o.jsonl", code=2)
    pytest_in(project, "--hil-seeds", "3", "-k", "test_seed", "--hil-results", "good.jsonl")
    assert "3 results of 1 shard: 3 passed" in run(project / "good.jsonl", code=0)
