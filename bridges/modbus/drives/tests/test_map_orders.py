"""Orders to real drives by the public maps: the registers that are written, in their order."""

from pathlib import Path

import pytest

from bridges.modbus.drives.map_orders import MapOrders
from bridges.modbus.drives.poll_plan import PollPlan
from bridges.modbus.maps.drive_map_text import read_drive_map
from bridges.modbus.protocol.pdu import Table
from bridges.modbus.registers.drive_map import DriveMap

DRIVES = Path(__file__).parents[4] / "examples" / "drives"
TO_90 = {"set_point_deg": 90.0, "set_velocity_rpm": 120.0}
Steps = list[list[tuple[int, list[int]]]]


def drive_map(name: str) -> DriveMap:
    return read_drive_map((DRIVES / f"{name}.yaml").read_text(), name)


def steps(name: str, word: str, **values: float) -> Steps | None:
    of = drive_map(name)
    cells = of.parts.cells
    order = MapOrders(of, lambda cell: cells[cell][1].default).order(word, values)
    if order is None:
        return None
    return [[(write.address, list(write.words)) for write in step] for step in order]


def test_a_move_by_a_table_is_its_row_and_the_trigger() -> None:
    assert steps("leadshine_pr", "start_absolute", **TO_90) == [
        [(0x6200, [1]), (0x6201, [0, 2500]), (0x6203, [120])],
        [(0x6002, [0x10])],
    ]
    assert steps("leadshine_pr", "stop") == [[(0x6002, [0x40])]]


def test_a_move_by_a_block_is_one_write_with_all_its_registers() -> None:
    assert steps("mks_servo42d", "start_absolute", **TO_90) == [[(0xFE, [0xDF, 120, 0, 800])]]
    assert steps("mks_servo42d", "run", set_velocity_rpm=60.0, reverse=1.0) == [[(0xF6, [0x01DF, 60])]]


def test_fields_of_one_word_are_written_together() -> None:
    assert steps("delta_vfd", "run", set_velocity_rpm=300.0) == [[(0x2001, [1000])], [(0x2000, [0x12])]]
    assert steps("delta_vfd", "run", set_velocity_rpm=300.0, reverse=1.0) == [
        [(0x2001, [1000])],
        [(0x2000, [0x22])],
    ]
    assert steps("delta_vfd", "start_absolute", set_point_deg=0.0) is None


def test_a_drive_of_cia_402_is_led_through_its_states() -> None:
    assert steps("kinco_cia402", "enable") == [[(0x3100, [word])] for word in (6, 7, 15)]
    moved = steps("kinco_cia402", "start_absolute", **TO_90)
    assert moved is not None
    assert moved[0][0] == (0x4000, [2500, 0])
    assert moved[1:] == [[(0x3500, [1])], [(0x3100, [0x0F])], [(0x3100, [0x1F])]]


SHARED = """
modbus_map: 2
position_deg: {input: 0, type: i32, scale: 0.01}
set_velocity_rpm: {holding: 40, mask: 0x0FF0}
cells:
  filter: {holding: 40, bit: 0}
  secret: {holding: 40, bit: 1, access: w}
commands:
  go: {holding: 41, mask: 0x000F, values: {run: 1, stop: 2}}
  way: {holding: 41, mask: 0x0030, reads: written, values: {forward: 1, reverse: 2}}
mode: {holding: 40, mask: 0xF000, values: {velocity: 9}}
"""


def test_a_write_keeps_the_settings_that_are_in_its_register_and_no_commands() -> None:
    of = read_drive_map(SHARED, "map.yaml")
    orders = MapOrders(of, lambda cell: 0)
    (speed,) = orders.value("set_velocity_rpm", 5)
    assert (speed.address, speed.words, speed.keeps) == (40, (0x0050,), 0xF001)
    stop = orders.order("stop")
    assert stop is not None
    assert [(write.address, write.words, write.keeps) for write in stop[0]] == [(41, (2,), 0x0030)]
    run = orders.order("run", {"set_velocity_rpm": 5})
    assert run is not None
    assert [(write.address, write.words, write.keeps) for write in run[-1]] == [(41, (0x11,), 0)]


def test_what_the_registers_cannot_hold_is_refused() -> None:
    with pytest.raises(ValueError, match="cannot hold"):
        steps("mks_servo42d", "start_absolute", set_point_deg=1e12)
    with pytest.raises(ValueError, match="cannot hold"):
        steps("delta_vfd", "run", set_velocity_rpm=1e6)


def test_polls_read_blocks_as_a_whole_and_no_more_registers_than_the_drive_takes() -> None:
    plan = PollPlan.of_map(drive_map("mks_servo42d"))
    asked = {plan.asked(span)[1:] for span in plan.state(gap=0, has_kept=True)}
    assert {(0x30, 3), (0x31, 3), (0x39, 2)} <= asked
    of = drive_map("delta_vfd")
    assert all(span.count <= 20 for span in PollPlan.of_map(of).state(gap=8, has_kept=True))
    words = {Table.HOLDING_REGISTERS: {0x0100: 6000, **dict(enumerate((0, 0x0503, 1000, 1000, 50), 0x2100))}}
    reading = PollPlan.of_map(of).reading(0, words)
    assert reading.values["speed_rpm"] == pytest.approx(300)
    assert reading.bits["status.moving"]
    assert "status.fault" not in reading.bits


def test_polls_read_what_moves_are_converted_by_and_what_that_is_converted_by() -> None:
    text = """
modbus_map: 2
moves:
  position_deg: {holding: 20, type: i32, unit: turn, per: counts}
cells:
  counts: {holding: 10, times: whole}
  whole: {holding: 11, scale: 100}
commands:
  trigger: {holding: 30, values: {move_0: 1}}
"""
    of = read_drive_map(text, "map.yaml")
    plan = PollPlan.of_map(of)
    assert [tuple(span)[1:] for span in plan.state(gap=0, has_kept=True)] == [(10, 2)]
    reading = plan.reading(0, {Table.HOLDING_REGISTERS: {10: 40, 11: 5}})
    assert reading.values == {"cells.whole": 500, "cells.counts": 20_000}
    order = MapOrders(of, lambda cell: reading.values[f"cells.{cell}"]).order(
        "start_absolute", {"set_point_deg": 90.0}
    )
    assert order is not None
    assert [write.words for write in order[0]] == [(0, 5000)]


def test_a_speed_without_a_sign_gets_that_of_the_direction() -> None:
    plan = PollPlan.of_map(drive_map("delta_vfd"))
    words = dict.fromkeys(range(0x2100, 0x2110), 0) | {0x2103: 1000, 0x0100: 6000}
    for state, expected_rpm in ((0x0503, 300.0), (0x051B, -300.0)):
        reading = plan.reading(0, {Table.HOLDING_REGISTERS: words | {0x2101: state}})
        assert reading.values["velocity_rpm"] == expected_rpm
        assert reading.bits["status.moving"]
