"""Register map of a device: made of its fields, verbs and inputs, whatever board it is.

Numbers follow the order of the tables. A field keeps its place in the binary layout of a snapshot, a verb its
place in the table of its kind, where new ones are appended.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import isnan, nan
from typing import Any, NamedTuple
from zlib import crc32

from bridges.modbus.protocol.pdu import Code, Refused, Table
from bridges.modbus.registers import layout
from bridges.modbus.registers.cells import BIT, I32_MAX, I32_MIN, NO_I32, Cell, ordered, value_of, words_of
from hil.vocab.desk_protocol import DeviceInfo
from hil.vocab.parameters import Parameter
from hil.vocab.verbs import COMMON, Verb

_EVERY_BOARDS = frozenset(verb.name for verb in COMMON)


@dataclass(frozen=True, eq=False)
class RegisterMap:
    """Register map. ``verbs``: those that can be started, by number; ``inputs``: names of pins that may be
    driven, from coil ``layout.INPUTS_AT`` on; ``notes``: what is not in it, and why."""

    device: str
    profile: str
    cells: tuple[Cell, ...]
    verbs: Mapping[int, Verb]
    inputs: tuple[str, ...]
    has_reset: bool
    pin_fields: tuple[str, ...]
    """Fields that tell levels of pins, from discrete input ``layout.PINS_AT`` on."""
    info: DeviceInfo
    notes: tuple[str, ...]
    version: int = layout.VERSION

    @property
    def identity(self) -> Mapping[str, str]:
        """Texts of what it says that it is: none of its own."""
        return {}

    @cached_property
    def at(self) -> Mapping[tuple[Table, int], Cell]:
        """The cell at each address that has one."""
        return {(cell.table, cell.address + i): cell for cell in self.cells for i in range(cell.width)}

    def cell(self, table: Table, address: int) -> Cell:
        """The cell at an address. Raises Refused: there is none."""
        if (cell := self.at.get((table, address))) is None:
            where = f"{table.name.lower().replace('_', ' ').removesuffix('s')} {address}"
            raise Refused(Code.ILLEGAL_DATA_ADDRESS, f"there is no {where}")
        return cell

    @cached_property
    def crc(self) -> int:
        """CRC-32 of the map, which is another when anything in it is."""
        return crc_of(self.cells, layout.VERSION)


def crc_of(cells: Iterable[Cell], version: int) -> int:
    """CRC-32 of what is where."""
    rows = (f"{c.table.name} {c.address} {c.width} {c.type} {c.name} {c.unit}\n" for c in cells)
    return crc32(f"{version}\n{''.join(rows)}".encode())


def register_map(info: DeviceInfo) -> RegisterMap:
    """Make the map of a device, or of another axis of one."""
    notes: list[str] = []
    verbs = dict(_verbs(info, notes))
    inputs = tuple(info.inputs)[: layout.PINS]
    pin_fields = tuple(name for name in info.fields if name.startswith("pin_"))[: layout.PINS]
    has_reset = "reset" in info.verbs
    cells = [
        *_fixed(info),
        *_status_bits(info),
        *_fields(info),
        *_control(verbs, has_reset),
        *_command(verbs),
    ]
    for number, verb in verbs.items():
        cells += _of_verb(number, verb)
    if has_reset:
        about = info.verbs["reset"].about
        cells.append(Cell(Table.COILS, layout.RESET_AT, BIT, "reset", "", f"1: {about}", True))
    for at, name in enumerate(inputs):
        cells.append(
            Cell(
                Table.COILS, layout.INPUTS_AT + at, BIT, f"input.{name}", "", f"drive the input {name}", True
            )
        )
    for at, name in enumerate(pin_fields):
        about = f"1 while it is not 0: {info.fields[name].meaning}"
        cells.append(Cell(Table.DISCRETE_INPUTS, layout.PINS_AT + at, BIT, name, "", about))
    if not info.fields:
        notes.append("it tells no state, so there are no registers of it")
    tables = list(Table)
    cells.sort(key=lambda cell: (tables.index(cell.table), cell.address))
    return RegisterMap(
        info.name, info.profile, tuple(cells), verbs, inputs, has_reset, pin_fields, info, tuple(notes)
    )


def _verbs(info: DeviceInfo, notes: list[str]) -> Iterator[tuple[int, Verb]]:
    """Number the verbs of the kind. What takes a text keeps its number, without registers."""
    own = [verb for verb in info.verbs.values() if verb.name not in _EVERY_BOARDS]
    for number, verb in enumerate(own):
        if any(each.is_text or each.form for each in verb.parameters):
            notes.append(f"{verb.name} takes a text, for which there are no registers")
        elif number >= layout.VERBS or len(verb.parameters) * layout.PER_PARAMETER > layout.PER_VERB:
            notes.append(f"{verb.name} finds no room")
        else:
            yield number, verb
    if "type" in info.verbs:
        notes.append("type takes a text, for which there are no registers")


def _fixed(info: DeviceInfo) -> Iterator[Cell]:
    """Block that is alike for all kinds. What a kind has not is a gap."""

    def cell(address: int, type_name: str, name: str, unit: str, about: str) -> Cell:
        return Cell(Table.INPUT_REGISTERS, address, type_name, name, unit, about)

    yield cell(0, "u16", "map_version", "", f"version of the layout: {layout.VERSION}")
    yield cell(4, "u32", "map_crc", "", "CRC-32 of this map: another one when it has changed")
    if not info.fields:
        return
    bits = ", ".join(f"{bit} {name}" for bit, (name, _) in enumerate(layout.STATUS))
    yield cell(1, "u16", "status", "", f"status word: {bits}")
    yield cell(2, "u16", "fault", "", "0 none, 1 the board's firmware has stopped")
    if "mode" in info.fields:
        yield cell(3, "u16", "mode", "", info.fields["mode"].meaning)
    yield cell(6, "i32", "position", "0.001 deg", "angle of the axis; 80000000h: it does not tell")
    if "velocity_rpm" in info.fields:
        yield cell(8, "i32", "velocity", "0.001 rpm", info.fields["velocity_rpm"].meaning)
    if "current_a_A" in info.fields and "current_b_A" in info.fields:
        yield cell(10, "i32", "current", "mA", "of both coils, the root of the sum of squares")
    yield cell(12, "i32", "following_error", "0.001 deg", "set-point less position; 80000000h: no angle")
    yield cell(14, "i32", "set_point", "0.001 deg", "the set-point, if it is an angle; else 80000000h")
    yield cell(16, "u64", "time", "ns", "simulated time of this read")


def _status_bits(info: DeviceInfo) -> Iterator[Cell]:
    for bit, (name, about) in enumerate(layout.STATUS if info.fields else ()):
        yield Cell(Table.DISCRETE_INPUTS, layout.STATUS_AT + bit, BIT, f"status.{name}", "", about)


def _fields(info: DeviceInfo) -> Iterator[Cell]:
    for field in info.fields.values():
        address = layout.FIELDS_AT + field.offset // 2
        cell = Cell(Table.INPUT_REGISTERS, address, field.type, field.name, field.unit, field.meaning)
        yield cell
        if field.is_settable:
            yield Cell(
                Table.HOLDING_REGISTERS, address, field.type, field.name, field.unit, field.meaning, True
            )


def _control(verbs: Mapping[int, Verb], has_reset: bool) -> Iterator[Cell]:
    if words := [
        f"{bit} {name}" for bit, name in enumerate(layout.CONTROL) if name in startable(verbs, has_reset)
    ]:
        about = f"control word, a bit that becomes 1 starts: {', '.join(words)}"
        yield Cell(Table.HOLDING_REGISTERS, layout.CONTROL_AT, "u16", "control", "", about, True)


def startable(verbs: Mapping[int, Verb], has_reset: bool) -> frozenset[str]:
    """Names of verbs that a bit of the control word starts: those that need no parameters."""
    free = {
        verb.name
        for verb in verbs.values()
        if all(each.is_optional or each.default is not None for each in verb.parameters)
    }
    return frozenset(free | ({"reset"} if has_reset else set()))


def _command(verbs: Mapping[int, Verb]) -> Iterator[Cell]:
    if not verbs:
        return
    about = "1 + the number of a verb: starts it, with what is written to the following registers at once"
    yield Cell(Table.HOLDING_REGISTERS, layout.COMMAND_AT, "u16", "command", "", about, True)
    about = "the verb's parameters, as from its first register on"
    count = layout.ARGUMENT_REGISTERS
    yield Cell(Table.HOLDING_REGISTERS, layout.ARGUMENTS_AT, "u16", "arguments", "", about, True, count)


def _of_verb(number: int, verb: Verb) -> Iterator[Cell]:
    yield Cell(Table.COILS, layout.STARTS_AT + number, BIT, verb.name, "", f"1 starts it: {verb.about}", True)
    done = f"{verb.name} has been carried out, and its motion has ended"
    yield Cell(Table.DISCRETE_INPUTS, layout.DONE_AT + number, BIT, f"{verb.name}.done", "", done)
    refused = f"{verb.name} was refused, or something else ended its motion"
    yield Cell(Table.DISCRETE_INPUTS, layout.REFUSED_AT + number, BIT, f"{verb.name}.refused", "", refused)
    for at, parameter in enumerate(verb.parameters):
        address = layout.PARAMETERS_AT + number * layout.PER_VERB + at * layout.PER_PARAMETER
        name = f"{verb.name}.{parameter.name}"
        about = parameter.described()
        if parameter.choices:
            about += f"; {', '.join(f'{i} {word}' for i, word in enumerate(parameter.choices))}"
        yield Cell(
            Table.HOLDING_REGISTERS, address, parameter_type(parameter), name, parameter.unit, about, True
        )


def parameter_type(parameter: Parameter) -> str:
    """Type of a parameter's registers, always two: whole numbers and choices are i32, all else f32."""
    is_i32 = parameter.minimum >= I32_MIN and parameter.maximum <= I32_MAX
    return "i32" if parameter.choices or (parameter.is_whole and is_i32) else "f32"


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


class VerbParameters:
    """Parameters of all verbs of a map. ``is_low_first``: order of the words."""

    def __init__(self, of: RegisterMap, is_low_first: bool) -> None:
        self._map = of
        self._is_low_first = is_low_first
        self._words: dict[int, int] = {}
        self._parameters: dict[int, Parameter] = {}
        for number, verb in of.verbs.items():
            for at, parameter in enumerate(verb.parameters):
                address = _address_of(number, at)
                self._parameters[address] = parameter
                self.put(address, _preset(parameter))

    def word(self, address: int) -> int:
        """Word of a register; 0 where no parameter has one."""
        return self._words.get(address, 0)

    def check(self, cell: Cell, value: float) -> None:
        """Check a parameter's value. Raises Refused."""
        parameter = self._parameters[cell.address]
        if _is_left_out(cell.type, value):
            return
        if parameter.choices:
            if not 0 <= value < len(parameter.choices):
                raise Refused(Code.ILLEGAL_DATA_VALUE, f"{cell.name}: {int(value)} is none of its choices")
        elif problem := parameter.problem(value):
            raise Refused(Code.ILLEGAL_DATA_VALUE, f"{cell.name}: {problem}")

    def put(self, address: int, value: float) -> None:
        """Keep the value of the parameter whose first register this is."""
        words = ordered(words_of(parameter_type(self._parameters[address]), value), self._is_low_first)
        self._words |= dict(enumerate(words, address))

    def given(self, number: int) -> dict[str, Any]:
        """Parameters of a verb by name, without those left out."""
        given: dict[str, Any] = {}
        for at, parameter in enumerate(self._map.verbs[number].parameters):
            first, kind = _address_of(number, at), parameter_type(parameter)
            words = tuple(self._words[first + i] for i in range(layout.PER_PARAMETER))
            value = value_of(kind, ordered(words, self._is_low_first))
            if not _is_left_out(kind, value):
                given[parameter.name] = parameter.choices[int(value)] if parameter.choices else value
        return given


def argument_address(command: int, address: int) -> int:
    """Address of the parameter's register for which one of the command block stands."""
    return _address_of(command - 1, 0) + address - layout.ARGUMENTS_AT


def _address_of(number: int, at: int) -> int:
    return layout.PARAMETERS_AT + number * layout.PER_VERB + at * layout.PER_PARAMETER


def _preset(parameter: Parameter) -> float:
    kind = parameter_type(parameter)
    if parameter.default is None:
        return NO_I32 if kind == "i32" else nan
    if parameter.choices:
        return parameter.choices.index(str(parameter.default))
    return float(parameter.default)


def _is_left_out(kind: str, value: float) -> bool:
    return value == NO_I32 if kind == "i32" else isnan(value)
