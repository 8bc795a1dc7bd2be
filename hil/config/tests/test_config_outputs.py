"""Outputs of the models: the JSON Schema, the reference page and the plan of a reload."""

import copy
from pathlib import Path
from typing import Any, Literal

import pytest
import yaml
from jsonschema import Draft202012Validator
from pydantic import BaseModel, Field

from hil.compose import find_catalogue
from hil.config import (
    BenchConfig,
    Catalogue,
    Change,
    ConfigError,
    DeviceConfig,
    diff,
    from_dict,
    profile_from_yaml,
    reference,
    schema,
)
from hil.config.device_parts_model import FlashConfig

ROOT = Path(__file__).parents[3]
PROFILE = ROOT / "device_profiles" / "mechaduino"


class PtyLike(BaseModel):
    """A pseudo-terminal."""

    mode: str = Field(default="0660", description="Permissions, in octal.")
    path: str | None = Field(default=None, description="Where the link is put.")


class Limits(BaseModel):
    clients: int = Field(default=1, description="How many at once.")


class TcpLike(BaseModel):
    host: str = Field(default="127.0.0.1", description="Address to listen on.")
    port: int = Field(ge=0, le=65535, description="Number of the port.")
    style: Literal["raw", "telnet"] = Field(default="raw", description="Form of the bytes | their escapes.")
    limits: Limits = Field(default=Limits(), description="Limits.")


CATALOGUE = Catalogue(
    {"mechaduino": profile_from_yaml((PROFILE / "profile.yaml").read_text(), PROFILE)},
    {"pty": PtyLike, "tcp": TcpLike},
)
DEMO = ROOT / "examples" / "demo.yaml"
BASE: dict[str, Any] = {
    "bench": "t",
    "devices": {
        "m1": {"profile": "mechaduino"},
        "m2": {"profile": "mechaduino", "port": {"kind": "tcp", "port": 5000}, "axis": {"start_deg": 1.0}},
    },
}


def changed(**updates: object) -> dict[str, Any]:
    """BASE with ``a__b__c=value`` set at a, b, c."""
    data = copy.deepcopy(BASE)
    for key, value in updates.items():
        *parents, last = key.split("__")
        inner = data
        for parent in parents:
            inner = inner.setdefault(parent, {})
        inner[last] = value
    return data


def bench(**updates: object) -> BenchConfig:
    return from_dict(changed(**updates), CATALOGUE)


def test_the_schema_is_valid_and_takes_the_demo() -> None:
    Draft202012Validator.check_schema(schema(find_catalogue()))
    Draft202012Validator(schema(find_catalogue())).validate(yaml.safe_load(DEMO.read_text()))
    validator = Draft202012Validator(schema(CATALOGUE))
    validator.validate(BASE)
    validator.validate(changed(devices__m2__port__limits={"clients": 2}, devices__m1__port="pty"))


@pytest.mark.parametrize(
    "updates",
    [
        {"spede": 1},
        {"bench": "No"},
        {"rate_hz": 99},
        {"speed": 0},
        {"devices": {}},
        {"devices__M3": {"profile": "mechaduino"}},
        {"devices__m1__profile": "walter"},
        {"devices__m1__port": "usb"},
        {"devices__m1__port": {"mode": "0660"}},
        {"devices__m1__port": {"kind": "pty", "mode": 432}},
        {"devices__m1__port": {"kind": "pty", "host": "x"}},
        {"devices__m2__port": {"kind": "tcp"}},
        {"devices__m2__port__limits": {"clients": "many"}},
        {"devices__m1__axis": {"inertia": 1}},
        {"devices__m1__axis": {"inertia_kg_m2": 0}},
        {"devices__m1__axis": {"rotor_teeth": 50.5}},
        {"devices__m1__hardware": "0.3"},
        {"devices__m1__registers": {"diaagc": 0x8000}},
        {"devices__m1__registers": {"other": 1}},
        {"devices__m1__flash": {"table": "identty"}},
        {"devices__m1__flash__tabel": "empty"},
        {"devices__m1__baud": 49},
    ],
)
def test_the_schema_refuses_what_parse_refuses(updates: dict[str, object]) -> None:
    data = changed(**updates)
    assert not Draft202012Validator(schema(CATALOGUE)).is_valid(data)
    with pytest.raises(ConfigError):
        from_dict(data, CATALOGUE)


def test_every_key_of_the_models_is_described_and_in_the_reference() -> None:
    page = reference(CATALOGUE)
    for model in (BenchConfig, DeviceConfig, FlashConfig, PtyLike, TcpLike):
        for name, field in model.model_fields.items():
            assert field.description, name
            assert f"| `{name}` |" in page
            assert field.description.replace("|", r"\|") in page
    for name, parameter in CATALOGUE.profiles["mechaduino"].axis.items():
        other = "" if parameter.full is None else f"; `plant: full`: {parameter.full:g}"
        assert f"| `{name}` | {parameter.value:g}{other} | {parameter.unit} |" in page


def test_the_reference_has_well_formed_tables_with_types_and_defaults() -> None:
    page = reference(CATALOGUE)
    assert "| `rate_hz` | whole number ≥ 100 ≤ 6500 | `1000` | " in page
    assert "| `profile` | `mechaduino` | required | " in page
    assert '| `port` | `pty`, `tcp` or mapping | `"pty"` | ' in page
    assert '| `style` | `raw`, `telnet` | `"raw"` | ' in page
    assert '| `"0.2"` | 8 to 35 | D0, D1, D2, D3 |' in page
    tables = [part for part in page.split("\n\n") if part.startswith("| ")]
    for table in tables:
        columns = {line.replace(r"\|", "").count("|") for line in table.splitlines()}
        assert len(columns) == 1


def test_nothing_changes_in_a_reload_of_the_same_file() -> None:
    assert diff(bench(), bench()) == [Change("m1", "keep"), Change("m2", "keep")]


def test_a_default_written_out_is_no_change() -> None:
    assert diff(bench(), bench(devices__m1__hardware="0.1", devices__m1__port="pty", rate_hz=1000)) == [
        Change("m1", "keep"),
        Change("m2", "keep"),
    ]


def test_a_changed_device_restarts_and_says_why() -> None:
    new = bench(
        devices__m1__baud=115200,
        devices__m2__port__port=5001,
        devices__m2__axis={"load_torque_Nm": 0.1},
        devices__m2__flash={"table": "empty"},
    )
    assert diff(bench(), new) == [
        Change("m1", "restart", ("baud: null -> 115200",)),
        Change(
            "m2",
            "restart",
            (
                "port.port: 5000 -> 5001",
                'flash.table: "stored" -> "empty"',
                "axis.start_deg: 1.0 -> unset",
                "axis.load_torque_Nm: unset -> 0.1",
            ),
        ),
    ]


def test_another_kind_of_port() -> None:
    (m1, _) = diff(bench(), bench(devices__m1__port={"kind": "tcp", "port": 7}))
    assert m1.action == "restart"
    assert m1.why[0] == 'port.kind: "pty" -> "tcp"'
    assert 'port.mode: "0660" -> unset' in m1.why


def test_removals_come_before_additions_and_a_change_of_the_core_first() -> None:
    old = bench(rate_hz=500)
    data = changed(rate_hz=2000, state_dir="/var/x")
    data["devices"] = {"m0": {"profile": "mechaduino"}, "m2": data["devices"]["m2"]}
    assert diff(old, from_dict(data, CATALOGUE)) == [
        Change(None, "restart", ("rate_hz: 500 -> 2000", 'state_dir: null -> "/var/x"')),
        Change("m1", "remove", ("it is no longer in the configuration",)),
        Change("m0", "add", ("it is new in the configuration",)),
        Change("m2", "keep"),
    ]


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("bench", "u"),
        ("rate_hz", 500),
        ("speed", 2.0),
        ("seed", 1),
        ("cpu", 1),
        ("runtime_dir", "/run/x"),
        ("state_dir", "/var/x"),
    ],
)
def test_each_key_of_the_bench_restarts_the_core(key: str, value: object) -> None:
    first = diff(bench(), bench(**{key: value}))[0]
    assert (first.device, first.action) == (None, "restart")
    assert first.why[0].startswith(f"{key}: ")
