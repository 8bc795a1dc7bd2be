"""Bench that a command line means by a device on it, where several run."""

from collections.abc import Iterator
from typing import Any

import pytest

from hil.cli.framework import named_bench
from hil.cli.framework.command_answers import begin, note_names


class Bench:
    def __init__(self, name: str) -> None:
        self.name = self.socket = self.folder = name


PARTS = {"a": {"m1", "s1"}, "b": {"m1", "x9", "bus0"}}
BENCHES: Any = [Bench("a"), Bench("b")]


@pytest.fixture(autouse=True)
def _benches(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    begin(None)
    monkeypatch.setattr(named_bench, "parts_of", lambda bench: PARTS[bench.name])
    yield
    begin(None)


@pytest.mark.parametrize(
    ("given", "bench"),
    [
        ({"device": "x9"}, "b"),
        ({"device": "x9.e"}, "b"),
        ({"axes": ["s1", "m1"]}, "a"),
        ({"sources": ("bus0",)}, "b"),
        ({"lines": ["bus0.master"]}, "b"),
    ],
)
def test_a_name_of_one_bench_alone_chooses_it_once(
    given: dict[str, Any], bench: str, capsys: pytest.CaptureFixture[str]
) -> None:
    note_names(given)
    for said in (f": on bench {bench}\n", ""):
        chosen, why = named_bench.bench_of_names(BENCHES)
        assert (chosen and chosen.name, why) == (bench, "")
        assert capsys.readouterr().err.endswith(said)


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({}, "several benches are running (a, b): choose one with --bench"),
        ({"device": "m1"}, "; a and b have m1"),
        ({"device": "q"}, ", and none has q: choose one with --bench"),
        ({"axes": ["s1", "x9"]}, ", and none has s1, x9: choose one with --bench"),
        ({"line": "/dev/ttyUSB0"}, ": choose one with --bench"),
    ],
)
def test_other_names_choose_none(given: dict[str, Any], why: str) -> None:
    note_names(given)
    chosen, said = named_bench.bench_of_names(BENCHES)
    assert chosen is None
    assert said.endswith(why)
