"""The master of a line: commands and watches all nodes of a segment, virtual or real.

``turns`` has what a master decides, without I/O. Beside it is what carries bytes and looks at the clock:
``line_place.py`` finds a line, ``line_port.py`` opens it, ``line_loop.py`` joins both with a master:
``live_mother.py`` that of SACs, ``live_modbus.py`` that of Modbus. ``path_run.py`` makes a run over a line of
a plan of ``hil.toolpath``.

May import: hil.discovery, hil.gcode, hil.host, hil.net, hil.toolpath, hil.vocab, hil.wire,
the standard library, serial.

Tests may import too: device_profiles, hil.testing.
"""

from hil.mother.line_loop import LineGone
from hil.mother.line_place import LinePlace, LineUnreachable, find_line
from hil.mother.live_modbus import LiveModbus, open_modbus_line
from hil.mother.live_mother import LiveMother, open_line
from hil.mother.path_run import path_run
from hil.mother.turns.line_run import LineRun
from hil.mother.turns.modbus_mother import ModbusMother, UnitPoll
from hil.mother.turns.mother import Mother
from hil.mother.turns.node_rows import MotherEvent, NodeRow
from hil.mother.turns.run_items import RunReport, RunState
from hil.mother.turns.transaction import Outcome, Transaction

__all__ = [
    "LineGone",
    "LinePlace",
    "LineRun",
    "LineUnreachable",
    "LiveModbus",
    "LiveMother",
    "ModbusMother",
    "Mother",
    "MotherEvent",
    "NodeRow",
    "Outcome",
    "RunReport",
    "RunState",
    "Transaction",
    "UnitPoll",
    "find_line",
    "open_line",
    "open_modbus_line",
    "path_run",
]
