"""Models of a map's rows as they are written: places, cells, commands, states, blocks, moves, manners. The
descriptions are the reference's text."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    SerializerFunctionWrapHandler,
    model_serializer,
)
from pydantic_core import PydanticCustomError

from bridges.modbus.protocol.pdu import ADDRESSES, Table
from bridges.modbus.registers.map_parts import CAUSES, COMMANDS_BY_WORD, CONDITIONS
from hil.config.explain import OR_NULL, DefaultsModel, StrictModel

TABLES = {
    "input": Table.INPUT_REGISTERS,
    "holding": Table.HOLDING_REGISTERS,
    "discrete": Table.DISCRETE_INPUTS,
    "coil": Table.COILS,
}
"""Tables by their words in a map."""
_MOST_SCALE = 1e12
NEW_KEYS = (
    *("word_order", "mask", "registers", "unit", "pole_pairs", "to_rpm"),
    *("times", "per", "decimals", "offset", "at_zero"),
)
"""Keys of a place that version 2 has."""
PART_NAME = "^[A-Za-z][A-Za-z0-9_.]{0,47}$"


def _name_of_cell(value: object) -> object:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    remedy = f"for {value:g} decimals write scale: {10.0**-value:g}" if 0 < value <= 9 else "write scale:"
    what = f"decimals is the cell that has the number of decimals, not the number {value:g}"
    raise PydanticCustomError("decimals", "{what}", {"what": what, "remedy": remedy})


def _usable_scale(value: float) -> float:
    if not 1 / _MOST_SCALE <= abs(value) <= _MOST_SCALE:
        what = f"a scale of {value:g} fits no value" if value else "with a scale of 0 every value is 0"
        remedy = "write what one step of the register is worth, as in 0.01"
        raise PydanticCustomError("scale", what, {"remedy": remedy})
    return value


Address = Annotated[int, Field(ge=0, le=ADDRESSES - 1)]
_Address = Address
_Factor = float | Annotated[str, Field(pattern=PART_NAME)]


class PlaceText(DefaultsModel):
    """Entry of a map: one table with an address, and what is there."""

    input: _Address | None = Field(default=None, description="Input register; the first is 0.")
    holding: _Address | None = Field(default=None, description="Holding register instead.")
    discrete: _Address | None = Field(default=None, description="Discrete input instead, of a bit.")
    coil: _Address | None = Field(default=None, description="Coil instead, of a bit.")
    type: Annotated[
        Literal["u16", "i16", "u32", "i32", "f32", "u48", "i48", "u64", "i64", "f64", "text"], OR_NULL
    ] = Field(
        default="u16",
        description="Of a value, which takes as many registers as the type's bits need. Those from `u48`"
        " on need `modbus_map: 2`.",
    )
    scale: Annotated[float, AfterValidator(_usable_scale), OR_NULL] = Field(
        default=1.0, description="The value is the register's number times this."
    )
    bit: Annotated[int, Field(ge=0, le=15)] | None = Field(
        default=None, description="Number of a bit of a register, 0 for the lowest."
    )

    on_write: Annotated[bool, OR_NULL] = Field(
        default=False,
        description="Of `start`, `stop` and `reset`: true if each write of 1 is a command and the bit clears"
        " itself; false: a command is given when the bit becomes 1.",
    )

    word_order: Literal["high_first", "low_first"] | None = Field(
        default=None,
        description="Order of the words, where it is not that of the map. It needs `modbus_map: 2`,"
        " as all keys below.",
    )
    mask: Annotated[int, Field(ge=1, le=0xFFFF)] | None = Field(
        default=None, description="Bits of a register that have a number, as 0x00F0."
    )
    registers: Annotated[int, Field(ge=1, le=125)] | None = Field(
        default=None, description="Number of registers of a text, two characters each."
    )
    unit: str | None = Field(
        default=None,
        description="Unit of the number: of an angle `deg`, `turn` or `rad`; of a speed `rpm`, `Hz`,"
        " `deg/s` or `turn/s`; of a current `A` or `mA`; of a ramp `rpm/s`, `Hz/s`, `deg/s2` or `turn/s2`,"
        " or `s` or `ms`"
        " from a stand to `to_rpm`. Of a cell a word for people.",
    )
    pole_pairs: Annotated[int, Field(ge=1, le=100)] | None = Field(
        default=None, description="Pole pairs of the motor, for `Hz`."
    )
    to_rpm: Annotated[float, Field(gt=0)] | Annotated[str, Field(pattern=PART_NAME)] | None = Field(
        default=None, description="Speed to which a ramp takes its time, or the cell that has it, in rpm."
    )
    times: _Factor | None = Field(
        default=None, description="Number, or the name of a cell, that the value is multiplied by."
    )
    per: _Factor | None = Field(
        default=None, description="Number, or the name of a cell, that the value is divided by."
    )
    decimals: Annotated[str, Field(pattern=PART_NAME), BeforeValidator(_name_of_cell)] | None = Field(
        default=None, description="Cell with the number of decimals that the register has."
    )
    offset: float | None = Field(default=None, description="Added to the number x `scale`.")
    at_zero: float | None = Field(
        default=None,
        description="Value of the number 0, where the formula does not hold for it: 1000000 of a ramp without"
        " one.",
    )

    @model_serializer(mode="wrap")
    def _as_given(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Dump as ``DefaultsModel``, without keys of version 2 that are not given."""
        dumped: dict[str, Any] = handler(self)
        left_out = {key for key in dumped if self._is_marked(key) and key not in self.model_fields_set}
        dumped |= dict.fromkeys(left_out)
        return {key: each for key, each in dumped.items() if each is not None or key not in NEW_KEYS}

    @property
    def tables(self) -> list[str]:
        """Words of the tables that are named."""
        return [word for word in TABLES if getattr(self, word) is not None]


def _as_tuple(value: object) -> object:
    return tuple(value) if isinstance(value, list) else value


AS_TUPLE = BeforeValidator(_as_tuple)
PartName = Annotated[str, Field(pattern="^[A-Za-z][A-Za-z0-9_]{0,31}$")]
_Number = Annotated[int, Field(ge=0, le=0xFFFF_FFFF)]
_Numbers = Annotated[_Number | tuple[_Number, ...], AS_TUPLE]
_ExceptionCode = Annotated[int, Field(ge=1, le=255)]


def by_number(values: Mapping[Any, int | tuple[int, ...]]) -> dict[int, str]:
    """Words by number; of a number that two have the first."""
    found: dict[int, str] = {}
    for word, numbers in values.items():
        for number in (numbers,) if isinstance(numbers, int) else numbers:
            found.setdefault(number, word)
    return found


class LockText(StrictModel):
    """Lock of a row."""

    cell: Annotated[str, Field(pattern=PART_NAME)] = Field(description="Cell that unlocks it.")
    value: float = Field(description="Value that the cell must have.")
    exception: _ExceptionCode | None = Field(default=None, description="Exception while it is locked.")


class GuardedText(PlaceText):
    """Row that may refuse writes."""

    about: str = Field(default="", description="Meaning, for people.")
    locked_by: LockText | None = Field(
        default=None, description="Lock: `cell` must have `value`; else a write gets `exception`."
    )
    refuse_while: Mapping[str, _ExceptionCode] = Field(
        default={},
        description=f"Exceptions by condition, as in `{{moving: 6}}`: `{'`, `'.join(CONDITIONS)}`.",
    )


class CellText(GuardedText):
    """Plain cell."""

    value: int | str | float | None = Field(
        default=None, description="Its value at first, for good where `access` is `r`; a text of a `text`."
    )
    minimum: float | None = Field(default=None, description="Lowest value that is taken.")
    maximum: float | None = Field(default=None, description="Highest value that is taken.")
    access: Literal["r", "w", "rw"] | None = Field(
        default=None, description="What a master may do; `r` in a table that can only be read, else `rw`."
    )
    stored: Annotated[Literal["never", "at_once", "by_command"], OR_NULL] = Field(
        default="never", description="When what is written survives a restart."
    )
    effect: Annotated[Literal["written", "stored"], OR_NULL] = Field(
        default="written", description="From when on a value is in effect, as the factor of others."
    )


class ByValueText(GuardedText):
    """Register of which each value is a command."""

    values: Mapping[str, _Numbers] = Field(
        default={},
        description="Values by command, one or a list of them, as in `{stop: 1, forward+run: 0x12}`."
        f" Commands: `move_0` and so on, `{'`, `'.join(COMMANDS_BY_WORD)}`.",
    )
    standard: Literal["cia402"] | None = Field(
        default=None, description="Standard of a control word, in place of `values`."
    )
    reads: Annotated[Literal["zero", "written"], OR_NULL] = Field(
        default="zero",
        description="What is read: `zero`, as the command clears itself, or what was `written`.",
    )
    others: Annotated[Literal["refuse", "ignore"], OR_NULL] = Field(
        default="refuse", description="What values do that are no command."
    )


class ModeText(GuardedText):
    """Register of the mode."""

    values: Mapping[Literal["absolute", "relative", "velocity", "home", "search_home"], _Numbers] = Field(
        min_length=1, description="Values by meaning, one or a list of them."
    )
    value: _Number = Field(default=0, description="Its value at first.")
    others: Annotated[Literal["refuse", "ignore"], OR_NULL] = Field(
        default="refuse",
        description="What values do that are no mode: `ignore` keeps them, and `start` does nothing.",
    )


class StateRowText(PlaceText):
    """Register whose value says the state."""

    values: Mapping[str, _Number] = Field(
        default={}, description="Numbers by condition, of which the first that holds counts."
    )
    otherwise: _Number = Field(default=0, description="Number if none holds.")
    standard: Literal["cia402"] | None = Field(
        default=None, description="Standard of a status word, in place of `values`."
    )
    about: str = Field(default="", description="Meaning, for people.")


class AtPlaceText(PlaceText):
    """Value in a block."""

    at: Annotated[int, Field(ge=0, le=122)] = Field(description="Register of the block; the first is 0.")


class AtCellText(CellText):
    """Cell in a block."""

    at: Annotated[int, Field(ge=0, le=122)] = Field(description="Register of the block; the first is 0.")


class AtByValueText(ByValueText):
    """Command in a block."""

    at: Annotated[int, Field(ge=0, le=122)] = Field(description="Register of the block; the first is 0.")


class AtStateRowText(StateRowText):
    """State in a block."""

    at: Annotated[int, Field(ge=0, le=122)] = Field(description="Register of the block; the first is 0.")


class BlockText(StrictModel):
    """Block. Its rows have `at` in place of a table: a register of the block."""

    input: _Address | None = Field(default=None, description="First input register.")
    holding: _Address | None = Field(default=None, description="First holding register instead.")
    registers: Annotated[int, Field(ge=1, le=123)] = Field(description="Number of its registers.")
    then: str | None = Field(
        default=None, description="Command that a write of it is, behind its values, as `enable+run`."
    )
    at_zero_speed: str | None = Field(
        default=None, description="Command in place of `then`, where the speed that is written is 0."
    )
    values: Mapping[str, AtPlaceText] = Field(
        default={}, description="Values of the drive, by name, as at the top of a map."
    )
    cells: Mapping[PartName, AtCellText] = Field(default={}, description="Plain cells.")
    commands: Mapping[PartName, AtByValueText] = Field(default={}, description="Commands by value.")
    states: Mapping[PartName, AtStateRowText] = Field(default={}, description="States.")


class MovesText(StrictModel):
    """Table of moves. Its rows are cells; the places are those of move 0."""

    count: Annotated[int, Field(ge=1, le=256)] = Field(default=1, description="Number of moves.")
    registers: Annotated[int, Field(ge=1, le=1000)] = Field(
        default=8, description="Registers from one move to the next."
    )
    mode: ModeText | None = Field(default=None, description="Mode of a move; left out: all are absolute.")
    position_deg: CellText | None = Field(default=None, description="Its target, or its distance.")
    set_velocity_rpm: CellText | None = Field(default=None, description="Its speed; `value` is in rpm.")
    acceleration_rpm_per_s: CellText | None = Field(default=None, description="Its acceleration.")
    deceleration_rpm_per_s: CellText | None = Field(default=None, description="Its deceleration.")
    cells: Mapping[PartName, CellText] = Field(
        default={}, description="Plain cells that each move has, by name: `move_0.NAME` and so on."
    )


class ReservedText(StrictModel):
    """Registers that are nobody's, and answer."""

    input: _Address | None = Field(default=None, description="First input register.")
    holding: _Address | None = Field(default=None, description="First holding register instead.")
    registers: Annotated[int, Field(ge=1, le=ADDRESSES)] = Field(
        default=1, description="Number of registers."
    )


class ProtocolText(StrictModel):
    """Manners of the drive on the line."""

    functions: Annotated[tuple[Annotated[int, Field(ge=1, le=127)], ...] | None, AS_TUPLE] = Field(
        default=None,
        description="Functions that it has, as in `[3, 6, 16]`; others get the exception `function`."
        " null: all.",
    )
    reads_most: Annotated[int, Field(ge=1, le=125)] = Field(
        default=125, description="Registers that one request may read at most."
    )
    writes_most: Annotated[int, Field(ge=1, le=123)] = Field(
        default=123, description="Registers that one request may write at most."
    )
    pause_ms: Annotated[float, Field(ge=0, le=1000)] = Field(
        default=0, description="Silence behind an answer. What begins within it is not heard."
    )
    gaps: Literal["refuse", "zero"] = Field(
        default="refuse",
        description="What registers do that the map has not: `refuse`, or read as `zero`.",
    )
    halves: Literal["take", "refuse"] = Field(
        default="take",
        description="What a part of a value does, as one register of two: `take`, or `refuse`.",
    )
    exceptions: Mapping[str, _ExceptionCode] = Field(
        default={},
        description="Exceptions of its own, by cause: "
        + ", ".join(f"`{cause}` ({code:d}: {what})" for cause, (code, what) in CAUSES.items())
        + ".",
    )
