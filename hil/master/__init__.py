"""The master of a line: commands and watches all nodes of a segment, virtual or real.

``sans_io`` has what a master decides, without I/O. Beside it is what carries bytes and looks at the clock:
``line_place.py`` finds a line, ``line_port.py`` opens it, ``line_loop.py`` joins both with a master:
``live_master.py`` is that of SACs; Modbus has its own in ``bridges.modbus.master``. ``path_run.py`` makes a
run over a line of a plan of ``hil.toolpath``.

May import: hil.discovery, hil.gcode, hil.host, hil.net, hil.toolpath, hil.vocab,
hil.wire, the standard library, serial.

Tests may import too: device_profiles, hil.testing.
"""

from hil.master.line_loop import LineGone
from hil.master.line_place import LinePlace, LineUnreachable, find_line
from hil.master.live_master import LiveMaster, open_line
from hil.master.path_run import path_run
from hil.master.sans_io.line_run import LineRun
from hil.master.sans_io.node_master import NodeMaster
from hil.master.sans_io.node_rows import NodeEvent, NodeRow
from hil.master.sans_io.run_items import RunReport, RunState
from hil.master.sans_io.transaction import Outcome, Transaction

__all__ = [
    "LineGone",
    "LinePlace",
    "LineRun",
    "LineUnreachable",
    "LiveMaster",
    "NodeEvent",
    "NodeMaster",
    "NodeRow",
    "Outcome",
    "RunReport",
    "RunState",
    "Transaction",
    "find_line",
    "open_line",
    "path_run",
]
