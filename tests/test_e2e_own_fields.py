"""Fields of a board's own at all doors: a CANopen object that tells one, and a served bench."""

import asyncio
import json
import shutil
from pathlib import Path
from typing import Any

import aiohttp
import pytest
import yaml
from e2e_support import PATIENCE_S, Place, free_port, until
from plain_zenoh import Plain
from pymodbus.client import ModbusTcpClient

from hil.testing import Bench

ROOT = Path(__file__).parents[1]
FIELDS = {
    "winding_degC": {
        "about": "temperature",
        "unit": "degC",
        "minimum": -40,
        "maximum": 200,
        "input": True,
        "value": 21.5,
    },
    "starts": {"about": "starts", "type": "whole", "minimum": 0, "maximum": 9, "input": True, "value": 3},
}


@pytest.fixture
def boards(tmp_path: Path) -> Path:
    """Folder with a drive on CAN that has fields of its own."""
    made = tmp_path / "boards/warm_drive"
    made.mkdir(parents=True)
    keys = yaml.safe_load((ROOT / "device_profiles/canopen_drive/profile.yaml").read_text())
    (made / "profile.yaml").write_text(yaml.safe_dump(keys | {"name": "warm_drive", "fields": FIELDS}))
    (made / "board.py").write_text(
        "from device_profiles.canopen_drive.board import PROFILE\n\n__all__ = ['PROFILE']\n"
    )
    shutil.copy(ROOT / "examples/drives/sd11.eds", tmp_path)
    return made.parent


def test_an_object_of_a_maker_tells_a_field_of_the_boards_own(boards: Path) -> None:
    objects = {"2010h": {"field": "winding_degC", "scale": 10}}
    node = {"id": 5, "eds": str(boards.parent / "sd11.eds"), "objects": objects}
    node["units"] = {"velocity_per_rpm": 68.26666666666667}
    config = {
        "bench": "t",
        "profile_path": [str(boards)],
        "devices": {"x": {"profile": "warm_drive"}},
        "can": {"can0": {"bit_rate": 500000, "nodes": {"x": node}}},
    }
    with Bench(config) as bench:
        bench.run(ms=500)
        drive = bench.can("can0").drive("x")
        assert drive.read(0x2010, is_signed=True) == 215
        bench.axis("x").set("winding_degC", -3)
        bench.run(ms=20)
        assert drive.read(0x2010, is_signed=True) == -30
        with bench.fault("field_offset", "x", field="winding_degC", offset=30):
            bench.run(ms=20)
            assert drive.read(0x2010, is_signed=True) in (-30, 270)


async def asked_by_a_page(root: str, **given: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """Hello of a page, and the answer to what it asks."""
    async with (
        asyncio.timeout(PATIENCE_S),
        aiohttp.ClientSession() as session,
        session.ws_connect(f"{root}ws", protocols=("hil.v1",), max_msg_size=0) as socket,
    ):
        await socket.send_json({"id": 1, "do": "ask", **given})
        hello: dict[str, Any] = {}
        while True:
            came = json.loads((await socket.receive()).data)
            hello |= came.get("hello", {})
            if came.get("id") == 1:
                return hello, came


def test_a_served_bench_has_them_at_all_doors(place: Place, boards: Path) -> None:
    zenoh_port = free_port()
    server = place.serve(
        json.dumps(
            {
                "bench": "t",
                "profile_path": [str(boards), str(ROOT / "examples/instruments/boards")],
                "devices": {
                    "supply": {"profile": "power_supply", "fields": {"load_ohm": 4}},
                    "x": {"profile": "warm_drive", "fields": {"winding_degC": 60}},
                },
                "bridges": {
                    "modbus": {"listen": "127.0.0.1:0"},
                    "zenoh": {"listen": [f"tcp/127.0.0.1:{zenoh_port}"]},
                    "web": {"listen": 0},
                },
            }
        )
    ).started()
    said = place.cli("type", "supply", "VOLT 2;:OUTP ON;*OPC?\\n", "--until", "1", "--within", "5s")
    assert "1" in said
    until(lambda: server.status("supply")["fields"]["output_A"] == 0.5, "half an ampere in the status")
    assert "x: starts 3, winding_degC 60\n" in place.cli("status")
    place.cli("set", "supply", "load_ohm", "8")
    place.cli("wait", "supply", "output_A == 0.25", "--within", "5s")
    assert json.loads(place.cli("status", "x", "--json"))["x"]["winding_degC"] == 60

    rows = {row["name"]: row["address"] for row in server.ask("registers", device="supply")["rows"]}
    bridges = server.ask("status")["bridges"]
    port = int(bridges["modbus"]["listen"][0].rpartition(":")[2])
    with ModbusTcpClient("127.0.0.1", port=port, timeout=PATIENCE_S) as client:
        words = client.convert_to_registers(10.0, client.DATATYPE.FLOAT64)
        assert not client.write_registers(rows["load_ohm"], words, device_id=1).isError()

        def current_A() -> float:
            answer = client.read_input_registers(rows["output_A"], count=4, device_id=1)
            return float(client.convert_from_registers(answer.registers, client.DATATYPE.FLOAT64))

        until(lambda: current_A() == 0.2, "the current of another load")

    plain = Plain(zenoh_port)
    assert plain.one("axis/supply/state")["output_A"] == 0.2
    assert plain.one("axis/x/state")["winding_degC"] == 60
    plain.session.close()  # type: ignore[no-untyped-call]

    hello, answer = asyncio.run(asked_by_a_page(bridges["web"]["root"], operation="state", target="supply"))
    fields = {each["name"]: each for each in hello["devices"][0]["fields"]}
    assert (fields["output_A"]["unit"], fields["load_ohm"]["is_settable"]) == ("A", True)
    assert answer["answer"]["output_A"] == 0.2
