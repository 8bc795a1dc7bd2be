"""Plans of reads, writes of values and bits, and the layout of a drive's fields: pure."""

import math
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bridges.modbus.drives.control_bits import RegisterWrite, bits_write, value_write
from bridges.modbus.drives.poll_plan import MOST_BITS, MOST_REGISTERS, PollPlan, spans_of
from bridges.modbus.drives.register_drive import map_verbs
from bridges.modbus.maps.drive_map_text import read_drive_map
from bridges.modbus.protocol.pdu import Span, Table
from bridges.modbus.registers.cells import BIT
from bridges.modbus.registers.drive_map import DriveMap, RegisterPlace
from hil.core.fields import OFFSETS
from hil.drives.drive_fields import drive_fields, packed

INPUT, HOLDING, COIL = Table.INPUT_REGISTERS, Table.HOLDING_REGISTERS, Table.COILS
TEXT = """
modbus_map: 1
word_order: low_first
position_deg: {input: 0, type: i32, scale: 0.01}
velocity_rpm: {input: 2, type: i16, scale: 0.1}
status: {enabled: {input: 4, bit: 0}, moving: {discrete: 7}}
set_point_deg: {holding: 10, type: f32}
acceleration_rpm_per_s: {holding: 12}
control:
  enable: {holding: 20, bit: 0}
  start: {holding: 20, bit: 1}
  stop: {holding: 21, bit: 15}
  reset: {coil: 3}
parameters: {pKp: {holding: 30, type: f32}, limit: {holding: 200}}
"""


def drive_map() -> DriveMap:
    return read_drive_map(TEXT, "m.yaml")


def test_near_registers_are_read_together() -> None:
    def of(*addresses: int, width: str = "u16", gap: int = 8) -> list[tuple[int, int]]:
        spans = spans_of([RegisterPlace(INPUT, address, width) for address in addresses], gap)
        return [(span.address, span.count) for span in spans]

    assert of(0, 1, 2) == [(0, 3)]
    assert of(2, 0, 0) == [(0, 3)]
    assert of(0, 9) == [(0, 10)]
    assert of(0, 10) == [(0, 1), (10, 1)]
    assert of(0, 2, gap=0) == [(0, 1), (2, 1)]
    assert of(0, 2, width="i32", gap=0) == [(0, 4)]
    assert of(*range(130)) == [(0, 125), (125, 5)]
    assert of(65534, width="i32") == [(65534, 2)]
    places = [RegisterPlace(INPUT, 0), RegisterPlace(HOLDING, 1), RegisterPlace(COIL, 2, "bit")]
    assert set(spans_of(places)) == {Span(COIL, 2, 1), Span(HOLDING, 1, 1), Span(INPUT, 0, 1)}


@settings(deadline=None, max_examples=200)
@given(
    st.lists(st.tuples(st.sampled_from(list(Table)), st.integers(0, 3000), st.booleans()), max_size=40),
    st.integers(0, 20),
)
def test_reads_have_every_place_and_are_never_too_long(rows: list[tuple[Table, int, bool]], gap: int) -> None:
    bits = (Table.COILS, Table.DISCRETE_INPUTS)
    places = [
        RegisterPlace(table, address, "bit" if table in bits else ("i32" if is_wide else "u16"))
        for table, address, is_wide in rows
    ]
    spans = spans_of(places, gap)
    read = {
        (span.table, address) for span in spans for address in range(span.address, span.address + span.count)
    }
    for place in places:
        assert all((place.table, place.address + offset) in read for offset in range(place.width))
    assert all(span.count <= (MOST_BITS if span.table in bits else MOST_REGISTERS) for span in spans)
    assert sum(span.count for span in spans) <= sum(place.width for place in places) + gap * len(places)


def test_what_a_reading_means() -> None:
    plan = PollPlan.of_map(drive_map())
    assert {span.table for span in plan.state(gap=8, has_kept=False)} == {INPUT, Table.DISCRETE_INPUTS}
    assert Span(HOLDING, 10, 12) in plan.state(gap=8, has_kept=True)
    low, high = struct.unpack(">HH", struct.pack(">i", -9000))[::-1]
    set_point = struct.unpack(">HH", struct.pack(">f", 12.5))[::-1]
    words = {
        INPUT: {0: low, 1: high, 2: 0xFFFF, 3: 9, 4: 1},
        Table.DISCRETE_INPUTS: {7: 1},
        HOLDING: dict(enumerate((*set_point, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0x8000), 10)),
    }
    reading = plan.reading(5, words)
    assert reading.values == {"position_deg": -90.0, "velocity_rpm": -0.1, "set_point_deg": 12.5}
    told = {"status.enabled": True, "status.moving": True}
    told |= {"control.enable": False, "control.start": True, "control.stop": True}
    assert reading.bits == told
    assert reading.at_ns == 5


def test_bits_of_a_register_are_switched_together_and_others_stay() -> None:
    of = drive_map()
    wanted = {"enable": True, "start": False, "stop": True, "reset": True, "follow": True}
    assert bits_write(of, wanted, {20: 0xFF02}) == (
        RegisterWrite(HOLDING, 20, (0xFF01,)),
        RegisterWrite(HOLDING, 21, (0x8000,)),
        RegisterWrite(COIL, 3, (1,)),
    )
    assert bits_write(of, {"follow": True}, {}) == ()


def test_a_bit_that_clears_itself_is_written_only_to_command() -> None:
    start = RegisterPlace(HOLDING, 20, BIT, bit=1, on_write=True)
    of = DriveMap(control={"enable": RegisterPlace(HOLDING, 20, BIT, bit=0), "start": start})
    assert bits_write(of, {"enable": True, "start": False}, {20: 0xFF03}) == (
        RegisterWrite(HOLDING, 20, (0xFF01,)),
    )
    assert bits_write(of, {"start": False}, {20: 3}) == ()
    assert bits_write(of, {"start": True}, {20: 1}) == (RegisterWrite(HOLDING, 20, (3,)),)


def test_a_value_that_does_not_fit_is_refused_and_not_clamped() -> None:
    of = drive_map()
    assert value_write(of, of.values["set_point_deg"], 12.5).words == (0, 0x4148)
    for value in (-1.0, 65536.0, math.nan, math.inf):
        with pytest.raises(ValueError, match="cannot hold"):
            value_write(of, of.values["acceleration_rpm_per_s"], value)


def test_fields_have_the_twins_offsets_where_twins_have_them() -> None:
    of = drive_map()
    fields = drive_fields(of.values, of.parameters)
    for name in ("at_ns", "position_deg", "velocity_rpm", "commanded_deg", "pKp"):
        assert fields[name].offset == OFFSETS[name]
    own = {name: field.offset for name, field in fields.items() if name not in OFFSETS}
    assert min(own.values()) >= 1024
    assert len(set(own.values())) == len(own)
    assert next(iter(fields)) == "at_ns"
    assert [name for name, field in fields.items() if field.is_settable] == ["pKp", "limit"]
    assert "current_A" not in fields
    values = {"at_ns": 5, "position_deg": 1.5, "connected": 1}
    data = packed(fields, values)
    assert struct.unpack_from("<q", data, 0) == (5,)
    assert struct.unpack_from("<d", data, fields["position_deg"].offset) == (1.5,)
    assert struct.unpack_from("<i", data, fields["connected"].offset) == (1,)
    assert math.isnan(struct.unpack_from("<d", data, fields["age_ms"].offset)[0])


def test_verbs_are_those_that_the_map_allows() -> None:
    verbs = map_verbs(drive_map())
    names = ["enable", "disable", "move_abs", "move_rel", "stop", "clear_fault", "reset"]
    assert list(verbs) == names
    parameters = {each.name: each for each in verbs["move_abs"].parameters}
    assert list(parameters) == ["position_deg", "acceleration_rpm_per_s"]
    assert parameters["acceleration_rpm_per_s"].is_optional
    only_follows = read_drive_map(
        TEXT.replace("start:", "follow:").replace("  reset: {coil: 3}\n", ""), "m.yaml"
    )
    verbs = map_verbs(only_follows)
    assert "reset" not in verbs
    assert [each.default for each in verbs["move_rel"].parameters] == [None, 60.0, 600.0]
