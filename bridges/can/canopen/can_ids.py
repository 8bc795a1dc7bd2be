"""Identifiers of CANopen's services, to which a node's number is added, and the bits of a COB-ID.

Source: CiA 301 version 4.2.0, 7.3.4 (pre-defined connection set) and 7.5.2.
"""

NMT, SYNC, EMCY, TIME = 0x000, 0x080, 0x080, 0x100
TPDO, RPDO = (0x180, 0x280, 0x380, 0x480), (0x200, 0x300, 0x400, 0x500)
SDO_ANSWER, SDO_REQUEST = 0x580, 0x600
ERROR_CONTROL = 0x700
LSS_ANSWER, LSS_REQUEST = 0x7E4, 0x7E5
NODE_ID_MAX = 127
UNCONFIGURED = 0xFF
"""Node id of a node that waits for LSS to give it one."""

INVALID = 1 << 31
"""Bit of a COB-ID: the service does not exist."""
NO_RTR = 1 << 30
"""Bit of a TPDO's COB-ID: it is not sent on request."""
ID_MASK = 0x1FFF_FFFF
