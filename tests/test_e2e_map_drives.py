"""Real drives by the public maps of examples/drives: here each is the twin of another daemon with the same
map, behind its Modbus door."""

import json
from pathlib import Path
from typing import Any

import pytest
import yaml
from e2e_support import Place, free_port, until

DRIVES = Path(__file__).parents[1] / "examples" / "drives"
MAPS = {
    "stepper": "leadshine_pr",
    "servo": "mks_servo42d",
    "fan": "delta_vfd",
    "slide": "kinco_cia402",
}


class Plant:
    """A daemon with a twin of each map, and one to which they are real drives."""

    def __init__(self, place: Place) -> None:
        self.place, port = place, free_port()
        maps = {name: yaml.safe_load((DRIVES / f"{of}.yaml").read_text()) for name, of in MAPS.items()}
        twins = {name: {"profile": "modbus_drive", "map": of} for name, of in maps.items()}
        door = {"modbus": {"listen": f"127.0.0.1:{port}"}}
        self.far = place.serve(json.dumps({"bench": "far", "devices": twins, "bridges": door}), bench="far")
        real = {
            name: {
                "profile": "modbus_drive",
                "map": of,
                "at": f"modbus+tcp://127.0.0.1:{port}?unit={unit}",
            }
            for unit, (name, of) in enumerate(maps.items(), 1)
        }
        self.near = place.serve(json.dumps({"bench": "near", "devices": real}), bench="near")
        self.far.ready("fan", boot_ns=300_000_000)
        until(lambda: all(self.is_there(name) for name in maps), "the drives")

    def is_there(self, name: str) -> bool:
        return bool(self.near.status(name)["drive"]["state"] == "there")

    def do(self, device: str, verb: str, **parameters: Any) -> Any:
        return self.near.ask("do", device=device, name=verb, parameters=parameters)

    def far_field(self, name: str, field: str) -> float:
        return float(self.far.status(name)["snapshot"][field])


@pytest.mark.long
def test_drives_are_run_by_the_commands_of_their_maps(place: Place) -> None:
    plant = Plant(place)
    for name in ("stepper", "servo", "slide"):
        plant.do(name, "enable")
        plant.do(name, "move_abs", position_deg=90.0, velocity_rpm=120.0, acceleration_rpm_per_s=1000.0)
        until(lambda name=name: abs(plant.far_field(name, "yw") - 90) < 0.5, f"90 deg of {name}")
        until(lambda name=name: abs(plant.near.ask("state", device=name)["position_deg"] - 90) < 0.5, name)
    plant.do("fan", "enable")
    plant.do("fan", "run", velocity_rpm=-120.0)
    until(lambda: abs(plant.far_field("fan", "velocity_rpm") + 120) < 5, "120 rpm")
    plant.do("fan", "stop")
    until(lambda: abs(plant.far_field("fan", "velocity_rpm")) < 1, "a stand")
    refused = place.cli("axis", "fan", "move-abs", "90", "--bench", "near", code=1)
    assert "this drive only turns" in refused
