"""Questions and answers on a line, told apart by what went before.

A frame does not say which of the two it is. One that follows a question to the same unit, and has the form of
an answer to it, is the answer.
"""

from bridges.modbus.protocol._crc16 import crc16
from bridges.modbus.protocol.frame import FRAME_BYTES_MIN, TO_ALL
from hil.vocab.ports import Sole
from hil.wire.sole_senders import IsHere

_EXCEPTION = 0x80
_EXCEPTION_FRAME_BYTES = FRAME_BYTES_MIN + 1
_READ_FRAME_BYTES = 8
_READS = range(1, 5)
_ANSWERED_OTHERWISE = (7, 11, 12, 15, 16, 17, 20, 23, 24, 43)
"""Functions whose answers have other bytes than their questions (Modbus Application Protocol V1.1b3, 6)."""


def is_answer(asked: bytes, raw: bytes) -> bool:
    """True if a frame answers the one before it, ``asked``, of the same unit. A question that is asked again
    follows the first one too: a read is told apart by its length."""
    function = asked[1]
    if raw[1] & ~_EXCEPTION != function or asked[0] == TO_ALL:
        return False
    if raw[1] & _EXCEPTION:
        return len(raw) == _EXCEPTION_FRAME_BYTES
    if function not in _READS or len(asked) != _READ_FRAME_BYTES:
        return not crc16(asked)  # nobody answers a question whose CRC is wrong: it is asked again
    count = asked[4] << 8 | asked[5]
    return len(raw) == FRAME_BYTES_MIN + 1 + (2 * count if function > 2 else (count + 7) // 8)


def is_answered_alike(raw: bytes) -> bool:
    """True if a frame with a right CRC can be the answer to a question of the same bytes. Functions that are
    not known may be answered so."""
    function = raw[1]
    if function & _EXCEPTION or function in _ANSWERED_OTHERWISE:
        return False
    return function not in _READS or (len(raw) == _READ_FRAME_BYTES and is_answer(raw, raw))


def sole_of_frame(data: bytes, is_here: IsHere) -> Sole | None:
    """Say it of a frame of Modbus RTU: some answers equal their questions."""
    if len(data) < FRAME_BYTES_MIN or crc16(data):
        return None
    if data[0] == TO_ALL or not is_answered_alike(data):
        return Sole.ALONE
    return Sole.HERE if is_here(data[0]) else Sole.UNSURE
