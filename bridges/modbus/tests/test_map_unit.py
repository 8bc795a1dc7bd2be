"""Unit of a map of version 2: what a write asks for, and what is read by other registers."""

from typing import Any

import pytest

from bridges.modbus.maps.drive_map_text import read_drive_map
from bridges.modbus.protocol.pdu import Code, Refused, Span, Table, Write
from bridges.modbus.registers.map_rows import FORMATS, formatted, map_rows
from bridges.modbus.registers.units import unit_of
from hil.vocab.axis import AxisState
from hil.vocab.desk_protocol import AxisLook, DeviceInfo
from hil.vocab.time import SimTimeNs

INPUT, HOLDING = Table.INPUT_REGISTERS, Table.HOLDING_REGISTERS
TEXT = """
modbus_map: 2
position_deg: {input: 0, type: i32, unit: turn, per: steps}
set_point_deg: {holding: 2, type: i32, unit: turn, per: steps}
set_velocity_rpm: {holding: 4, scale: 0.01, unit: Hz, pole_pairs: 3}
acceleration_rpm_per_s: {holding: 5, unit: ms, to_rpm: 1000}
cells:
  steps: {holding: 10, value: 200, stored: by_command, effect: stored}
  secret: {holding: 11, access: w}
  guarded: {holding: 12, locked_by: {cell: secret, value: 7, exception: 77}, refuse_while: {enabled: 99}}
  low: {holding: 13, mask: 0x000F}
  high: {holding: 13, mask: 0xF000}
commands:
  go: {holding: 20, values: {enable+start: 1, store: 2, zero: 3, nothing: 0}}
"""


def unit() -> Any:
    of = read_drive_map(TEXT, "map.yaml")
    return unit_of(DeviceInfo("m1", "specimen", False, {}, {}, own_map=of))


def look(*, is_on: bool = False, **told: float) -> AxisLook:
    motion = AxisState(SimTimeNs(0), 0.0, 180.0, False, False, is_on=is_on)
    return AxisLook(b"", motion, None, {name.replace("__", "."): value for name, value in told.items()})


def asked(address: int, *words: int, seen: AxisLook | None = None) -> list[tuple[str, Any]]:
    wanted = unit().write(Write(HOLDING, address, words), {}, seen or look())
    return [(each.given["name"], dict(each.given["parameters"])) for each in wanted]


def test_a_scale_by_a_register_is_in_effect_when_that_was_stored() -> None:
    one = unit()
    assert one.read(Span(INPUT, 0, 2), look(position_deg=180.0), {}) == [0, 100]
    written = look(position_deg=180.0, cell__steps=1000)
    assert one.read(Span(INPUT, 0, 2), written, {}) == [0, 100]
    assert one.read(Span(HOLDING, 10, 1), written, {}) == [1000]
    stored = look(position_deg=180.0, cell__steps=1000, stored__steps=1000)
    assert one.read(Span(INPUT, 0, 2), stored, {}) == [0, 500]
    assert asked(2, 0, 250, seen=stored) == [("put", {"set_point_deg": 90.0})]


def test_frequencies_and_times_become_speeds_and_ramps() -> None:
    assert asked(4, 5000, 500) == [
        ("put", {"set_velocity_rpm": pytest.approx(1000), "acceleration_rpm_per_s": pytest.approx(2000)})
    ]
    assert asked(5, 0) == [("put", {"acceleration_rpm_per_s": 1e6})]
    told = look(set_velocity_rpm=1000, acceleration_rpm_per_s=2000)
    assert unit().read(Span(HOLDING, 4, 2), told, {}) == [5000, 500]


def test_one_value_is_several_commands_behind_what_was_written_with_it() -> None:
    assert asked(20, 1) == [("enable", {}), ("move_abs", {"position_deg": 0.0})]
    assert asked(20, 2) == [("store", {"names": "steps"})]
    assert asked(20, 3) == [("origin", {})]
    assert asked(20, 0) == []
    assert asked(10, 400) == [("put", {"cells": "steps=400.0"})]


def test_bits_of_one_register_belong_to_two_cells() -> None:
    assert asked(13, 0x5003) == [("put", {"cells": "low=3.0 high=5.0"})]
    assert unit().read(Span(HOLDING, 13, 1), look(cell__low=3, cell__high=5), {}) == [0x5003]
    with pytest.raises(Refused) as caught:
        asked(13, 0x0010)
    assert caught.value.code == Code.ILLEGAL_DATA_VALUE


def test_what_is_locked_or_refused_has_an_exception_of_its_own() -> None:
    for seen, code in ((look(), 77), (look(cell__secret=7, is_on=True), 99)):
        with pytest.raises(Refused) as caught:
            asked(12, 1, seen=seen)
        assert caught.value.code == code
    assert asked(12, 1, seen=look(cell__secret=7)) == [("put", {"cells": "guarded=1.0"})]
    with pytest.raises(Refused) as caught:
        unit().read(Span(HOLDING, 11, 1), look(), {})
    assert caught.value.code == Code.ILLEGAL_DATA_ADDRESS


@pytest.mark.parametrize("form", FORMATS)
def test_the_map_can_be_shown(form: str) -> None:
    text = "\n".join(formatted(map_rows(unit().map), form))
    for part in ("bits 000Fh low, F000h high", "1h enable and start", "set_velocity_rpm"):
        assert part in text
