"""The dashboard and the alerts in ``packaging``: expressions name metrics and labels that a bench has."""

import json
import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from hil.discovery.named_kinds import find_wire_infos
from hil.operations.metrics import metric_rows

PACKAGING = Path(__file__).parents[1] / "packaging"
DASHBOARD = PACKAGING / "grafana" / "hil-lab.json"
PROMETHEUS = PACKAGING / "prometheus"
OF_TARGETS = {"job", "instance", "bench", "host"}
"""Labels that Prometheus and its discovery give each series."""
METRICS = {metric.name: metric for metric, _ in metric_rows(find_wire_infos())}
_SELECTOR = re.compile(r"\b((?:hil|process)_\w+|up)\b(?:\{([^}]*)\})?")
_GROUPED = re.compile(r"\b(?:by|on|without|ignoring) \(([^)]*)\)")
needs_promtool = pytest.mark.skipif(not shutil.which("promtool"), reason="no promtool here (apt: prometheus)")


def panels() -> list[dict[str, Any]]:
    read: list[dict[str, Any]] = json.loads(DASHBOARD.read_text())["panels"]
    return read


def of_dashboard() -> Iterator[str]:
    for panel in panels():
        for target in panel.get("targets", ()):
            yield target["expr"]


def rules() -> list[dict[str, Any]]:
    (group,) = yaml.safe_load((PROMETHEUS / "hil-alerts.yaml").read_text())["groups"]
    found: list[dict[str, Any]] = group["rules"]
    return found


EXPRESSIONS = [*of_dashboard(), *(rule["expr"] for rule in rules())]


def labels_of(name: str) -> set[str]:
    """Labels of a series. KeyError: a bench has none of this name."""
    if name == "up":
        return OF_TARGETS
    for end in ("_bucket", "_sum", "_count"):
        metric = METRICS.get(name.removesuffix(end))
        if metric and metric.kind == "histogram":
            return {*metric.labels, *OF_TARGETS, "le"}
    return {*METRICS[name].labels, *OF_TARGETS}


@pytest.mark.parametrize("expression", EXPRESSIONS)
def test_an_expression_names_what_a_bench_exports(expression: str) -> None:
    selectors = _SELECTOR.findall(expression)
    assert selectors
    there = set[str]()
    for name, matchers in selectors:
        labels = labels_of(name)
        there |= labels
        asked = set(re.findall(r"(\w+)\s*(?:=~|!~|!=|=)", matchers))
        assert asked <= labels, f"{name} has no {asked - labels}"
    for names in _GROUPED.findall(expression):
        assert {each.strip() for each in names.split(",")} <= there, expression


def test_a_series_that_is_not_there_is_found() -> None:
    with pytest.raises(KeyError):
        labels_of("hil_nothing")


def test_the_dashboard_has_a_panel_for_each_question() -> None:
    titles = [panel["title"] for panel in panels() if panel["type"] == "row"]
    assert titles == ["Health", "Lateness", "Faults and runs", "People and programs", "Computers"]
    numbers = [panel["id"] for panel in panels()]
    assert len(numbers) == len(set(numbers))
    for panel in panels():
        assert panel["type"] == "row" or (panel["description"] and panel["targets"])
        for target in panel.get("targets", ()):
            assert set(re.findall(r"\{\{(\w+)\}\}", target["legendFormat"])) <= {"user", *LEGENDS}


LEGENDS = {"bench", "bridge", "device", "kind", "level", "outcome", "state"}


def test_each_alert_says_what_to_do_and_is_tried() -> None:
    tried = (PROMETHEUS / "hil-alerts-test.yaml").read_text()
    for rule in rules():
        assert set(rule["annotations"]) == {"summary", "remedy"}
        assert f"alertname: {rule['alert']}" in tried


def promtool(folder: Path, *words: str) -> None:
    done = subprocess.run(["promtool", *words], cwd=folder, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr


@needs_promtool
def test_promtool_takes_the_alerts_and_the_example(tmp_path: Path) -> None:
    for path in PROMETHEUS.iterdir():
        shutil.copy(path, tmp_path)
    (tmp_path / "benches.json").write_text("[]")
    promtool(tmp_path, "test", "rules", "hil-alerts-test.yaml")
    promtool(tmp_path, "check", "config", "prometheus.yaml")


@needs_promtool
def test_promtool_parses_each_expression_of_the_dashboard(tmp_path: Path) -> None:
    expressions = [each.replace("$bench", ".*") for each in of_dashboard()]
    named = [{"record": f"panel:{number}", "expr": each} for number, each in enumerate(expressions)]
    (tmp_path / "panels.yaml").write_text(yaml.safe_dump({"groups": [{"name": "panels", "rules": named}]}))
    promtool(tmp_path, "check", "rules", "panels.yaml")
