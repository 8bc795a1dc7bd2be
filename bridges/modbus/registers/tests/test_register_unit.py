"""What writes to a unit ask of its device, and what is read back."""

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridges.modbus.protocol.pdu import Code, Refused, Span, Table, Write
from bridges.modbus.registers import layout
from bridges.modbus.registers.cells import NO_I32, words_of
from bridges.modbus.registers.register_map import Wanted, register_map
from bridges.modbus.registers.register_unit import RegisterUnit, VerbStage
from hil.vocab.axis import AxisState
from hil.vocab.desk_protocol import AxisField, AxisLook, DeviceInfo
from hil.vocab.parameters import Parameter
from hil.vocab.time import SimTimeNs
from hil.vocab.verbs import Effect, Verb, table_of

HOLDING, COILS, BITS = Table.HOLDING_REGISTERS, Table.COILS, Table.DISCRETE_INPUTS
VERBS = (
    Verb("enable", "on"),
    Verb(
        "go",
        "goes",
        (
            Parameter("to_deg", "where to", "deg", -1000, 1000),
            Parameter("turns", "how often", "", 0, 10, 3, is_whole=True),
            Parameter("way", "which way", choices=("up", "down"), default="up"),
            Parameter("rate", "how fast", "", 0, 10, is_optional=True),
        ),
        effect=Effect.ENDS,
    ),
    Verb("say", "says", (Parameter("text", "what", maximum=9, is_text=True),)),
    Verb("stop", "stops", (Parameter("way", "how", choices=("soft", "hard"), default="soft"),)),
)
FIELDS = {
    "load": AxisField("load", "f64", "Nm", "load", 0, True, True),
    "gain": AxisField("gain", "f32", "", "gain", 8, True, True),
    "limit": AxisField("limit", "i32", "", "limit", 12, True, True),
    "pin_a": AxisField("pin_a", "i32", "", "pin a", 16, False, True),
}
INFO = DeviceInfo("m1", "specimen", False, table_of(VERBS), FIELDS, {"a": "pin_a", "b": ""})
LOOK = AxisLook(
    struct.pack("<dfii4x", 0.5, 2.5, -7, 1), AxisState(SimTimeNs(9), 0.0, 0.0, False, False), None
)
GO = 1
GO_AT = layout.PARAMETERS_AT + layout.PER_VERB
STOP = 3


@pytest.fixture
def unit() -> RegisterUnit:
    return RegisterUnit(register_map(INFO))


def put(unit: RegisterUnit, address: int, *words: int, halves: dict[int, int] | None = None) -> list[Wanted]:
    return unit.write(Write(HOLDING, address, words), {} if halves is None else halves)


def refusal(unit: RegisterUnit, write: Write) -> Code:
    with pytest.raises(Refused) as caught:
        unit.write(write, {})
    assert str(caught.value)
    return caught.value.code


def held(unit: RegisterUnit, address: int, count: int, halves: dict[int, int] | None = None) -> list[int]:
    return list(unit.read(Span(HOLDING, address, count), LOOK, halves or {}))


def bit(unit: RegisterUnit, table: Table, address: int) -> int:
    return unit.read(Span(table, address, 1), LOOK, {})[0]


def test_parameters_are_preset_and_what_is_needed_is_left_out(unit: RegisterUnit) -> None:
    words = held(unit, GO_AT, 8)
    assert math.isnan(struct.unpack(">f", struct.pack(">2H", *words[:2]))[0])
    assert words[2:6] == [0, 3, 0, 0]
    (wanted,) = unit.write(Write(COILS, GO, (1,)), {})
    assert wanted == Wanted("do", {"name": "go", "parameters": {"turns": 3, "way": "up"}}, GO)


def test_a_verb_starts_with_what_was_written(unit: RegisterUnit) -> None:
    assert put(unit, GO_AT, *words_of("f32", 90.1), 0, 5, 0, 1) == []
    (wanted,) = unit.write(Write(COILS, GO, (1,)), {})
    assert wanted.given["parameters"] == {"to_deg": 90.1, "turns": 5, "way": "down"}


def test_a_command_with_its_arguments_in_one_write(unit: RegisterUnit) -> None:
    (wanted,) = put(unit, layout.COMMAND_AT, 1 + GO, *words_of("f32", -45.5))
    assert wanted.given["parameters"] == {"to_deg": -45.5, "turns": 3, "way": "up"}
    assert held(unit, layout.COMMAND_AT, 3) == [1 + GO, *words_of("f32", -45.5)]
    assert held(unit, GO_AT, 2) == list(words_of("f32", -45.5))
    assert held(unit, layout.ARGUMENTS_AT, 32)[8:] == [0] * 24


@pytest.mark.parametrize(
    "write",
    [
        Write(HOLDING, layout.ARGUMENTS_AT, (0, 1)),
        Write(HOLDING, layout.COMMAND_AT, (99,)),
        Write(HOLDING, layout.COMMAND_AT, (3,)),  # takes a text
        Write(HOLDING, layout.COMMAND_AT, (1 + GO, 0)),
        Write(HOLDING, layout.COMMAND_AT, (1, 0, 0)),
        Write(HOLDING, layout.COMMAND_AT, (0, 0, 0)),
        Write(HOLDING, GO_AT, words_of("f32", 1001)),
        Write(HOLDING, GO_AT, words_of("f32", math.inf)),
        Write(HOLDING, GO_AT + 2, words_of("i32", 11)),
        Write(HOLDING, GO_AT + 4, words_of("i32", 2)),
        Write(HOLDING, GO_AT + 4, words_of("i32", -1)),
        Write(HOLDING, layout.CONTROL_AT, (16,)),
        Write(HOLDING, layout.CONTROL_AT, (2,)),  # it has no disable
        Write(HOLDING, layout.CONTROL_AT, (5,)),
        Write(COILS, 0, (1, 1)),
    ],
)
def test_values_that_are_refused(unit: RegisterUnit, write: Write) -> None:
    before = held(unit, GO_AT, 8), held(unit, 0, 1), held(unit, 11, 1)
    assert refusal(unit, write) is Code.ILLEGAL_DATA_VALUE
    assert (held(unit, GO_AT, 8), held(unit, 0, 1), held(unit, 11, 1)) == before


@pytest.mark.parametrize(
    "write",
    [
        Write(HOLDING, 1, (0,)),
        Write(HOLDING, GO_AT + 6, (0, 0, 0)),
        Write(HOLDING, layout.PARAMETERS_AT, (0,)),
        Write(HOLDING, 1008, (0, 0)),  # a field that may not be set
        Write(COILS, 2, (1,)),  # takes a text
        Write(COILS, 102, (1,)),
    ],
)
def test_addresses_that_are_not_there(unit: RegisterUnit, write: Write) -> None:
    assert refusal(unit, write) is Code.ILLEGAL_DATA_ADDRESS


def test_what_is_left_out_again(unit: RegisterUnit) -> None:
    put(unit, GO_AT, *words_of("f32", 1.0), *words_of("i32", NO_I32), *words_of("i32", NO_I32))
    put(unit, GO_AT + 6, *words_of("f32", 2.5))
    put(unit, GO_AT + 6, *words_of("f32", math.nan))
    (wanted,) = unit.write(Write(COILS, GO, (1,)), {})
    assert wanted.given["parameters"] == {"to_deg": 1.0}


def test_a_field_is_set_only_when_all_of_it_is_there(unit: RegisterUnit) -> None:
    halves: dict[int, int] = {}
    words = words_of("f64", -0.125)
    for at in (2, 0, 3):
        assert put(unit, 1000 + at, words[at], halves=halves) == []
    assert held(unit, 1000, 4, halves)[0] == words[0]
    assert held(unit, 1000, 4) == list(words_of("f64", 0.5))  # another client sees what is
    (wanted,) = put(unit, 1001, words[1], halves=halves)
    assert wanted == Wanted("set", {"field": "load", "value": -0.125})
    assert halves == {}


@given(st.permutations(range(8)), st.booleans())
def test_values_are_complete_in_whatever_order_their_halves_come(
    order: list[int], is_low_first: bool
) -> None:
    unit, halves = RegisterUnit(register_map(INFO), is_low_first=is_low_first), {}
    words = [w for v in (words_of("f64", 1.25), words_of("f32", 0.3), words_of("i32", -3)) for w in v]
    if is_low_first:
        words = [*words[3::-1], *words[5:3:-1], *words[7:5:-1]]
    seen = {}
    for at in order:
        for wanted in unit.write(Write(HOLDING, 1000 + at, (words[at],)), halves):
            seen[wanted.given["field"]] = wanted.given["value"]
    assert seen == {"load": 1.25, "gain": 0.3, "limit": -3}


def test_several_fields_in_one_write(unit: RegisterUnit) -> None:
    wanted = put(unit, 1004, *words_of("f32", 1.5), *words_of("i32", 12))
    assert [each.given for each in wanted] == [
        {"field": "gain", "value": 1.5},
        {"field": "limit", "value": 12},
    ]


def test_a_bit_of_the_control_word_starts_when_it_becomes_one(unit: RegisterUnit) -> None:
    put(unit, layout.PARAMETERS_AT + STOP * layout.PER_VERB, 0, 1)  # hard, which the control word never means
    (wanted,) = put(unit, layout.CONTROL_AT, 4)
    assert wanted == Wanted("do", {"name": "stop", "parameters": {}}, STOP, 2)
    assert put(unit, layout.CONTROL_AT, 4) == []
    assert held(unit, 0, 1) == [4]
    (wanted,) = put(unit, layout.CONTROL_AT, 5)
    assert wanted.given["name"] == "enable"
    unit.note(wanted, VerbStage.REFUSED)
    assert held(unit, 0, 1) == [4]
    (wanted,) = put(unit, layout.CONTROL_AT, 8)
    assert wanted == Wanted("reset", {}, None, 3)


def test_bits_of_a_verb(unit: RegisterUnit) -> None:
    (wanted,) = unit.write(Write(COILS, GO, (1,)), {})
    unit.note(wanted, VerbStage.BUSY)
    assert (bit(unit, COILS, GO), bit(unit, BITS, GO), bit(unit, BITS, 205)) == (1, 0, 1)
    assert unit.write(Write(COILS, GO, (0,)), {}) == []  # that stops nothing
    unit.note(wanted, VerbStage.DONE)
    assert (bit(unit, COILS, GO), bit(unit, BITS, GO), bit(unit, BITS, 205)) == (0, 1, 0)
    unit.note(wanted, VerbStage.REFUSED)
    assert (bit(unit, BITS, GO), bit(unit, BITS, 300 + GO), bit(unit, BITS, 206)) == (0, 1, 1)
    unit.write(Write(COILS, GO, (0,)), {})
    assert (bit(unit, BITS, 300 + GO), bit(unit, BITS, 206)) == (0, 0)


def test_pins(unit: RegisterUnit) -> None:
    wanted = unit.write(Write(COILS, 100, (0, 1)), {})
    assert [each.given for each in wanted] == [{"pin": "a", "level": 0}, {"pin": "b", "level": 1}]
    assert list(unit.read(Span(COILS, 100, 2), LOOK, {})) == [
        1,
        1,
    ]  # a as its field tells, b as it was driven
    assert bit(unit, BITS, layout.PINS_AT) == 1
