"""The map of any device, made of its fields and verbs: its numbers and their promises."""

import math
from collections.abc import Sequence
from dataclasses import replace
from struct import pack_into

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridges.modbus.protocol.pdu import Code, Refused, Span, Table
from bridges.modbus.registers import layout
from bridges.modbus.registers.cells import value_of, words_of
from bridges.modbus.registers.map_rows import FORMATS, formatted, map_rows
from bridges.modbus.registers.register_map import register_map
from bridges.modbus.registers.register_unit import RegisterUnit
from hil.vocab.axis import AxisState
from hil.vocab.desk_protocol import AxisField, AxisLook, DeviceInfo
from hil.vocab.parameters import Parameter
from hil.vocab.time import SimTimeNs
from hil.vocab.verbs import Verb, table_of

SIZES = {"f32": 4, "f64": 8, "i32": 4, "i64": 8}
NAMES = st.text("abcdefgh_", min_size=1, max_size=6)
NUMBERS = st.floats(allow_nan=False, allow_infinity=False, width=32)


def field_table(types: Sequence[str]) -> dict[str, AxisField]:
    fields, end = {}, 0
    for at, kind in enumerate(types):
        offset = -(-end // SIZES[kind]) * SIZES[kind]
        fields[f"f{at}"] = AxisField(f"f{at}", kind, "deg", "a field", offset, at % 3 == 0, False)
        end = offset + SIZES[kind]
    return fields


PARAMETERS = st.builds(
    Parameter,
    name=NAMES,
    about=st.just("something"),
    unit=st.sampled_from(["", "deg"]),
    minimum=st.floats(-1e6, 0),
    maximum=st.floats(1, 1e6),
    default=st.none() | st.floats(0, 1),
    choices=st.just(()) | st.just(("left", "right")),
    is_text=st.booleans(),
    is_whole=st.booleans(),
    is_optional=st.booleans(),
).map(lambda each: replace(each, default="left") if each.choices and each.default is not None else each)
VERBS = st.lists(
    st.builds(
        Verb,
        name=NAMES,
        about=st.just("does it"),
        parameters=st.lists(PARAMETERS, max_size=20, unique_by=lambda each: each.name).map(tuple),
    ),
    max_size=100,
    unique_by=lambda verb: verb.name,
).map(tuple)
TYPES = st.lists(st.sampled_from([*SIZES]), max_size=60)


def info_of(verbs: tuple[Verb, ...], types: Sequence[str]) -> DeviceInfo:
    return DeviceInfo("m1", "specimen", False, table_of(verbs), field_table(types), {"a": "", "b": "f0"})


@pytest.mark.long
@given(VERBS, TYPES)
def test_no_two_values_share_a_register(verbs: tuple[Verb, ...], types: list[str]) -> None:
    of = register_map(info_of(verbs, types))
    assert len(of.at) == sum(cell.width for cell in of.cells)
    assert all(cell.address + cell.width <= 0x10000 for cell in of.cells)


@pytest.mark.long
@given(VERBS, TYPES, NAMES.map(lambda name: Verb(f"{name}_new", "does more", (Parameter("x", "much"),))))
def test_numbers_stay_when_a_verb_and_a_field_are_appended(
    verbs: tuple[Verb, ...], types: list[str], new: Verb
) -> None:
    before = register_map(info_of(verbs, types)).cells
    after = {
        (cell.table, cell.name): cell for cell in register_map(info_of((*verbs, new), [*types, "f64"])).cells
    }
    for cell in before:
        if cell.name != "control":  # whose text tells which bits start something
            assert after[cell.table, cell.name].address == cell.address
            assert after[cell.table, cell.name].type == cell.type


@pytest.mark.long
@given(VERBS, VERBS)
def test_another_map_has_another_crc(one: tuple[Verb, ...], other: tuple[Verb, ...]) -> None:
    maps = [register_map(info_of(verbs, ["f32"])) for verbs in (one, other)]
    rows = [[(c.table, c.address, c.width, c.type, c.name, c.unit) for c in each.cells] for each in maps]
    assert (rows[0] == rows[1]) == (maps[0].crc == maps[1].crc)


@given(
    st.sampled_from(["u16", "i32", "u32", "f32", "i64", "u64", "f64"]), NUMBERS | st.integers(-(2**63), 2**64)
)
def test_a_value_comes_back_at_its_resolution(kind: str, value: float) -> None:
    if kind[0] == "f":
        back = value_of(kind, words_of(kind, float(value)))
        assert back == pytest.approx(float(value), rel=2**-23, abs=2**-140)
        assert words_of(kind, back) == words_of(kind, float(value))
        return
    bits, is_signed = int(kind[1:]), kind[0] == "i"
    low, high = (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) if is_signed else (0, 2**bits - 1)
    assert value_of(kind, words_of(kind, value)) == min(max(int(value), low), high)


def look_at(info: DeviceInfo, values: Sequence[float]) -> AxisLook:
    size = max((field.offset + SIZES[field.type] for field in info.fields.values()), default=0)
    packed = bytearray(-(-size // 8) * 8)
    for field, value in zip(info.fields.values(), values, strict=True):
        code = {"f32": "f", "f64": "d", "i32": "i", "i64": "q"}[field.type]
        pack_into(f"<{code}", packed, field.offset, value if code in "fd" else int(value))
    motion = AxisState(SimTimeNs(5), 1.5, -0.25, True, False, True, True)
    return AxisLook(bytes(packed), motion, None)


@given(TYPES.filter(bool), st.booleans(), st.data())
def test_every_field_is_read_as_it_is(types: list[str], is_low_first: bool, data: st.DataObject) -> None:
    info = info_of((), types)
    values = [data.draw(NUMBERS if kind[0] == "f" else st.integers(-(2**31), 2**31 - 1)) for kind in types]
    of = register_map(info)
    unit, look = RegisterUnit(of, is_low_first=is_low_first), look_at(info, values)
    for cell in of.cells:
        if cell.address >= layout.FIELDS_AT and cell.table in (
            Table.INPUT_REGISTERS,
            *([Table.HOLDING_REGISTERS] if cell.is_writable else []),
        ):
            words = tuple(unit.read(Span(cell.table, cell.address, cell.width), look, {}))
            value = value_of(cell.type, words[::-1] if is_low_first else words)
            given_value = values[list(info.fields).index(cell.name)]
            assert words_of(cell.type, value) == words_of(cell.type, given_value)
            singles = [
                unit.read(Span(cell.table, cell.address + at, 1), look, {})[0] for at in range(cell.width)
            ]
            assert tuple(singles) == words


def test_the_fixed_block() -> None:
    info = info_of((), ["f32"])
    of = register_map(info)
    unit, look = RegisterUnit(of), look_at(info, [1.5])
    assert unit.read(Span(Table.INPUT_REGISTERS, 0, 3), look, {}) == (layout.VERSION, 0b1011, 0)
    assert value_of("i32", tuple(unit.read(Span(Table.INPUT_REGISTERS, 6, 2), look, {}))) == -250
    assert value_of("i32", tuple(unit.read(Span(Table.INPUT_REGISTERS, 12, 2), look, {}))) == 1750
    assert value_of("u64", tuple(unit.read(Span(Table.INPUT_REGISTERS, 16, 4), look, {}))) == 5
    failed = look._replace(failed="no power")
    assert unit.read(Span(Table.INPUT_REGISTERS, 1, 2), failed, {}) == (0b11011, 1)


def test_what_a_kind_has_not_is_a_gap() -> None:
    info = info_of((), ["f32"])
    unit = RegisterUnit(register_map(info))
    for address in (3, 8, 10, 998, 1002, 65535):
        with pytest.raises(Refused) as caught:
            unit.read(Span(Table.INPUT_REGISTERS, address, 1), look_at(info, [1.5]), {})
        assert caught.value.code is Code.ILLEGAL_DATA_ADDRESS


def test_a_device_without_an_axis_has_a_version_and_its_verbs() -> None:
    of = register_map(DeviceInfo("m1", "specimen", True, table_of((Verb("wave", "waves"),)), {}))
    unit = RegisterUnit(of)
    assert not unit.needs_look(Span(Table.INPUT_REGISTERS, 0, 1))
    assert unit.read(Span(Table.INPUT_REGISTERS, 0, 1), None, {}) == (layout.VERSION,)
    assert [cell.name for cell in of.cells if cell.table is Table.COILS] == ["wave", "reset"]
    with pytest.raises(Refused):
        unit.read(Span(Table.INPUT_REGISTERS, 1, 1), None, {})


@pytest.mark.parametrize("form", FORMATS)
def test_a_map_for_people_and_programs(form: str) -> None:
    verbs = (Verb("go", 'goes, "fast" | slow', (Parameter("how", "way", choices=("a", "b"), default="b"),)),)
    text = "\n".join(formatted(map_rows(register_map(info_of(verbs, ["f32", "i64"]))), form))
    assert "go.how" in text
    assert "1000" in text


def test_no_value_is_said_as_such() -> None:
    info = info_of((), ["f32"])
    motion = AxisState(SimTimeNs(5), None, math.nan, False, False)
    look = look_at(info, [0])._replace(motion=motion)
    words = RegisterUnit(register_map(info)).read(Span(Table.INPUT_REGISTERS, 6, 2), look, {})
    assert words == (0x8000, 0)
