"""Identifiers that clients may choose.

Source: CiA 301 version 4.2.0, 7.3.5 (restricted CAN-IDs) and 7.5.2.
"""

from bridges.can.canopen.abort_codes import AbortCode
from bridges.can.canopen.can_ids import ID_MASK, INVALID, NO_RTR
from bridges.can.canopen.node.application import SdoAbort

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
