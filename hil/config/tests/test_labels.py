"""Labels of a bench: words, each mistake with its place."""

import pytest

from hil.compose import find_catalogue
from hil.config import ConfigError, parse
from hil.config.diff import diff
from hil.vocab.bench_labels import has_labels, is_label_value, wanted_label

DEVICES = "devices:\n  m1: {profile: sac}\n"


def test_each_wrong_label_has_its_place() -> None:
    text = 'bench: b\nlabels:\n  rig: two words\n  floor: 2\n  Bad: x\n  long: "' + 64 * "x" + '"\n' + DEVICES
    with pytest.raises(ConfigError) as caught:
        parse(text, "b.yaml", find_catalogue())
    said = str(caught.value)
    for place, why in (
        ("b.yaml:3:8", "labels.rig: this is no label (a label is one word"),
        ("b.yaml:4:10", 'write it in quotes: "2"'),
        ("b.yaml:5:3", '"Bad" is not a name'),
        ("b.yaml:6:9", "labels.long: this is no label"),
    ):
        assert any(line.startswith(place) and why in line for line in said.splitlines()), said


def test_labels_are_exchanged_while_the_bench_runs() -> None:
    old, new = (
        parse(f"bench: b\nlabels: {{rig: {rig}}}\n{DEVICES}", "b.yaml", find_catalogue())
        for rig in ("press", "lift")
    )
    assert new.labels == {"rig": "lift"}
    assert {change.action for change in diff(old, new)} == {"keep"}


@pytest.mark.parametrize("value", ["2", "press", "hall/3", "v1.2-rc", "a:b_c", 63 * "x"])
def test_words_that_are_labels(value: str) -> None:
    assert is_label_value(value)
    assert wanted_label(f"rig={value}") == ("rig", value)


@pytest.mark.parametrize("text", ["", "rig", "rig=", "=press", "rig=two words", "rig=\n", "rig=" + 64 * "x"])
def test_words_that_choose_nothing_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match="NAME=VALUE"):
        wanted_label(text)


def test_a_bench_has_to_have_all_labels() -> None:
    labels = {"rig": "press", "floor": "2"}
    assert has_labels(labels, {})
    assert has_labels(labels, {"rig": "press", "floor": "2"})
    assert not has_labels(labels, {"rig": "press", "floor": "3"})
    assert not has_labels({}, {"rig": "press"})
