"""Tables on narrow terminals: what is to be copied is whole."""

from typing import Any

import pytest

from hil.cli.bench.views import device_table, doctor_view, status_view
from hil.cli.framework.consoles import long_lines
from hil.cli.tests.test_axis_views import SERVO, status
from hil.host.doctor import Diagnosis

NAME = "spindle_of_the_machine_in_the_left_corner"
PATH = f"/run/user/1000/hil/{NAME}/{NAME}"
URL = "rfc2217://lab-computer-4.workshop.example.org:7001"


def listed() -> dict[str, Any]:
    row = {"device": NAME, "profile": "mechaduino", "hardware": "0.1", "port": "pty", "address": PATH}
    network = {"kind": "rfc2217", "address": URL, "clients": 2}
    row |= {"clients": 0, "ports": {f"{NAME}.network": network}, "failed": None}
    taps = [{"tap": f"{NAME}.master", "kind": "tcp", "port": PATH, "clients": 0}]
    return {"bench": NAME, "pid": 7, "devices": [row], "taps": taps, "nodes": []}


@pytest.mark.parametrize("columns", ["20", "60"])
def test_names_paths_and_addresses_are_whole(
    columns: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", columns)
    console = long_lines()
    console.print(device_table(listed()))
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"bench {NAME} (process 7)"
    assert [line.split() for line in lines[2:]] == [
        [NAME, "mechaduino", "0.1", "pty", PATH, "0"],
        [f"{NAME}.network", "rfc2217", URL, "2"],
        [f"{NAME}.master", "tap", "tcp", PATH, "0"],
    ]
    console.print(status_view(status(**{NAME: SERVO})))
    assert f" {NAME} " in capsys.readouterr().out
    console.print(doctor_view([Diagnosis(NAME, "ok", PATH, "", "")]))
    assert capsys.readouterr().out.splitlines()[1].split() == ["ok", NAME, PATH]
