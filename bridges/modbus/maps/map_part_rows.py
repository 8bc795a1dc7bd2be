"""Rows of a map's parts, each with its place: what can be read of them, whatever is wrong with the others."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from pydantic import BaseModel, ValidationError

from bridges.modbus.maps.map_places import OTHER, place_of, quantity_of
from bridges.modbus.maps.map_row_models import (
    TABLES,
    AtByValueText,
    AtCellText,
    AtPlaceText,
    AtStateRowText,
    BlockText,
    ByValueText,
    CellText,
    ModeText,
    PlaceText,
    StateRowText,
)
from bridges.modbus.protocol.pdu import Table
from bridges.modbus.registers.drive_map import RegisterPlace
from bridges.modbus.registers.map_parts import BlockPart
from hil.config.document import KeyPath

MOVE_NAMES = ("mode", "position_deg", "set_velocity_rpm", "acceleration_rpm_per_s", "deceleration_rpm_per_s")
_ROOMS: Mapping[str, type[PlaceText]] = {"cells": CellText, "commands": ByValueText, "states": StateRowText}
_AT_ROOMS: Mapping[str, type[PlaceText]] = {
    "values": AtPlaceText,
    "cells": AtCellText,
    "commands": AtByValueText,
    "states": AtStateRowText,
}
_BIT_TABLES = ("discrete", "coil")


class PartRow(NamedTuple):
    """Row of a part. ``path``: to it in the map; ``kind``: value, cell, command or state; ``block``: where it
    is in, None: in a table; ``move``: number of its move."""

    path: KeyPath
    kind: str
    name: str
    text: Any
    block: BlockPart | None = None
    move: int = 0

    @property
    def quantity(self) -> str:
        """Quantity that its unit is of."""
        return quantity_of(self.name) if self.kind == "value" or self.path[0] == "moves" else OTHER

    @property
    def is_bit(self) -> bool:
        """True if it is one bit: of a table of bits, or of a register."""
        return self.kind != "value" and (
            self.text.bit is not None or any(table in _BIT_TABLES for table in self.text.tables)
        )

    @property
    def place(self) -> RegisterPlace | None:
        """Its place; None: no table is given, or several."""
        text = self.text
        if self.block is not None:
            table, address = self.block.table, self.block.base + text.at
        elif len(text.tables) == 1:
            (word,) = text.tables
            table, address = TABLES[word], getattr(text, word)
        else:
            return None
        place = place_of(self.name, text, table, address, is_bit=self.is_bit, quantity=self.quantity)
        return replace(place, bit=text.bit) if self.is_bit else place


def part_rows(given: object) -> Iterator[PartRow]:
    """Rows of a map's parts that can be read, in file order."""
    for key, value in given.items() if isinstance(given, dict) else ():
        if key in _ROOMS and isinstance(value, dict):
            for name, each in value.items():
                if (text := _read(_ROOMS[key], each)) is not None:
                    yield PartRow((key, name), key.removesuffix("s"), str(name), text)
        elif key == "mode" and (text := _read(ModeText, value)) is not None:
            yield PartRow((key,), "command", key, text)
        elif key == "blocks" and isinstance(value, dict):
            yield from _block_rows(value)
        elif key == "moves" and isinstance(value, dict):
            yield from _move_rows(value)


def as_given(of: BaseModel) -> dict[Any, Any]:
    """Mapping of a text as it was written, whose rows are models: it need not be read twice."""
    found: dict[Any, Any] = {}
    for name in type(of).model_fields:
        value = getattr(of, name)
        if isinstance(value, PlaceText):
            found[name] = value
        elif isinstance(value, BaseModel):
            found[name] = as_given(value)
        elif isinstance(value, Mapping):
            found[name] = {
                key: as_given(each) if isinstance(each, BlockText) else each for key, each in value.items()
            }
        elif value is not None:
            found[name] = value
    return found


def blocks_of(given: object) -> dict[str, BlockPart]:
    """Blocks that can be read, by name."""
    blocks = given.get("blocks") if isinstance(given, dict) else None
    found = {}
    for number, (name, each) in enumerate(blocks.items() if isinstance(blocks, dict) else (), 1):
        head = {
            key: each[key]
            for key in ("input", "holding", "registers", "then", "at_zero_speed")
            if isinstance(each, dict) and each.get(key) is not None
        }
        text = _read(BlockText, head)
        if text is None or (text.input is None) == (text.holding is None):
            continue
        table = Table.INPUT_REGISTERS if text.input is not None else Table.HOLDING_REGISTERS
        address = text.input if text.input is not None else text.holding
        words = text.then.split("+") if text.then else ()
        at_zero = tuple(text.at_zero_speed.split("+")) if text.at_zero_speed else ()
        found[str(name)] = BlockPart(number, table, address, text.registers, tuple(words), at_zero)
    return found


def _block_rows(blocks: Mapping[Any, Any]) -> Iterator[PartRow]:
    known = blocks_of({"blocks": blocks})
    for name, each in blocks.items():
        block = known.get(str(name))
        if block is None:
            continue
        for room, model in _AT_ROOMS.items():
            rows = each.get(room)
            for row, value in rows.items() if isinstance(rows, dict) else ():
                if (text := _read(model, value)) is not None:
                    kind = room.removesuffix("s")
                    yield PartRow(("blocks", name, room, row), kind, str(row), text, block)


def _move_rows(moves: Mapping[Any, Any]) -> Iterator[PartRow]:
    count, step = moves.get("count", 1), moves.get("registers", 8)
    if not (isinstance(count, int) and 1 <= count <= 256 and isinstance(step, int) and 1 <= step <= 1000):
        return
    own_cells = moves.get("cells")
    named: dict[KeyPath, Any] = {
        ("moves", name): value for name, value in moves.items() if name in MOVE_NAMES
    }
    if isinstance(own_cells, dict):
        named |= {("moves", "cells", name): value for name, value in own_cells.items()}
    for path, value in named.items():
        name = str(path[-1])
        text = _read(ModeText if path == ("moves", "mode") else CellText, value)
        if text is None:
            continue
        for move in range(count):
            shifted = {table: getattr(text, table) + move * step for table in text.tables if move}
            own = text.model_copy(update=shifted) if shifted else text
            yield PartRow(path, "cell", name, own, move=move)


def _read(model: type[PlaceText] | type[BlockText], value: object) -> Any:
    if isinstance(value, model):
        return value
    try:
        return model.model_validate(value)
    except ValidationError:
        return None  # told by the check of the whole map
