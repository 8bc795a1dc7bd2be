"""Registers and bits with the state of an axis at one time: a look at it, in the numbers of a map."""

from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import chain
from math import hypot, isfinite, nan
from operator import itemgetter
from struct import Struct
from typing import NamedTuple

from bridges.modbus.protocol.pdu import Span, Table
from bridges.modbus.registers import layout
from bridges.modbus.registers.cells import I32_MAX, I32_MIN, NO_I32
from bridges.modbus.registers.register_map import RegisterMap
from hil.vocab.desk_protocol import AxisLook
from hil.vocab.packed_fields import STRUCTS, value_at

_FIXED = Struct(">HHHHIiiiiiQ")
FIXED_REGISTERS = _FIXED.size // 2
_FIXED_WORDS = Struct(f">{FIXED_REGISTERS}H")
_PLANS = 256
"""Maximum number of requests whose registers are looked up once and for all."""


class _Plan(NamedTuple):
    """Place of a request's registers: in the words of the fields, or in the fixed block followed by
    those."""

    is_fixed: bool
    pick: Callable[[Sequence[int]], tuple[int, ...]]


class AxisRegisters:
    """Input registers of a map, and what else a look tells. ``is_low_first``: order of the words."""

    def __init__(self, of: RegisterMap, is_low_first: bool) -> None:
        self._map = of
        self._is_low_first = is_low_first
        self._plans: dict[tuple[int, int], _Plan] = {}

    def read(self, span: Span, look: AxisLook | None, status: int) -> Sequence[int]:
        """Read input registers. ``look``: None for a device that tells no state. Raises Refused."""
        key = span.address, span.count
        if (plan := self._plans.get(key)) is None:
            if len(self._plans) >= _PLANS:
                self._plans.clear()
            plan = self._plans[key] = self._plan(span)
        words = self._words(look)
        return plan.pick((*self._fixed(look, status), *words) if plan.is_fixed else words)

    def field_word(self, address: int, look: AxisLook | None) -> int:
        """Word of a settable field, at the number that it has among the input registers too."""
        return self.read(Span(Table.INPUT_REGISTERS, address, 1), look, 0)[0]

    def field(self, look: AxisLook, name: str) -> float:
        """Value of a field; 0 where the kind has none of the name."""
        if (field := self._map.info.fields.get(name)) is None:
            return 0
        return value_at(look.packed, field.type, field.offset)

    def _plan(self, span: Span) -> _Plan:
        """Find the words of a request: those of the binary layout are there with the low one first."""
        is_fixed = span.address < layout.FIELDS_AT
        places = []
        for address in range(span.address, span.address + span.count):
            cell = self._map.cell(span.table, address)
            at, last = address - cell.address, cell.width - 1
            if address < layout.FIELDS_AT:
                places.append(cell.address + (last - at if self._is_low_first else at))
            else:
                place = cell.address - layout.FIELDS_AT + (at if self._is_low_first else last - at)
                places.append(place + FIXED_REGISTERS * is_fixed)
        if len(places) == 1:
            return _Plan(is_fixed, lambda words: (words[places[0]],))
        return _Plan(is_fixed, itemgetter(*places))

    @cached_property
    def _field_words(self) -> Struct:
        fields = self._map.info.fields.values()
        sizes = (field.offset + STRUCTS[field.type].size for field in fields)
        return Struct(f"<{max(chain(sizes, [0])) // 2}H")

    def _words(self, look: AxisLook | None) -> tuple[int, ...]:
        return self._field_words.unpack_from(look.packed) if look else ()

    def _fixed(self, look: AxisLook | None, status: int) -> tuple[int, ...]:
        if look is None:
            values = (layout.VERSION, status, 0, 0, self._map.crc, *[NO_I32] * 5, 0)
            return _FIXED_WORDS.unpack(_FIXED.pack(*values))
        said, field = look.motion, self.field
        # Of an axis without a loop the name of its field says that the set-point is an angle.
        is_angle = said.keeps_angle or "commanded_deg" in self._map.info.fields
        set_point = said.commanded_deg if is_angle and said.commanded_deg is not None else nan
        position = said.position_deg if said.position_deg is not None else nan
        current_A = hypot(field(look, "current_a_A"), field(look, "current_b_A"))
        return _FIXED_WORDS.unpack(
            _FIXED.pack(
                layout.VERSION,
                status,
                int(look.failed is not None),
                int(field(look, "mode")) & 0xFFFF,
                self._map.crc,
                _thousandths(position),
                _thousandths(field(look, "velocity_rpm")),
                _thousandths(current_A),
                _thousandths(set_point - position),
                _thousandths(set_point),
                said.at_ns,
            )
        )


def _thousandths(value: float) -> int:
    if not isfinite(value):
        return NO_I32
    return round(min(max(value * 1000, I32_MIN + 1), I32_MAX))
