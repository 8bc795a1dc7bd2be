"""What `hil monitor` says first of a port that another program has open."""

from typing import Any

import pytest
from typer.testing import CliRunner

from hil.cli.boards import monitor
from hil.cli.framework.ask import BenchOptions
from hil.cli.framework.command_group import app


@pytest.mark.parametrize(
    ("address", "clients", "shares"),
    [
        ("/run/hil/t/m1", 1, True),
        ("/run/hil/t/m1", 0, False),
        ("socket://127.0.0.1:7001", 1, False),
        ("rfc2217://127.0.0.1:7001", 1, False),
    ],
)
def test_two_clients_of_a_terminal_share_its_bytes(
    monkeypatch: pytest.MonkeyPatch, address: str, clients: int, shares: bool
) -> None:
    row = {"device": "m1", "address": address, "clients": clients, "ports": {}, "greeting": "p"}
    told: list[str] = []

    def run(address: str, *, hints: list[str]) -> None:
        told.extend(hints)

    def ask(*_: Any) -> Any:
        return {"devices": [row]}

    monkeypatch.setattr(BenchOptions, "ask", ask)
    monkeypatch.setattr(BenchOptions, "port_of", lambda _, address: address)
    monkeypatch.setattr(monitor, "monitor", run)
    assert CliRunner().invoke(app, ["monitor", "m1"]).exit_code == 0
    assert any("Another program has this port open" in hint for hint in told) is shares
