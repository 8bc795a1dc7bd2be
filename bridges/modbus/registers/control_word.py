"""The control word: bits that start verbs when they become 1."""

from collections.abc import Mapping
from typing import NamedTuple

from bridges.modbus.protocol.pdu import Code, Refused
from bridges.modbus.registers import layout
from bridges.modbus.registers.register_map import RegisterMap, startable


class Wanted(NamedTuple):
    """Operation that a write asks for. ``number``: of the verb that it starts; ``bit``: of the control word
    that did."""

    operation: str
    given: Mapping[str, object]
    number: int | None = None
    bit: int | None = None


class ControlWord:
    """Control word of a unit. ``word``: as it was written last, without bits whose verbs were refused."""

    def __init__(self, of: RegisterMap) -> None:
        self._map = of
        self.word = 0

    def started(self, word: int) -> list[Wanted]:
        """Verb that a word asks for, that of the bit that becomes 1, or none. It is asked for with its
        defaults, whatever its registers have.

        Raises:
            Refused: a bit starts nothing, or several become 1.
        """
        known = startable(self._map.verbs, self._map.has_reset)
        risen = [bit for bit in range(16) if word & ~self.word & 1 << bit]
        for bit in risen:
            if bit >= len(layout.CONTROL) or layout.CONTROL[bit] not in known:
                raise Refused(Code.ILLEGAL_DATA_VALUE, f"control: bit {bit} starts nothing")
        if len(risen) > 1:
            raise Refused(Code.ILLEGAL_DATA_VALUE, "control: one request starts one verb")
        if not risen:
            return []
        name = layout.CONTROL[risen[0]]
        if name == "reset":
            return [Wanted("reset", {}, bit=risen[0])]
        number = next(number for number, verb in self._map.verbs.items() if verb.name == name)
        return [Wanted("do", {"name": name, "parameters": {}}, number, risen[0])]

    def clear(self, bit: int) -> None:
        """Take a bit back, so that it can become 1 again."""
        self.word &= ~(1 << bit)
