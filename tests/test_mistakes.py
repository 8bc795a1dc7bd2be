"""Mistakes of people at a command line: each gets what is wrong, where, and what to do, in one form."""

import re
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from e2e_support import Place
from typer.testing import CliRunner

from hil.cli.framework.command_group import app
from hil.cli.framework.exit_codes import Exit

DATA: dict[str, Any] = yaml.safe_load(Path(__file__).with_name("mistakes.yaml").read_text())
BENCH = """
bench: t
speed: 5
devices:
  m1: {profile: mechaduino, flash: {table: identity}}
  s1: {profile: sac}
  c1: {profile: canopen_drive}
  n1: {profile: uno}
segments: {bus0: {stations: [s1], taps: {master: {port: pty}}}}
can: {can0: {nodes: {c1: {id: 3}}}}
"""
REMEDY = re.compile(r"; |\([a-z`]|\? |: write ")
"""Beginnings of what to do."""


@pytest.fixture(scope="module")
def place() -> Iterator[Place]:
    with Place() as made:
        for name, text in DATA["files"].items():
            (made.folder / name).parent.mkdir(parents=True, exist_ok=True)
            made.write(text, name)
        made.serve(BENCH).ready()
        yield made


@pytest.mark.long
@pytest.mark.parametrize("row", DATA["mistakes"], ids=lambda row: row["run"])
def test_a_mistake_gets_what_where_and_what_to_do(
    place: Place, row: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    words = shlex.split(row["run"])
    if "--runtime-dir" not in words:
        words = ["--runtime-dir", str(place.runtime), *words]
    monkeypatch.chdir(place.folder)
    monkeypatch.setenv("XDG_STATE_HOME", str(place.folder))
    monkeypatch.setattr(sys, "argv", ["hil", *words])
    done = CliRunner().invoke(app, words)
    said = done.stderr.replace(f"--runtime-dir {place.runtime} ", "")
    assert (done.exit_code, done.stdout) == (row.get("code", Exit.MISTAKE), ""), (said, done.exception)
    assert said.startswith("hil: ")
    assert [part for part in row["says"] if part not in said] == [], said
    assert REMEDY.search(said), said
    assert not re.search(r"Traceback|Usage: (?!hil fault )|Error:|Errno", said), said


def test_there_are_enough_of_them() -> None:
    assert len(DATA["mistakes"]) >= 100
    assert len({row["run"] for row in DATA["mistakes"]}) == len(DATA["mistakes"])
