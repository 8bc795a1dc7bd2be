"""`hil fault kinds`: every kind is in a group, with what it shows and an example that is taken."""

import json
import shlex
from typing import Any

import pytest
from typer.testing import CliRunner

from hil.cli.boards.axis_command import number_or_text
from hil.cli.framework.command_group import app
from hil.testing import LiveError, live
from hil.vocab.fault_words import GROUPS, SIGNS, example, group_of
from hil.vocab.faults import FAULT_KINDS, TIMING, FaultKind
from hil.vocab.parameters import filled

KINDS = list(FAULT_KINDS.values())


def hil(*words: str) -> Any:
    return CliRunner().invoke(app, words)


@pytest.fixture(autouse=True)
def _no_bench(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))


@pytest.mark.parametrize("kind", KINDS, ids=[kind.name for kind in KINDS])
def test_a_kind_has_all_its_words(kind: FaultKind) -> None:
    assert group_of(kind) in GROUPS
    shown = hil("fault", "kinds", kind.name).output
    for words in (kind.about, SIGNS[kind.name], example(kind), *(each.about for each in kind.parameters)):
        assert words in shown
    _, _, _, name, _, *values = shlex.split(example(kind))
    given = {each.partition("=")[0]: number_or_text(each.partition("=")[2]) for each in values}
    assert name == kind.name
    assert filled(kind.name, (*kind.parameters, *TIMING), given)[1] == {}


def test_tables_of_words_have_no_other_kinds() -> None:
    assert SIGNS.keys() == FAULT_KINDS.keys()
    assert {group_of(kind) for kind in KINDS} == {*GROUPS}


def test_the_overview_has_each_kind_once_below_its_group() -> None:
    lines = hil("fault", "kinds").output.splitlines()
    names = [line.split()[0] for line in lines if line.startswith(" ")]
    expected = [
        word
        for group in GROUPS
        for word in (f"{group}:", *(kind.name for kind in KINDS if group_of(kind) == group))
    ]
    assert names == expected


def test_a_group_and_json() -> None:
    rows = json.loads(hil("fault", "kinds", "encoder", "--json").output)
    assert [row["kind"] for row in rows] == [k.name for k in KINDS if group_of(k) == "encoder"]
    one = json.loads(hil("fault", "kinds", "wire_cut", "--json").output)
    assert one["parameters"].keys() == {each.name for each in TIMING}


def test_a_slip_is_named() -> None:
    wrong = hil("fault", "kinds", "byte_dorp")
    assert wrong.exit_code == 2
    assert 'did you mean "byte_drop"?' in wrong.output


CONFIG = {
    "bench": "t",
    "devices": {"m1": {"profile": "mechaduino"}, "s1": {"profile": "sac"}, "s2": {"profile": "sac"}},
    "segments": {"bus0": {"stations": ["s1", "s2"]}},
}


@pytest.mark.long
def test_at_a_bench() -> None:
    """Kinds that fit a kind of board, a fault that ends by itself, and the addresses at which nodes are."""
    with live(CONFIG) as bench:
        of_board, of_place = (
            {row["kind"] for row in json.loads(bench.hil("fault", "kinds", name, "--json"))}
            for name in ("sac", "s1")
        )
        assert "shaft_jam" in of_place < of_board
        assert "encoder_slip" not in of_board
        bench.hil("fault", "inject", "shaft_jam", "s1", "--for", "20min")
        bench.hil("fault", "inject", "shaft_jam", "s2", "for=1500s")
        rows = json.loads(bench.hil("fault", "list", "--json"))
        assert [row["parameters"]["for_s"] for row in rows] == [1200.0, 1500.0]
        with pytest.raises(LiveError, match="for_s is given twice"):
            bench.hil("fault", "inject", "shaft_jam", "s1", "for=900s", "--for", "1s")
        bench.hil("sac", "command", "$CM7", "$R", "--device", "s2")
        here = [{"node": f"s{each}.network", "id": at, "bus": "bus0"} for each, at in ((1, 85), (2, 7))]
        bench.wait_until(lambda: json.loads(bench.hil("list", "--json"))[0]["nodes"] == here)
        assert "node 7 on bus0" in bench.hil("list")
