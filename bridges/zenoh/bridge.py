"""The zenoh bridge's options, and how it is made. A configuration is checked without the rest of it."""

from typing import TYPE_CHECKING

from bridges.zenoh.options import Options

if TYPE_CHECKING:
    from bridges.zenoh.testing.memory_zenoh_door import MemoryZenohDoor
    from hil.testing.doors.door_time import DoorTime
    from hil.vocab.bridge_protocol import Bridge
    from hil.vocab.desk_protocol import Desk

__all__ = ["Options", "in_memory", "make", "reference"]


def make(options: Options, desk: "Desk") -> "Bridge":
    from bridges.zenoh.bench_session import ZenohBridge

    return ZenohBridge(options, desk)


def in_memory(options: Options, desk: "Desk", time: "DoorTime") -> "MemoryZenohDoor":
    """Door for sessions of tests on a bench in memory."""
    from bridges.zenoh.testing.memory_zenoh_door import MemoryZenohDoor

    return MemoryZenohDoor(options, desk, time)


def reference() -> str:
    """Part of the reference about the keys."""
    from bridges.zenoh.keys import reference as part

    return part()
