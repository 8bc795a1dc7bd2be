"""Framing of Modbus RTU: ``hil.vocab.framing.Framing``."""

from hil.vocab.framing import Item, Transform
from hil.wire.byte_faults import Chance
from hil.wire.modbus_rtu.frame import FRAME_BYTES_MIN, TO_ALL, Frame, Malformed
from hil.wire.modbus_rtu.splitter import RtuSplitter


class ModbusRtu:
    name = "modbus_rtu"
    faults = ("packet_bad_crc",)

    has_ends = False

    def splitter(self) -> RtuSplitter:
        return RtuSplitter()

    def ends(self, data: bytes, before: bytes | None) -> tuple[int, ...]:
        """Answer none: no byte ends a frame."""
        return ()

    def may_end(self, data: bytes) -> bool:
        return False

    def text(self, item: Item) -> str:
        """Format as in ``17, function 3: 00 6b 00 03``, question and answer alike."""
        assert isinstance(item, Frame | Malformed)
        if isinstance(item, Malformed):
            return f"malformed ({item.fault}): {item.raw.hex(' ')}"
        to = "all" if item.address == TO_ALL else str(item.address)
        check = f"  CRC {item.raw[-2:].hex(' ')} is wrong" if item.fault else ""
        return f"{to}, function {item.function}: {item.data.hex(' ')}".rstrip() + check

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


MODBUS_RTU = ModbusRtu()
