"""The master side of Modbus RTU on a line of a bench, or a real one.

``modbus_master.py`` polls units in a cycle, with requests in between, without I/O: its times are arguments.
``live_modbus.py`` joins it with a line.

May import: bridges.modbus.protocol, hil.master, hil.vocab, hil.wire, the standard library.

Tests may import too: hil.testing.
"""

from bridges.modbus.master.live_modbus import LiveModbus, open_modbus_line
from bridges.modbus.master.modbus_master import ModbusMaster, UnitPoll

__all__ = ["LiveModbus", "ModbusMaster", "UnitPoll", "open_modbus_line"]
