"""Registers of a device: those of its own map, or those that are made of its verbs and fields."""

from bridges.modbus.registers.drive_map import DriveMap
from bridges.modbus.registers.drive_unit import DriveUnit
from bridges.modbus.registers.map_unit import MapUnit
from bridges.modbus.registers.register_map import register_map
from bridges.modbus.registers.register_unit import RegisterUnit
from bridges.modbus.registers.registers_protocol import Registers
from hil.vocab.desk_protocol import DeviceInfo


def unit_of(info: DeviceInfo, *, is_low_first: bool = False) -> Registers:
    """Make the registers of a device, or of another axis of one. ``is_low_first``: order of the words, where
    no map of its own says another."""
    if isinstance(info.own_map, DriveMap):
        return DriveUnit(info.own_map, info) if info.own_map.version == 1 else MapUnit(info.own_map, info)
    return RegisterUnit(register_map(info), is_low_first=is_low_first)
