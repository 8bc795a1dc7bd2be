"""Identifiers of a node's services, and which of them clients may choose.

Source: CiA 301 version 4.2.0, 7.3.4 (pre-defined connection set), 7.3.5 (restricted CAN-IDs) and 7.5.2.
"""

from hil.canopen.application import SdoAbort
from hil.wire.canopen.abort_codes import AbortCode

NMT, SYNC, EMCY = 0x000, 0x080, 0x080
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
_RESTRICTED = (
    range(0x000, 0x080),
    range(0x101, 0x181),
    range(0x581, 0x600),
    range(0x601, 0x680),
    range(0x6E0, 0x800),
)


def check_cob_id(former: int, cob_id: int) -> None:
    """Check a COB-ID whose bit 31 means that the service does not exist. It has to be of a base frame and not
    restricted, and it cannot change while the service exists. Raises SdoAbort."""
    if cob_id & INVALID:
        return
    check_id(cob_id & ~NO_RTR)
    if not former & INVALID and (former ^ cob_id) & ID_MASK:
        raise SdoAbort(AbortCode.NOT_NOW, "the COB-ID is in use: set bit 31 first")


def check_id(can_id: int) -> None:
    """Check an identifier that a client chooses. Raises SdoAbort."""
    if can_id > 0x7FF or any(can_id in each for each in _RESTRICTED):
        raise SdoAbort(AbortCode.VALUE, "the CAN-ID is restricted or has more than 11 bits")
