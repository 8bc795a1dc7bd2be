"""Tests of where the defaults of a configuration stand: with their keys, and nowhere else."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from bridges.modbus.maps.drive_map_model import PlaceText
from hil.compose.find import find_catalogue
from hil.config import parse
from hil.config.port_model import USUAL_BAUD
from hil.config.schema import schema
from hil.runs.run_document import RunDocument
from hil.toolpath.machine import MachineText

HOW_TOS = sorted((Path(__file__).parents[3] / "docs/how-to").glob("*.md"))
_CODE = re.compile(r"`[^`]*`")
_NUMBER = re.compile(r"(?<![\w./:#-])\d+(?:\.\d+)?(?![\w:-]|\.\d)")
FACTS: dict[str, set[float]] = {
    "at_zero": {0, 1_000_000},  # the number that is meant, and an example
    "at_zero_speed": {0},
    "baud": {10, USUAL_BAUD},  # bit times of a character; the speed where no station has one
    "bench": {31},  # characters of a name
    "follow": {1},  # a bit's level
    "homing_method": {21},  # the value where it is never written
    "identity": {43, 14},  # function of Modbus
    "like": {402},  # a profile of CiA
    "listen": {0, 8080, 8099},  # one that is free; the door's constants, which the text is made of
    "microstep_exponent": {2},  # its base
    "modbus_map": {1, 2},  # the versions, of which none is a default
    "on_write": {1},
    "response_ms": {3.5},  # characters of silence
    "rows": {0, 1, 2},  # shares of a mean speed
    "table": {360, 16384},
    "type": {32},  # bits
    "units": {1},  # the first number
}
"""Numbers in a description that are no value of the key, by the key."""
_LIMITS = ("minimum", "exclusiveMinimum", "maximum", "exclusiveMaximum")


def keys(model: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Keys of a schema with their properties, those of its definitions too."""
    for each in (model, *model.get("$defs", {}).values()):
        yield from each.get("properties", {}).items()
    for each in model.get("properties", {}).get("bridges", {}).get("properties", {}).values():
        yield from each["anyOf"][-1].get("properties", {}).items()
    ports = model.get("$defs", {}).get("DeviceConfig", {}).get("properties", {}).get("port", {})
    for each in ports.get("anyOf", ()):
        yield from each.get("properties", {}).items()


def numbers_of(key: dict[str, Any]) -> set[float]:
    """Default, limits and choices of a key."""
    choices = [key, *key.get("anyOf", ())]
    found = [each.get(word) for each in choices for word in ("default", *_LIMITS)]
    return {each for each in found if isinstance(each, int | float) and not isinstance(each, bool)}


ALL = [
    each
    for model in (schema(find_catalogue()), RunDocument.model_json_schema(), MachineText.model_json_schema())
    for each in keys(model)
]


@pytest.mark.parametrize(("name", "key"), ALL, ids=[name for name, _ in ALL])
def test_a_number_in_a_keys_description_is_its_default_or_a_limit(name: str, key: dict[str, Any]) -> None:
    text = _CODE.sub("", key.get("description", ""))
    said = {float(each) for each in _NUMBER.findall(text)}
    assert said <= numbers_of(key) | FACTS.get(name, set()), text


@pytest.mark.parametrize("page", HOW_TOS, ids=lambda path: path.name)
def test_how_tos_say_the_default_of_a_key(page: Path) -> None:
    defaults = {name: key["default"] for name, key in ALL if isinstance(key.get("default"), float)}
    said = re.findall(r"`([A-Za-z_]+)`[^.`(|]*\((?:default )?(\d+(?:\.\d+)?)\b", page.read_text())
    assert not [(key, each) for key, each in said if key in defaults and float(each) != defaults[key]]


@pytest.mark.parametrize(
    "given", ["", ", poll_interval_ms: null, setpoint_rate_Hz: null, line_delay_ms: null"]
)
def test_null_is_a_default_as_is_the_key_left_out(given: str) -> None:
    text = f"bench: b\ndevices:\n  m1: {{profile: mechaduino{given}}}\n"
    device = parse(text, "b.yaml", find_catalogue()).devices["m1"]
    assert (device.poll_interval_ms, device.setpoint_rate_Hz, device.line_delay_ms) == (20, 50, 0)
    assert {device.model_dump()[key] for key in ("poll_interval_ms", "setpoint_rate_Hz")} == {None}


def test_a_bit_has_no_default_of_a_value() -> None:
    assert PlaceText.model_validate({"coil": 1, "scale": None}).model_fields_set == {"coil"}
