"""Framing of Modbus RTU: ``hil.vocab.framing.Framing``."""

from functools import cache

from bridges.modbus.protocol.exchange import sole_of_frame
from bridges.modbus.protocol.frame import FRAME_BYTES_MIN, TO_ALL, Frame, Malformed
from bridges.modbus.protocol.splitter import RtuSplitter
from hil.vocab.framing import EVERYBODY, Item, Party, Transform
from hil.vocab.line_format import EIGHT_N_1, LineFormat
from hil.vocab.packet_field import Fields
from hil.vocab.ports import Sole
from hil.wire.byte_faults import Chance
from hil.wire.sole_senders import IsHere


class ModbusRtu:
    """Framing of a line whose characters have a format."""

    name = "modbus_rtu"
    faults = ("packet_bad_crc",)

    has_ends = False

    def __init__(self, line_format: LineFormat = EIGHT_N_1) -> None:
        self._bits = line_format.bits

    def splitter(self) -> RtuSplitter:
        return RtuSplitter(self._bits)

    def ends(self, data: bytes, before: bytes | None) -> tuple[int, ...]:
        """Answer none: no byte ends a frame."""
        return ()

    def may_end(self, data: bytes) -> bool:
        return False

    def text(self, item: Item) -> str:
        """Format as in ``to 17: read holding registers 107 to 109``."""
        from bridges.modbus.protocol.frame_words import said  # the protocol, which a line alone needs not

        assert isinstance(item, Frame | Malformed)
        if isinstance(item, Malformed):
            return f"malformed ({item.fault}): {item.raw.hex(' ')}"
        check = f"  CRC {item.raw[-2:].hex(' ')} is wrong" if item.fault else ""
        return said(item.raw, item.asked) + check

    def fields(self, item: Item) -> Fields:
        from bridges.modbus.protocol.rtu_fields import frame_fields

        return frame_fields(item.raw, item.asked) if isinstance(item, Frame) else ()

    def parties(self, item: Item) -> tuple[Party, Party]:
        """Answer the unit as the receiver of a question, or as the sender of an answer. A master has no
        address."""
        if not isinstance(item, Frame):
            return None, None
        unit = EVERYBODY if item.address == TO_ALL else item.address
        return (unit, None) if item.asked else (None, unit)

    def fault(self, kind: str, rate: float, seed: int) -> Transform:
        """Make ``packet_bad_crc``: a burst, which is a frame, gets another CRC."""
        chance = Chance(seed)

        def transform(burst: bytes) -> bytes:
            if len(burst) < FRAME_BYTES_MIN or not chance.below(rate):
                return burst
            wrong = int.from_bytes(burst[-2:], "little") ^ (1 + chance.bits() % 0xFFFF)
            return burst[:-2] + wrong.to_bytes(2, "little")

        return transform

    def answers(self, burst: bytes, address: int) -> tuple[tuple[int, bytes], ...]:
        return ()

    def sole(self, data: bytes, is_here: IsHere) -> Sole | None:
        """Answer whether another station may send a frame soon: some answers equal their questions."""
        return sole_of_frame(data, is_here)


MODBUS_RTU = ModbusRtu()


@cache
def modbus_rtu(line_format: LineFormat) -> ModbusRtu:
    """Framing of Modbus RTU on a line of this format, always the same object."""
    return MODBUS_RTU if line_format == EIGHT_N_1 else ModbusRtu(line_format)
