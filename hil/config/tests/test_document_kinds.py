"""Kinds of documents: each reader knows those of the others, and ``hil check`` takes all."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from hil.cli.framework.command_group import app
from hil.compose import find_catalogue
from hil.config import Catalogue, parse
from hil.config.document_kinds import KINDS, OtherKindError, kind_of
from hil.runs import parse_run
from hil.toolpath.machine import parse_machine

TEXTS = {
    "a bench's configuration": "bench: b\ndevices:\n  m1: {profile: mechaduino}\n",
    "a run": "axes: {m1: {}}\nrun: r\nsteps: [{dwell_s: 1}]\n",
    "a machine": "machine: mill\naxes:\n  x: {axis: m1, deg_per_mm: 9, min_mm: 0, max_mm: 9,"
    " velocity_mm_per_min: 60, acceleration_mm_per_s2: 9}\n",
    "a map of a Modbus drive": "modbus_map: 1\nposition_deg: {input: 0, type: i32}\n"
    "set_point_deg: {holding: 0, type: i32}\ncontrol: {enable: {coil: 0}, start: {coil: 1}}\n",
}


def read_map(text: str, file: str) -> object:
    maps = find_catalogue().maps
    assert maps
    return maps.read(text, file, None)


READERS = {
    "a bench's configuration": lambda text, file: parse(text, file, Catalogue({}, {})),
    "a run": parse_run,
    "a machine": parse_machine,
    "a map of a Modbus drive": read_map,
}


def test_the_kinds_are_told_apart() -> None:
    assert [kind.what for kind in KINDS] == [*TEXTS, "a board's profile"] == [*READERS, "a board's profile"]
    assert kind_of({"bench": "b", "devices": {}, "run": "left over"}) is KINDS[0]
    assert kind_of({"steps": []}) is KINDS[1]
    for unknown in (None, [], "text", {}, {"axes": {}}, {"bench": "b", "machine": "m"}):
        assert kind_of(unknown) is None


@pytest.mark.parametrize("given", TEXTS)
@pytest.mark.parametrize("wanted", READERS)
def test_each_reader_says_what_it_was_given(given: str, wanted: str) -> None:
    if given == wanted:
        return
    with pytest.raises(OtherKindError) as caught:
        READERS[wanted](TEXTS[given], "x.yaml")
    line = 2 if given == "a run" else 1
    said = str(caught.value)
    assert said.startswith(f"x.yaml:{line}:1: ")
    assert f": this is {given}, not {wanted} (`" in said
    assert "x.yaml" in said.split("`")[1]


@pytest.mark.parametrize(
    ("given", "said", "key"),
    [
        ("a bench's configuration", "bench b, 1 device, no problems", "bench"),
        ("a run", "run r, 1 step, no problems", "run"),
        ("a machine", "machine mill, axes X, no problems", "machine"),
        ("a map of a Modbus drive", "map of a Modbus drive, 2 values, no problems", "modbus_map"),
    ],
)
def test_hil_check_takes_all_four(tmp_path: Path, given: str, said: str, key: str) -> None:
    file = tmp_path / "x.yaml"
    file.write_text(TEXTS[given])
    done = CliRunner().invoke(app, ["check", str(file)])
    assert (done.exit_code, done.output) == (0, f"{file}: {said}\n")
    told = json.loads(CliRunner().invoke(app, ["check", str(file), "--json"]).output)
    assert key in told
    assert told["problems"] == []
    file.write_text(TEXTS[given] + "oddity: 1\n")
    wrong = CliRunner().invoke(app, ["check", str(file)], env={"COLUMNS": "200"})
    assert (wrong.exit_code, f"{file}:" in wrong.output, "oddity" in wrong.output) == (2, True, True)


def test_hil_serve_says_what_it_was_given(tmp_path: Path) -> None:
    file = tmp_path / "run.yaml"
    file.write_text(TEXTS["a run"])
    done = CliRunner().invoke(app, ["serve", str(file)])
    assert (done.exit_code, f"`hil run {file}` carries it out" in done.output) == (2, True)
