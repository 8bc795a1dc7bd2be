"""`hil list --prometheus`: the file of targets, from what benches tell."""

import json
from pathlib import Path
from typing import Any

import pytest

from hil.cli.lab.prometheus_targets import NoTargets, read_targets, targets, write_targets


def row(bench: str, metrics: str, host: str = "lab1", **labels: str) -> dict[str, Any]:
    return {"bench": bench, "metrics": metrics, "host": host, "labels": labels}


def test_each_bench_has_an_entry_with_its_labels() -> None:
    rows = [
        row("mill", "http://0.0.0.0:9464/metrics", rig="press", **{"on-floor": "2"}),
        row("lathe", "http://10.0.0.7:9000/metrics", "lab2"),
        row("here", "http://127.0.0.1:1/metrics", "desk"),
        row("six", "http://[fd00::1]:9464/metrics"),
    ]
    made = targets(rows, [], "desk")
    assert [entry["targets"] for entry in made.entries] == [
        *(["127.0.0.1:1"], ["10.0.0.7:9000"], ["lab1:9464"], ["[fd00::1]:9464"])
    ]
    assert made.entries[2]["labels"] == {
        "bench": "mill",
        "host": "lab1",
        "label_rig": "press",
        "label_on_floor": "2",
    }
    assert made.remarks == []


def test_one_that_cannot_be_reached_is_said() -> None:
    made = targets([row("a", ""), row("b", "http://127.0.0.1:9464/metrics")], [], "desk")
    assert made.entries == []
    assert "bridges: {metrics: {}}" in made.remarks[0]
    assert made.remarks[1].startswith("b: its metrics are at 127.0.0.1:9464 of lab1 alone")


def test_one_that_is_away_keeps_its_entry() -> None:
    before = targets([row("mill", "http://lab1:9464/metrics"), row("a", "http://lab2:1/metrics")], [], "desk")
    silent = {"bench": "mill", "devices": {}, "why": "it does not answer"}
    after = targets([silent, row("a", "http://lab2:2/metrics")], before.entries, "desk")
    assert [entry["targets"] for entry in after.entries] == [["lab2:2"], ["lab1:9464"]]


def test_the_file_is_read_again_and_anothers_is_not_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "benches.json"
    assert read_targets(path) == []
    entries = targets([row("mill", "http://lab1:9464/metrics")], [], "desk").entries
    write_targets(path, entries)
    assert read_targets(path) == entries
    for other in ("{}", "no JSON", json.dumps([{"targets": ["x"]}])):
        path.write_text(other)
        with pytest.raises(NoTargets, match="no file of targets"):
            read_targets(path)
