"""A request carried out step by step: what is looked at, what is asked of the axis, in which order."""

from collections.abc import Mapping, Sequence

import pytest

from bridges.modbus.protocol.client_side import mask_write, read, read_write, write
from bridges.modbus.protocol.identification import Identification
from bridges.modbus.protocol.pdu import Code, Refused, Request, Span, Table, Write
from bridges.modbus.registers.map_parts import USUAL
from bridges.modbus.registers.register_map import Wanted
from bridges.modbus.registers.register_unit import Halves, VerbStage
from bridges.modbus.unit_transaction import LOOK, Transaction, at_once, unit_transaction
from hil.vocab.axis import AxisState
from hil.vocab.desk_protocol import AxisLook
from hil.vocab.time import SimTimeNs
from hil.vocab.verbs import VerbRefused

HOLDING = Table.HOLDING_REGISTERS
NOW = AxisLook(b"", AxisState(SimTimeNs(9), 0.0, 0.0, False, False), None)


class Cells:
    """Ten holding registers: a write to one is a verb with its number, from 8 on it has to be looked for."""

    map = None
    manners = USUAL
    looks_before_writes = False

    def __init__(self) -> None:
        self.words = [0] * 10
        self.noted: list[tuple[int | None, VerbStage]] = []
        self.looks: list[AxisLook | None] = []

    def needs_look(self, span: Span) -> bool:
        return span.address + span.count > 8

    def check(self, span: Span) -> None:
        if span.address + span.count > 10:
            raise Refused(Code.ILLEGAL_DATA_ADDRESS, "none is there")

    def read(self, span: Span, look: AxisLook | None, halves: Mapping[int, int]) -> Sequence[int]:
        self.check(span)
        self.looks.append(look)
        return [halves.get(at, self.words[at]) for at in range(span.address, span.address + span.count)]

    def write(self, write: Write, halves: Halves, look: AxisLook | None = None) -> list[Wanted]:
        self.check(Span(write.table, write.address, len(write.values)))
        for at, word in enumerate(write.values, write.address):
            self.words[at] = word
        return [Wanted("do", {"value": word}, at) for at, word in enumerate(write.values, write.address)]

    def note(self, wanted: Wanted, stage: VerbStage) -> None:
        self.noted.append((wanted.number, stage))


def steps(cells: Cells, request: Request, halves: Halves | None = None) -> Transaction:
    def identity() -> Identification:
        raise AssertionError("nobody asked who it is")

    return unit_transaction(request, cells, {} if halves is None else halves, identity)  # type: ignore[arg-type]


def done(cells: Cells, request: Request, halves: Halves | None = None) -> tuple[bytes, list[int | None]]:
    wanted: list[int | None] = []
    pdu = at_once(steps(cells, request, halves), lambda: NOW, lambda each: wanted.append(each.number))
    return pdu, wanted


def test_a_reading_looks_at_the_axis_only_if_it_has_to() -> None:
    cells = Cells()
    assert done(cells, read(HOLDING, 2, 2)) == (b"\x03\x04\0\0\0\0", [])
    assert done(cells, read(HOLDING, 7, 2)) == (b"\x03\x04\0\0\0\0", [])
    assert cells.looks == [None, NOW]


def test_a_write_asks_for_one_operation_after_the_other_and_is_answered_behind_them() -> None:
    cells = Cells()
    under_way = steps(cells, write(HOLDING, 3, (5, 6)))
    assert [next(under_way), under_way.send(None)] == [
        Wanted("do", {"value": 5}, 3),
        Wanted("do", {"value": 6}, 4),
    ]
    with pytest.raises(StopIteration) as over:
        next(under_way)
    assert over.value.value == b"\x10\0\x03\0\x02"


def test_what_is_refused_is_noted_and_ends_the_request() -> None:
    cells = Cells()
    tried: list[int | None] = []

    def carry_out(wanted: Wanted) -> None:
        tried.append(wanted.number)
        if wanted.number == 4:
            raise VerbRefused("not_now", "it is busy")

    with pytest.raises(VerbRefused, match="busy"):
        at_once(steps(cells, write(HOLDING, 3, (5, 6, 7))), lambda: NOW, carry_out)
    assert tried == [3, 4]  # the third is not tried
    assert cells.noted == [(4, VerbStage.REFUSED)]


def test_a_mask_changes_what_is_there_also_of_half_a_value() -> None:
    cells = Cells()
    cells.words[8] = 0x8001
    pdu, wanted = done(cells, mask_write(8, 0xFFFD, 2))
    assert (pdu, wanted, cells.words[8]) == (b"\x16\0\x08\xff\xfd\0\x02", [8], 0x8003)
    assert cells.looks == [NOW]
    done(cells, mask_write(2, 0xFFFB, 4), {2: 0x10})
    assert cells.words[2] == 0x14


def test_what_cannot_be_read_back_is_not_carried_out() -> None:
    cells = Cells()
    with pytest.raises(Refused):
        done(cells, read_write(9, 2, 0, (7,)))
    assert cells.words[0] == 0
    pdu, wanted = done(cells, read_write(0, 1, 0, (7,)))
    assert (pdu, wanted) == (b"\x17\x02\0\x07", [0])


def test_the_first_step_of_a_mask_is_a_look() -> None:
    assert next(steps(Cells(), mask_write(9, 0, 0))) is LOOK
