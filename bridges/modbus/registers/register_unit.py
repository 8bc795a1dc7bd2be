"""A unit of Modbus: the registers of one device with their state. It answers values, and what a write asks
of the device; the owner of the device carries that out and tells the unit the result."""

from collections.abc import Mapping, Sequence
from enum import Enum, auto

from bridges.modbus.protocol.pdu import Code, Refused, Span, Table, Write
from bridges.modbus.registers import layout
from bridges.modbus.registers.axis_registers import AxisRegisters
from bridges.modbus.registers.cells import Cell, Halves, WrittenWords, ordered, value_of
from bridges.modbus.registers.map_parts import USUAL
from bridges.modbus.registers.register_map import (
    ControlWord,
    RegisterMap,
    VerbParameters,
    Wanted,
    argument_address,
)
from hil.vocab.desk_protocol import AxisLook


class VerbStage(Enum):
    """Stage of a verb that was started."""

    BUSY = auto()
    DONE = auto()
    REFUSED = auto()


class RegisterUnit:
    """Unit of one device. ``is_low_first``: order of the words of values that take several registers."""

    def __init__(self, of: RegisterMap, *, is_low_first: bool = False) -> None:
        self.map = of
        self._is_low_first = is_low_first
        self._axis = AxisRegisters(of, is_low_first)
        self._parameters = VerbParameters(of, is_low_first)
        self._control = ControlWord(of)
        self._command = 0
        self._levels: dict[str, int] = {}
        """Levels of driven pins that no field tells."""
        self._stages: dict[int, VerbStage] = {}

    manners = USUAL
    looks_before_writes = False

    def needs_look(self, span: Span) -> bool:
        """True if registers or bits of a span have the present state of the axis."""
        end = span.address + span.count
        if not self.map.info.fields:
            return False
        if span.table is Table.COILS:
            return end > layout.INPUTS_AT
        if span.table is Table.DISCRETE_INPUTS:
            return end > layout.PINS_AT and span.address < layout.REFUSED_AT
        is_field = end > layout.FIELDS_AT and span.address < layout.PARAMETERS_AT
        return span.table is Table.INPUT_REGISTERS or is_field

    def read(self, span: Span, look: AxisLook | None, halves: Mapping[int, int]) -> Sequence[int]:
        """Read registers or bits. ``look``: the axis now, if ``needs_look``.

        Raises:
            Refused: one of them is not there.
        """
        if span.table is Table.INPUT_REGISTERS:
            return self._axis.read(span, look, self._status(look))
        self.check(span)
        addresses = range(span.address, span.address + span.count)
        if span.table is Table.HOLDING_REGISTERS:
            return [self._holding(address, look, halves) for address in addresses]
        read = self._coil if span.table is Table.COILS else self._discrete
        return [read(address, look) for address in addresses]

    def check(self, span: Span) -> None:
        """Check that all of a span is there. Raises Refused."""
        for address in range(span.address, span.address + span.count):
            self.map.cell(span.table, address)

    def write(self, write: Write, halves: Halves, look: AxisLook | None = None) -> list[Wanted]:
        """Take registers or coils; answers what is to be done, in the order of their addresses.

        Raises:
            Refused: nothing was taken.
        """
        self.check(Span(write.table, write.address, len(write.values)))
        if write.table is Table.COILS:
            return self._write_coils(dict(enumerate(write.values, write.address)))
        return self._write_registers(dict(enumerate(write.values, write.address)), halves)

    def note(self, wanted: Wanted, stage: VerbStage) -> None:
        """Note how a verb does that a write started. REFUSED: or something else ended its motion; the bit of
        the control word can be written again."""
        if wanted.number is not None:
            self._stages[wanted.number] = stage
        if stage is VerbStage.REFUSED and wanted.bit is not None:
            self._control.clear(wanted.bit)

    def _status(self, look: AxisLook | None) -> int:
        stages = self._stages.values()
        is_busy, is_refused = VerbStage.BUSY in stages, VerbStage.REFUSED in stages
        if look is None:
            return is_busy << 5 | is_refused << 6
        said, has_failed = look.motion, look.failed is not None
        bits = (
            *(bool(said.is_on), said.is_moving, said.is_under_way, said.keeps_angle),
            *(has_failed, is_busy, is_refused),
        )
        return sum(bit << at for at, bit in enumerate(bits))

    def _holding(self, address: int, look: AxisLook | None, halves: Mapping[int, int]) -> int:
        if address in halves:
            return halves[address]
        if address >= layout.PARAMETERS_AT:
            return self._parameters.word(address)
        if address >= layout.FIELDS_AT:
            return self._axis.field_word(address, look)
        if address >= layout.ARGUMENTS_AT:
            is_of_verb = address < layout.ARGUMENTS_AT + self._argument_room(self._command)
            return self._parameters.word(argument_address(self._command, address)) if is_of_verb else 0
        return self._command if address == layout.COMMAND_AT else self._control.word

    def _argument_room(self, command: int) -> int:
        """Number of registers of the parameters of the verb that a command means."""
        verb = self.map.verbs.get(command - 1)
        return len(verb.parameters) * layout.PER_PARAMETER if verb else 0

    def _coil(self, address: int, look: AxisLook | None) -> int:
        if address < layout.INPUTS_AT:
            return int(self._stages.get(address) is VerbStage.BUSY)
        name = self.map.inputs[address - layout.INPUTS_AT]
        if look and (field := self.map.info.inputs[name]):
            return int(self._axis.field(look, field) != 0)
        return self._levels.get(name, 0)

    def _discrete(self, address: int, look: AxisLook | None) -> int:
        if address >= layout.REFUSED_AT:
            return int(self._stages.get(address - layout.REFUSED_AT) is VerbStage.REFUSED)
        if address < layout.PINS_AT:
            return int(self._stages.get(address - layout.DONE_AT) is VerbStage.DONE)
        if address >= layout.STATUS_AT or look is None:
            return self._status(look) >> address - layout.STATUS_AT & 1
        return int(self._axis.field(look, self.map.pin_fields[address - layout.PINS_AT]) != 0)

    def _write_coils(self, bits: Mapping[int, int]) -> list[Wanted]:
        if sum(bit for address, bit in bits.items() if address < layout.INPUTS_AT) > 1:
            raise Refused(Code.ILLEGAL_DATA_VALUE, "one request starts one verb")
        wanted = []
        for address, bit in bits.items():
            if address >= layout.INPUTS_AT:
                name = self.map.inputs[address - layout.INPUTS_AT]
                self._levels[name] = bit
                wanted.append(Wanted("pin", {"pin": name, "level": bit}))
            elif address == layout.RESET_AT:
                wanted += [Wanted("reset", {})] * bit
            elif bit:
                wanted.append(self._started(address))
            elif self._stages.get(address) is not VerbStage.BUSY:
                self._stages.pop(address, None)
        return wanted

    def _write_registers(self, words: dict[int, int], halves: Halves) -> list[Wanted]:
        control = words.pop(layout.CONTROL_AT, None)
        wanted = [] if control is None else self._control.started(control)
        command = words.pop(layout.COMMAND_AT, None)
        if any(address < layout.FIELDS_AT for address in words) or command:
            words = self._as_parameters(words, command or 0)
        written = WrittenWords(words, halves)
        whole = self._complete(words, written)
        for cell, value in whole:
            if cell.address >= layout.PARAMETERS_AT:
                self._parameters.check(cell, value)
        # From here on nothing is refused: what was written is taken.
        self._control.word = self._control.word if control is None else control
        self._command = self._command if command is None else command
        written.keep()
        for cell, value in whole:
            if cell.address >= layout.PARAMETERS_AT:
                self._parameters.put(cell.address, value)
            else:
                wanted.append(Wanted("set", {"field": cell.name, "value": value}))
        return [*wanted, self._started(command - 1)] if command else wanted

    def _as_parameters(self, words: Mapping[int, int], command: int) -> dict[int, int]:
        """Put what was written behind a command where it belongs. Raises Refused."""
        arguments = [address for address in words if address < layout.FIELDS_AT]
        if command - 1 not in self.map.verbs:
            raise Refused(
                Code.ILLEGAL_DATA_VALUE, "command: write 1 + the number of a verb, and its arguments"
            )
        room = self._argument_room(command)
        if len(arguments) % layout.PER_PARAMETER or len(arguments) > room:
            raise Refused(Code.ILLEGAL_DATA_VALUE, f"command: write up to {room} registers of it, in pairs")
        return {
            argument_address(command, address) if address in arguments else address: word
            for address, word in words.items()
        }

    def _complete(self, words: Mapping[int, int], written: WrittenWords) -> list[tuple[Cell, float]]:
        """Values that are complete with what was there before."""
        cells = {(cell := self.map.cell(Table.HOLDING_REGISTERS, a)).address: cell for a in sorted(words)}
        whole = [
            (cell, written.whole(range(cell.address, cell.address + cell.width))) for cell in cells.values()
        ]
        return [
            (cell, value_of(cell.type, ordered(own, self._is_low_first)))
            for cell, own in whole
            if own is not None
        ]

    def _started(self, number: int) -> Wanted:
        given = {"name": self.map.verbs[number].name, "parameters": self._parameters.given(number)}
        return Wanted("do", given, number)
