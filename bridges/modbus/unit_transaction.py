"""A request to a Modbus unit, carried out: what is looked at, what is asked of the axis, and the answer.

It is a generator that knows neither axis nor time. It yields ``LOOK``, to be sent the axis as it is now, and
each ``Wanted`` operation, to be sent nothing once that is carried out, or thrown the ``VerbRefused`` with
which it is refused; it returns the PDU of the answer. A node on a line runs it at one moment of simulated
time, the door awaits its operations.
"""

from collections.abc import Callable, Generator
from enum import Enum
from typing import Final, Literal, TypeAlias

from bridges.modbus.protocol.identification import Identification, identify
from bridges.modbus.protocol.pdu import Function, Refused, Request, Span, Table, Write, answer
from bridges.modbus.registers.cells import Halves
from bridges.modbus.registers.map_parts import USUAL, Manners
from bridges.modbus.registers.register_map import Wanted
from bridges.modbus.registers.register_unit import VerbStage
from bridges.modbus.registers.registers_protocol import Registers
from hil.vocab.desk_protocol import AxisLook
from hil.vocab.verbs import VerbRefused


class Step(Enum):
    """Step that is no operation."""

    LOOK = "look"


LOOK: Final = Step.LOOK
Look: TypeAlias = Generator[Literal[Step.LOOK], AxisLook | None, AxisLook | None]
Transaction: TypeAlias = Generator[Wanted | Literal[Step.LOOK], AxisLook | None, bytes]


def unit_transaction(
    request: Request, registers: Registers, halves: Halves, identification: Callable[[], Identification]
) -> Transaction:
    """Carry out a request of functions 1 to 6, 15, 16, 22, 23 and 43/14. ``halves``: the client's.

    Raises:
        Refused, VerbRefused: the request is refused. Operations before the one that was are carried out.
    """
    if registers.manners is not USUAL:
        check_manners(registers.manners, request)
    if request.function == Function.ENCAPSULATED_INTERFACE_TRANSPORT:
        return identify(request, identification())
    if request.write or request.mask:
        yield from _written(request, registers, halves)
    if not (span := request.read):
        return answer(request)
    return answer(request, registers.read(span, (yield from _look(registers, span)), halves))


def at_once(
    steps: Transaction, look: Callable[[], AxisLook | None], carry_out: Callable[[Wanted], None]
) -> bytes:
    """Run a transaction without a pause; answers the PDU. ``carry_out`` raises VerbRefused.

    Raises:
        Refused, VerbRefused: the request is refused.
    """
    try:
        step = next(steps)
        while True:
            if step is LOOK:
                step = steps.send(look())
                continue
            try:
                carry_out(step)
            except VerbRefused as refusal:
                step = steps.throw(refusal)
            else:
                step = next(steps)
    except StopIteration as done:
        pdu: bytes = done.value
        return pdu


def _written(request: Request, registers: Registers, halves: Halves) -> Transaction:
    write = request.write
    if mask := request.mask:
        span = Span(Table.HOLDING_REGISTERS, mask.address, 1)
        word = registers.read(span, (yield from _look(registers, span)), halves)[0]
        write = Write(span.table, mask.address, (mask.applied(word),))
    if request.read:  # what cannot be read back is not carried out
        registers.check(request.read)
    seen = (yield LOOK) if write and registers.looks_before_writes else None
    for wanted in registers.write(write, halves, seen) if write else ():
        try:
            yield wanted
        except VerbRefused:
            registers.note(wanted, VerbStage.REFUSED)
            raise
    return b""


def check_manners(manners: Manners, request: Request) -> None:
    """Check that a unit has the function, and takes so many registers. Raises Refused."""
    if manners.functions is not None and request.function not in manners.functions:
        raise Refused(manners.code("function"), f"it has no function {request.function}")
    read, write = request.read, request.write
    for count, most in (
        (read.count if read and read.table in _REGISTERS else 0, manners.reads_most),
        (len(write.values) if write and write.table in _REGISTERS else 0, manners.writes_most),
    ):
        if count > most:
            raise Refused(manners.code("count"), f"{count} registers; one request may have {most}")


_REGISTERS = (Table.HOLDING_REGISTERS, Table.INPUT_REGISTERS)


def _look(registers: Registers, span: Span) -> Look:
    return (yield LOOK) if registers.needs_look(span) else None
