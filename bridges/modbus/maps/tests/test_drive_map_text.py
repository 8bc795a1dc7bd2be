"""Maps of Modbus drives: files with the lines that they get, and random ones."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st

from bridges.modbus.maps.drive_map_text import read_drive_map
from bridges.modbus.protocol.pdu import Table
from bridges.modbus.registers.cells import BIT
from bridges.modbus.registers.drive_map import DriveMap, RegisterPlace
from hil.config import ConfigError

CASES = sorted((Path(__file__).parent / "drive_maps").glob("*.yaml"))
PARAMETERS = ("pKp", "pKi", "pKd", "pLPF")
INPUT, HOLDING, COILS = Table.INPUT_REGISTERS, Table.HOLDING_REGISTERS, Table.COILS
PUBLIC = [
    path.read_text()
    for path in sorted((Path(__file__).parents[4] / "examples" / "drives").glob("*.yaml"))
    if "modbus_map" in path.read_text()
]
WHOLE = (CASES[0].parent / "whole.yaml").read_text()


def problems(text: str, parameters: tuple[str, ...] | None = PARAMETERS) -> list[str]:
    try:
        read_drive_map(text, "map.yaml", parameters)
    except ConfigError as error:
        return [str(problem).removeprefix("map.yaml:") for problem in error.problems]
    return []


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_a_file_gets_all_the_lines_at_its_end_and_no_others(path: Path) -> None:
    text = path.read_text()
    assert problems(text) == re.findall(r"(?m)^# (\d+:\d+: .*)$", text)


def test_a_whole_map_is_read() -> None:
    read = read_drive_map(WHOLE, "map.yaml")
    assert read == DriveMap(
        word_order="low_first",
        identity={"vendor": "Acme", "product": "SV-20", "revision": "1.2"},
        values={
            "position_deg": RegisterPlace(INPUT, 0, "i32", 0.01),
            "velocity_rpm": RegisterPlace(INPUT, 2, "i16", 0.1),
            "current_A": RegisterPlace(INPUT, 3, "u16", 0.001),
            "fault_code": RegisterPlace(INPUT, 5),
            "set_point_deg": RegisterPlace(HOLDING, 10, "i32", 0.01),
            "set_velocity_rpm": RegisterPlace(HOLDING, 12),
            "acceleration_rpm_per_s": RegisterPlace(HOLDING, 13),
        },
        status={
            "enabled": RegisterPlace(INPUT, 4, BIT, bit=0),
            "moving": RegisterPlace(INPUT, 4, BIT, bit=1),
            "fault": RegisterPlace(Table.DISCRETE_INPUTS, 7, BIT),
        },
        control={
            "enable": RegisterPlace(HOLDING, 20, BIT, bit=0),
            "start": RegisterPlace(HOLDING, 20, BIT, bit=1),
            "stop": RegisterPlace(HOLDING, 20, BIT, bit=2),
            "reset": RegisterPlace(COILS, 3, BIT),
            "follow": RegisterPlace(HOLDING, 20, BIT, bit=4),
        },
        parameters={"pKp": RegisterPlace(HOLDING, 65534, "f32")},
    )
    assert read.is_low_first
    assert list(read.places)[-1] == "parameters.pKp"


def test_a_parameter_that_the_axis_has_not_is_found_where_the_names_are_known() -> None:
    text = WHOLE.replace("pKp", "pKx")
    (found,) = problems(text)
    assert found.startswith('22:3: parameters.pKx: there is no parameter "pKx" (did you mean "pK')
    assert problems(text, None) == []


def _entries(draw: st.DrawFn) -> dict[str, Any]:
    """Places of all entries in turn, each behind the one before it."""
    entries: dict[str, Any] = {}
    at = {"input": draw(st.integers(0, 100)), "holding": draw(st.integers(0, 100))}
    told = ("position_deg", "velocity_rpm", "current_A", "fault_code")
    for name in (*told, "set_point_deg", "set_velocity_rpm", "acceleration_rpm_per_s"):
        if name not in ("position_deg", "set_point_deg") and draw(st.booleans()):
            continue
        table = draw(st.sampled_from(("input", "holding") if name in told else ("holding",)))
        kind = draw(st.sampled_from(("u16", "i16", "u32", "i32", "f32")))
        entries[name] = {table: at[table], "type": kind, "scale": draw(st.sampled_from((0.01, 1, -2.5)))}
        at[table] += 1 + (kind[1:] == "32") + draw(st.integers(0, 3))
    entries["control"] = {
        "enable": {"holding": at["holding"], "bit": draw(st.integers(0, 15))},
        draw(st.sampled_from(("start", "follow"))): {"coil": draw(st.integers(0, 65535))},
    }
    return entries


maps = st.composite(_entries)()


@given(maps)
def test_places_behind_each_other_are_a_map(entries: dict[str, Any]) -> None:
    read = read_drive_map(yaml.safe_dump({"modbus_map": 1, **entries}, sort_keys=False), "map.yaml")
    for name, entry in entries.items():
        if name != "control":
            place = read.values[name]
            assert (place.type, place.scale) == (entry["type"], entry["scale"])
            assert place.address == entry.get("input", entry.get("holding"))
    assert set(read.control) == set(entries["control"])


@given(maps, st.data())
def test_an_entry_put_upon_another_is_found_at_its_address(
    entries: dict[str, Any], data: st.DataObject
) -> None:
    values = [name for name in entries if name != "control" and "holding" in entries[name]]
    first = data.draw(st.sampled_from(values))
    entries["parameters"] = {"pKp": {"holding": entries[first]["holding"]}}
    (found,) = problems(yaml.safe_dump({"modbus_map": 1, **entries}, sort_keys=False))
    assert re.match(rf"\d+:\d+: parameters\.pKp\.holding: .* is {first} \(line \d+\)", found)


def _keys(value: Any, path: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    if not isinstance(value, dict):
        return []
    return [each for key, item in value.items() for each in ((*path, key), *_keys(item, (*path, key)))]


@pytest.mark.parametrize("path", _keys(yaml.safe_load(WHOLE)), ids=".".join)
def test_any_mistyped_key_is_found_once_and_where_it_stands(path: tuple[str, ...]) -> None:
    """A key without its first letter: unknown there; what it named may be missing besides."""
    if path[0] == "parameters" and len(path) == 2:
        pytest.skip("any name may be a parameter's")
    value = yaml.safe_load(WHOLE)
    room = value
    for part in path[:-1]:
        room = room[part]
    wrong = path[-1][1:]
    room[wrong] = room.pop(path[-1])
    found = problems(yaml.safe_dump(value, sort_keys=False), None)
    assert sum(f"{'.'.join((*path[:-1], wrong))}: unknown key" in line for line in found) == 1, found


@given(st.text(max_size=200) | st.binary(max_size=100).map(lambda data: data.decode("latin-1")))
@example("modbus_map: 1\nposition_deg: {input: 0, type: u16, scale: 1e-320}\n")
@settings(max_examples=200)
def test_any_text_is_a_map_or_a_list_of_problems(text: str) -> None:
    if not problems(text):
        assert isinstance(read_drive_map(text, "map.yaml"), DriveMap)


@pytest.mark.long
@given(st.data())
@settings(max_examples=300)
def test_any_slip_in_a_good_map_ends_in_problems_with_places(data: st.DataObject) -> None:
    at = data.draw(st.integers(0, len(WHOLE) - 1))
    put = data.draw(st.text(alphabet='0129.-:{}[],"# \nabi~&*!', max_size=3))
    text = WHOLE[:at] + put + WHOLE[at + data.draw(st.integers(0, 4)) :]
    lines = text.count("\n") + 1
    for problem in problems(text, None):
        line, column = map(int, problem.split(":")[:2])
        assert 1 <= line <= lines + 1
        assert column >= 1


@pytest.mark.long
@given(st.data())
@settings(max_examples=150)
def test_any_slip_in_a_map_of_version_2_ends_in_problems_with_places(data: st.DataObject) -> None:
    text = data.draw(st.sampled_from(PUBLIC))
    at = data.draw(st.integers(0, len(text) - 1))
    put = data.draw(st.text(alphabet='0129.-:{}[],"# \nabi~&*!+', max_size=3))
    text = text[:at] + put + text[at + data.draw(st.integers(0, 4)) :]
    lines = text.count("\n") + 1
    for problem in problems(text, data.draw(st.sampled_from((None, (), PARAMETERS)))):
        line, column = map(int, problem.split(":")[:2])
        assert 1 <= line <= lines + 1
        assert column >= 1


def test_a_map_of_a_motor_is_none_of_a_board_without_one_and_the_other_way_round() -> None:
    assert problems(WHOLE.replace("modbus_map: 1", "modbus_map: 2"), ())[0].endswith(
        "this board has no axis (write a plain cell, below cells)"
    )
    (found,) = problems("modbus_map: 2\ncells: {a: {input: 0}}\n")
    assert "nothing here is of a motor" in found


def test_keys_of_version_2_are_none_of_version_1() -> None:
    found = problems(WHOLE + "cells: {a: {input: 100}}\n")
    assert found[0].endswith("version 1 of a map has no cells (write modbus_map: 2)")
