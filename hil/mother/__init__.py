"""The master of a line: commands and watches all nodes of a segment, virtual or real.

``turns`` has what a master decides, without I/O. Beside it is what carries bytes and looks at the clock:
``line_place.py`` finds a line, ``line_port.py`` opens it, ``live_mother.py`` joins both.

May import: hil.discovery, hil.host, hil.net, hil.vocab, hil.wire, the standard library, serial.

Tests may import too: device_profiles, hil.testing.
"""

from hil.mother.line_place import LinePlace, LineUnreachable, find_line
from hil.mother.live_mother import LineGone, LiveMother, open_line
from hil.mother.turns.mother import Mother
from hil.mother.turns.node_rows import MotherEvent, NodeRow
from hil.mother.turns.transaction import Outcome, Transaction

__all__ = [
    "LineGone",
    "LinePlace",
    "LineUnreachable",
    "LiveMother",
    "Mother",
    "MotherEvent",
    "NodeRow",
    "Outcome",
    "Transaction",
    "find_line",
    "open_line",
]
