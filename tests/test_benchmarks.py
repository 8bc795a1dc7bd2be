"""Benchmarks check what they time: a figure is that of the work which its text describes."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"
CHECKS = re.compile(r"\b(check_work\(|assert (?!\w+\.std)|raise (SystemExit|RuntimeError|TimeoutError))")
OF_A_DAEMON_AT_REST = {"idle_cpu", "memory"}
"""Benchmarks of a daemon that does nothing: there is no work to count."""


@pytest.mark.parametrize("path", sorted(BENCHMARKS.glob("[a-z]*.py")), ids=lambda path: path.stem)
def test_a_benchmark_counts_its_work(path):
    checks = re.search(
        r"\b(check_work\(|assert (?!\w+\.std)|raise (SystemExit|RuntimeError|TimeoutError))", path.read_text()
    )
    assert bool(checks) != (path.stem in OF_A_DAEMON_AT_REST)


def ended(done, expected, tolerance):
    code = f"from _report import check_work; check_work('pulses', {done}, {expected}, {tolerance})"
    return subprocess.run([sys.executable, "-c", code], cwd=BENCHMARKS, capture_output=True, text=True)


@pytest.mark.parametrize("done", [95, 105, 0])
def test_other_work_ends_a_benchmark(done):
    told = ended(done, 100, 0.04)
    assert told.returncode == 1
    assert told.stderr == f"pulses: {done} instead of 100: a figure would be that of other work\n"


def test_the_work_that_is_meant_goes_on():
    assert ended(97, 100, 0.04).returncode == 0


FIGURE = {"name": "x", "benchmark": "x.py", "is_quick": False, "value": 1.0, "unit": "s", "reference": 1.0}
"""A figure as a benchmark reports it, without its ratio and its goal."""


def table(folder, *arguments):
    """Run the table on figures of a folder of its own."""
    code = (
        f"import sys, _table; from pathlib import Path; _table.RESULTS = Path({str(folder)!r});"
        f"_table.RUN = _table.RESULTS / 'run.json'; _table.PAGE = _table.RESULTS / 'page.md';"
        f"sys.argv = ['_table.py', *{arguments!r}]; _table.main()"
    )
    return subprocess.run([sys.executable, "-c", code], cwd=BENCHMARKS, capture_output=True, text=True)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("ratio", "limit", "extra", "verdict"),
    [
        (0.9, 1.0, {}, "met"),
        (1.0001, 1.0, {}, "within noise"),
        (1.0001, 1.0, {"exact": True}, "MISSED"),
        (5.0, 1.0, {}, "MISSED"),
        (5.0, None, {}, ""),
    ],
)
def test_the_table_says_what_holds(tmp_path, ratio, limit, extra, verdict):
    assert table(tmp_path, "begin").returncode == 0
    figure = FIGURE | {"ratio": ratio, "limit_ratio": limit, "extra": extra}
    (tmp_path / "x.json").write_text(json.dumps(figure))
    ended = table(tmp_path, "end")
    assert ended.returncode == (verdict == "MISSED")
    line, last = ended.stdout.splitlines()[-2:]
    assert line.endswith(verdict)
    is_missed = verdict == "MISSED"
    assert last == f"{int(is_missed)} of 1 figures missed their goals" + " x" * is_missed


def test_the_page_has_the_table_of_the_last_run(tmp_path):
    (tmp_path / "page.md").write_text("before\n<!-- figures: written by `make bench-docs` -->\nold\n"
                                      "<!-- end of the figures -->\nafter\n")  # fmt: skip
    assert table(tmp_path, "docs").stderr == "there are no figures: run `make bench` first\n"
    table(tmp_path, "begin")
    figure = FIGURE | {"ratio": 1.0, "limit_ratio": 2.0, "extra": {}}
    (tmp_path / "x.json").write_text(json.dumps(figure))
    assert table(tmp_path, "docs").returncode == 0
    page = (tmp_path / "page.md").read_text()
    assert "| `x` | 1 s | 1 s | 1 | <= 2 | met |\n" in page
    assert page.startswith("before\n")
    assert page.endswith("after\n")
    assert "old" not in page
    assert "noise" in page
    assert "load" in page


def test_figures_of_earlier_runs_are_forgotten(tmp_path):
    (tmp_path / "old.json").write_text("{}")
    table(tmp_path, "begin")
    assert [path.name for path in tmp_path.glob("*.json")] == ["run.json"]
