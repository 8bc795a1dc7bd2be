"""Registers of a drive with a map of its own: what is told, what a write asks for, and what is refused."""

import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridges.modbus.protocol.pdu import Code, Refused, Span, Table, Write
from bridges.modbus.registers.cells import BIT
from bridges.modbus.registers.drive_map import TYPES, DriveMap, RegisterPlace
from bridges.modbus.registers.map_rows import FORMATS, formatted, map_rows
from bridges.modbus.registers.register_map import Wanted
from bridges.modbus.registers.registers_protocol import device_identity
from bridges.modbus.registers.units import unit_of
from hil.vocab.axis import AxisState
from hil.vocab.desk_protocol import AxisField, AxisLook, DeviceInfo
from hil.vocab.time import SimTimeNs

INPUT, HOLDING = Table.INPUT_REGISTERS, Table.HOLDING_REGISTERS
COILS, DISCRETE = Table.COILS, Table.DISCRETE_INPUTS
FIELDS = {
    name: AxisField(name, "f64", unit, f"the {name}", at * 8, name == "pKp", False)
    for at, (name, unit) in enumerate(
        [("velocity_rpm", "rpm"), ("current_a_A", "A"), ("current_b_A", "A"), ("pKp", "")]
    )
}
MAP = DriveMap(
    identity={"vendor": "Acme", "product": "SV"},
    values={
        "position_deg": RegisterPlace(INPUT, 0, "i32", 0.01),
        "velocity_rpm": RegisterPlace(INPUT, 2, "i16", 0.1),
        "current_A": RegisterPlace(INPUT, 3, "u16", 0.001),
        "fault_code": RegisterPlace(INPUT, 5),
        "set_point_deg": RegisterPlace(HOLDING, 10, "i32", 0.01),
        "set_velocity_rpm": RegisterPlace(HOLDING, 12),
    },
    status={
        "enabled": RegisterPlace(INPUT, 4, BIT, bit=0),
        "moving": RegisterPlace(HOLDING, 20, BIT, bit=15),
        "fault": RegisterPlace(DISCRETE, 7, BIT),
    },
    control={
        "enable": RegisterPlace(HOLDING, 20, BIT, bit=0),
        "start": RegisterPlace(HOLDING, 20, BIT, bit=1),
        "reset": RegisterPlace(COILS, 3, BIT),
    },
    parameters={"pKp": RegisterPlace(HOLDING, 30, "f32")},
)


def info(of: DriveMap) -> DeviceInfo:
    return DeviceInfo("m1", "specimen", False, {}, FIELDS, own_map=of)


def look(*fields: float, failed: str | None = None, **told: float) -> AxisLook:
    values = (*fields, *[0.0] * (len(FIELDS) - len(fields)))
    motion = AxisState(SimTimeNs(0), 1.25, -90.0, False, False, is_on=True)
    return AxisLook(struct.pack("<4d", *values), motion, failed, told)


UNIT = unit_of(info(MAP))
LOOK = look(-12.3, 0.3, 0.4, 2.0, set_point_deg=45.5, set_velocity_rpm=60, enable=1, moving=1)


def write(address: int, *words: int, table: Table = HOLDING, halves: dict[int, int] | None = None) -> Any:
    return UNIT.write(Write(table, address, words), {} if halves is None else halves)


def test_what_the_drive_tells_stands_in_the_registers() -> None:
    assert UNIT.read(Span(INPUT, 0, 6), LOOK, {}) == [0xFFFF, 0xDCD8, 0x10000 - 123, 500, 1, 0]
    assert UNIT.read(Span(HOLDING, 10, 3), LOOK, {}) == [0, 4550, 60]
    assert UNIT.read(Span(HOLDING, 20, 1), LOOK, {}) == [0x8001]
    assert UNIT.read(Span(HOLDING, 30, 2), LOOK, {}) == [0x4000, 0]
    assert UNIT.read(Span(DISCRETE, 7, 1), LOOK, {}) == [0]
    assert UNIT.needs_look(Span(HOLDING, 10, 1))


def test_a_board_whose_firmware_has_stopped_has_a_fault() -> None:
    assert UNIT.read(Span(DISCRETE, 7, 1), look(failed="it raised"), {}) == [1]


def test_what_does_not_fit_is_the_nearest() -> None:
    far = look(1e9, 1e9, 0.0)
    assert UNIT.read(Span(INPUT, 2, 2), far, {}) == [0x7FFF, 0xFFFF]
    assert UNIT.read(Span(INPUT, 2, 2), look(float("nan"), float("inf"), 0.0), {}) == [0, 0]


def test_a_write_is_one_verb_with_all_that_is_in_it() -> None:
    parameters = {"set_point_deg": -0.01, "set_velocity_rpm": 120}
    assert write(10, 0xFFFF, 0xFFFF, 120) == [Wanted("do", {"name": "set_point", "parameters": parameters})]
    control = {"enable": 1, "start": 1}
    assert write(20, 0x8003) == [Wanted("do", {"name": "write", "parameters": control})]
    assert write(3, 1, table=COILS) == [Wanted("do", {"name": "write", "parameters": {"reset": 1}})]
    assert write(30, 0x3F80, 0) == [Wanted("set", {"field": "pKp", "value": 1.0})]


@pytest.mark.parametrize(
    ("table", "address", "words", "code"),
    [
        (HOLDING, 9, (0, 0), Code.ILLEGAL_DATA_ADDRESS),
        (HOLDING, 12, (0, 0), Code.ILLEGAL_DATA_ADDRESS),
        (HOLDING, 20, (4,), Code.ILLEGAL_DATA_VALUE),
        (HOLDING, 30, (0x7F80, 0), Code.ILLEGAL_DATA_VALUE),
        (COILS, 4, (1,), Code.ILLEGAL_DATA_ADDRESS),
    ],
)
def test_what_is_refused(table: Table, address: int, words: tuple[int, ...], code: Code) -> None:
    halves = {10: 7}
    with pytest.raises(Refused) as caught:
        write(address, *words, table=table, halves=halves)
    assert caught.value.code is code
    assert halves == {10: 7}


def test_a_register_of_two_waits_for_the_other_which_the_same_client_writes() -> None:
    halves: dict[int, int] = {}
    assert write(11, 5, halves=halves) == []
    assert UNIT.read(Span(HOLDING, 10, 2), LOOK, halves) == [0, 5]
    assert UNIT.read(Span(HOLDING, 10, 2), LOOK, {}) == [0, 4550]
    assert write(10, 0, 6, 60, halves={}) != []
    assert write(10, 1, halves=halves)[0].given["parameters"] == {"set_point_deg": 655.41}
    assert halves == {}


def test_it_says_what_the_map_says_and_else_what_all_do() -> None:
    said = device_identity(UNIT.map, "bench", "0.1")
    assert (said.vendor_name, said.product_code, said.revision) == ("Acme", "SV", "0.1")


@pytest.mark.parametrize("form", FORMATS)
def test_the_map_can_be_shown(form: str) -> None:
    text = "\n".join(formatted(map_rows(UNIT.map), form))
    for part in ("position_deg", "bits 0 enable, 1 start, 15 moving", "0.01 deg", "the pKp"):
        assert part in text


def test_another_map_has_another_crc() -> None:
    other = DriveMap(**{**MAP.__dict__, "word_order": "low_first"})
    assert unit_of(info(other)).map.crc != UNIT.map.crc


@given(st.data(), st.booleans())
def test_values_come_back_from_anywhere_whatever_their_form(data: st.DataObject, is_low_first: bool) -> None:
    """A write in any pieces asks for the value once, when all of it is there."""
    place = RegisterPlace(
        HOLDING,
        data.draw(st.integers(0, 65534)),
        data.draw(st.sampled_from(TYPES)),
        data.draw(st.sampled_from([0.01, 1.0, -0.5, 3.0])),
    )
    of = DriveMap("low_first" if is_low_first else "high_first", values={"set_point_deg": place})
    unit, halves = unit_of(info(of)), dict[int, int]()
    value = data.draw(st.integers(-30_000, 30_000)) / 100
    if place.type[0] == "u":
        value = abs(value) * place.scale
    words = place.words(value, is_low_first=is_low_first)
    asked: list[Wanted] = []
    for at in data.draw(st.permutations(range(len(words)))):
        assert asked == []
        asked += unit.write(Write(HOLDING, place.address + at, (words[at],)), halves)
    (wanted,) = asked
    said = wanted.given["parameters"]["set_point_deg"]
    assert said == pytest.approx(value, abs=abs(place.scale) if place.type != "f32" else 1e-3)
    told = look(set_point_deg=said)
    whole = [unit.read(Span(HOLDING, place.address + at, 1), told, halves)[0] for at in range(len(words))]
    assert tuple(whole) == words
