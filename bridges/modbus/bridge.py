"""The Modbus bridge's options, and how it is made. A configuration is checked without the rest of it."""

from typing import TYPE_CHECKING

from bridges.modbus.door.door_options import Options

if TYPE_CHECKING:
    from bridges.modbus.testing.memory_door import MemoryModbusDoor
    from hil.testing.doors.door_time import DoorTime
    from hil.vocab.bridge_protocol import Bridge
    from hil.vocab.desk_protocol import Desk

__all__ = ["Options", "in_memory", "make", "reference"]


def make(options: Options, desk: "Desk") -> "Bridge":
    from bridges.modbus.door.modbus_bridge import ModbusBridge

    return ModbusBridge(options, desk)


def in_memory(options: Options, desk: "Desk", time: "DoorTime") -> "MemoryModbusDoor":
    """Door for clients of tests on a bench in memory."""
    from bridges.modbus.testing.memory_door import MemoryModbusDoor

    return MemoryModbusDoor(options, desk, time)


def reference() -> str:
    """Part of the reference about requests, exceptions and the register map's blocks."""
    from bridges.modbus.door.modbus_bridge import reference as part

    return part()
