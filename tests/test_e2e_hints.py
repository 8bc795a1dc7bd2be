"""Command lines that hil prints work where they are pasted, whatever else runs here."""

import os
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from e2e_support import HIL, PATIENCE_S, Place, Server, config

from hil.cli.framework.command_answers import all_pasteable, begin, pasteable
from hil.cli.framework.command_group import app
from hil.net.benches_here import Found, Here


@pytest.fixture(scope="module")
def benches() -> Iterator[tuple[Place, Server, Server]]:
    """The bench t alone at first, then u beside it, whose port is one of Telnet."""
    with Place() as place:
        first = place.serve(config())
        telnet = {"m1": {"port": "rfc2217", "baud": 9600}, "d1": {"profile": "modbus_drive", "port": None}}
        devices: dict[str, dict[str, Any]] = {**telnet, "s1": {"profile": "sac", "flash": {}}}
        yield place, first.ready(), place.serve(config("u", devices=devices), bench="u").ready("m1")


def pasted(place: Place, line: str, typed: str = "") -> subprocess.CompletedProcess[str]:
    """Carry a line out in a shell that knows nothing of the benches' folder."""
    path = f"{Path(HIL).parent}:{os.environ['PATH']}"
    env = {"PATH": path, "HOME": str(place.folder), "XDG_RUNTIME_DIR": str(place.folder)}
    return subprocess.run(
        ["sh", "-c", line], env=env, input=typed, capture_output=True, text=True, timeout=PATIENCE_S
    )


def test_what_serve_prints(benches: tuple[Place, Server, Server]) -> None:
    place, first, second = benches
    assert f"hil --runtime-dir {place.runtime} monitor m1\n" in first.output
    monitor = next(line for line in second.output.splitlines() if line.endswith(" monitor m1"))
    assert monitor.endswith(f" --runtime-dir {place.runtime} -b u monitor m1")
    told = pasted(place, monitor.replace(HIL, "hil"), "p")  # a port of RFC 2217
    assert "Angle" in told.stdout, told
    axis = re.search("without a serial port; (.*)", second.output)
    assert axis
    assert "move_abs" in pasted(place, axis[1]).stdout.replace("-", "_")


def test_what_errors_and_tables_name(benches: tuple[Place, Server, Server]) -> None:
    place, *_ = benches
    said = place.cli("monitor", "d1", "-b", "u", code=1)
    found = re.search("`(.*)`", said)
    assert found
    assert pasted(place, found[1]).returncode == 0
    assert f"`hil --runtime-dir {place.runtime} -b u axis s1`" in place.cli(
        "step", "s1", "9", "-b", "u", code=1
    )


def test_only_what_asks_a_bench_has_options() -> None:
    begin(typer.main.get_command(app))
    words = ["-b", "u"]
    text = (
        "`hil reset m1`, `hil doctor`, `hil zenoh keys`, `hil fault kinds`, `hil fault list`, `hil -b x list`"
    )
    assert pasteable(text, words) == text.replace("hil reset", "hil -b u reset").replace(
        "hil fault", "hil -b u fault"
    )
    assert pasteable(text, []) == text
    row = {"failed": "see `hil run list`", "clients": 0, "ports": [None, "`hil status`"]}
    assert all_pasteable(row, words) == {
        "failed": "see `hil -b u run list`", "clients": 0, "ports": [None, "`hil -b u status`"]
    }  # fmt: skip


def test_options_are_those_that_are_needed() -> None:
    def bench(base: str, name: str) -> Here:
        return Here(Path(base, name, "control.sock"), 0, base == "/run/hil")

    one, two, service = bench("/r", "one"), bench("/r", "two"), bench("/run/hil", "two")
    alone, both, alike = Found([one], []), Found([one, two], []), Found([one, two, service], [])
    assert alone.options(one.folder, None, {}) == []
    assert alone.options(one.folder, Path("/r"), {}) == ["--runtime-dir", "/r"]
    assert both.options(one.folder, None, {}) == ["-b", "one"]
    assert both.options(one.folder, None, {"HIL_BENCH": "one"}) == []
    assert both.options(one.folder, None, {"HIL_BENCH": "two"}) == ["-b", "one"]
    assert alone.options(one.folder, None, {"HIL_BENCH": "two"}) == ["-b", "one"]
    assert alike.options(service.folder, None, {}) == ["-b", "service:two"]
    assert alike.options(two.folder, None, {}) == ["-b", "/r/two"]
    assert alone.options(two.folder, None, {}) == ["-b", "/r/two"]
