"""Start that fails: everything is left as it was."""

import asyncio
import json
import os
import socket
from pathlib import Path
from typing import Any

import pytest

from hil.compose import find_catalogue
from hil.config import parse
from hil.daemon import Daemon
from hil.live.refusals import StartError


def refusal(folder: Path, devices: dict[str, Any]) -> str:
    """Try a start that cannot be, and return the message of its refusal."""
    config = parse(json.dumps({"bench": "b", "devices": devices}), "b.yaml", find_catalogue())
    daemon = Daemon(config, config_folder=folder, runtime_base=folder / "run", state_base=folder / "state")
    with pytest.raises(StartError) as refused:
        asyncio.run(daemon.run(lambda serving: daemon.stop()))
    return str(refused.value)


def test_a_memory_that_is_no_boards_stays_where_it_is_when_a_port_cannot_be_opened(tmp_path: Path) -> None:
    memory = tmp_path / "state" / "b" / "m1.nvm"
    memory.parent.mkdir(parents=True)
    memory.write_bytes(b"what the operator may still need")
    with socket.create_server(("127.0.0.1", 0)) as holder:
        port = {"kind": "tcp", "listen": holder.getsockname()[1]}
        assert "devices.m1.port.listen: " in refusal(
            tmp_path, {"m1": {"profile": "mechaduino", "port": port}}
        )
    assert os.listdir(memory.parent) == ["m1.nvm"]
    assert memory.read_bytes() == b"what the operator may still need"
    assert not (tmp_path / "run").exists()


def test_all_that_cannot_be_read_is_listed_in_the_order_of_the_devices(tmp_path: Path) -> None:
    (tmp_path / "state" / "b" / "s1.nvm").mkdir(parents=True)
    table = {"profile": "mechaduino", "flash": {"table": "none.txt"}}
    lines = refusal(tmp_path, {"m1": table, "s1": {"profile": "sac"}, "m2": table}).splitlines()
    assert [line.partition(":")[0] for line in lines] == [
        "devices.m1.flash.table",
        f"{tmp_path}/state/b/s1.nvm cannot be read",
        "devices.m2.flash.table",
    ]
