"""Parts of a map as a unit and a client use them, of a text without findings."""

from math import inf
from typing import Any

from bridges.modbus.maps.drive_map_model import MapText
from bridges.modbus.maps.map_part_rows import PartRow, as_given, blocks_of, part_rows
from bridges.modbus.maps.map_row_models import (
    ByValueText,
    CellText,
    GuardedText,
    ModeText,
    StateRowText,
    by_number,
)
from bridges.modbus.protocol.pdu import ADDRESSES, Table
from bridges.modbus.registers.drive_map import MapParts, RegisterPlace
from bridges.modbus.registers.map_parts import (
    FREE,
    CellPart,
    CommandPart,
    Manners,
    MovesPart,
    StatePart,
    WriteGuard,
)
from hil.vocab.time import NS_PER_MS

READ_ONLY = (Table.INPUT_REGISTERS, Table.DISCRETE_INPUTS)


def parts_of(of: MapText) -> tuple[MapParts, list[tuple[str, RegisterPlace]]]:
    """Parts of a map of version 2, and values that are in blocks, in file order."""
    given = as_given(of)
    cells: dict[str, tuple[RegisterPlace, CellPart]] = {}
    commands: dict[str, tuple[RegisterPlace, CommandPart]] = {}
    states: dict[str, tuple[RegisterPlace, StatePart]] = {}
    values: list[tuple[str, RegisterPlace]] = []
    for row in part_rows(given):
        place = row.place
        assert place is not None
        if row.path[0] == "moves":
            cells[f"move_{row.move}.{row.name}"] = place, _move_cell(row, place)
        elif isinstance(row.text, CellText):
            cells[row.name] = place, cell_part(row.text, place)
        elif isinstance(row.text, ModeText):
            commands[row.name] = place, _mode(row.text)
        elif isinstance(row.text, ByValueText):
            commands[row.name] = place, _command(row.text)
        elif isinstance(row.text, StateRowText):
            states[row.name] = place, _state(row.text)
        else:
            values.append((row.name, place))
    protocol = of.protocol
    manners = Manners(
        None if protocol.functions is None else frozenset(protocol.functions),
        protocol.reads_most,
        protocol.writes_most,
        round(protocol.pause_ms * NS_PER_MS),
        protocol.gaps == "zero",
        protocol.halves == "refuse",
        dict(protocol.exceptions),
    )
    reserved = tuple(
        (Table.INPUT_REGISTERS, each.input, min(each.registers, ADDRESSES - each.input))
        if each.input is not None
        else (Table.HOLDING_REGISTERS, each.holding or 0, min(each.registers, ADDRESSES))
        for each in of.reserved
    )
    blocks = blocks_of(given)
    return MapParts(cells, commands, states, blocks, (), _moves(of), reserved, manners), values


def _moves(of: MapText) -> MovesPart:
    moves = of.moves
    if moves is None:
        return MovesPart()
    names = frozenset(
        name
        for name in type(moves).model_fields
        if name not in ("count", "registers", "cells") and getattr(moves, name)
    )
    return MovesPart(moves.count, names, by_number(moves.mode.values) if moves.mode else {})


def _move_cell(row: PartRow, place: RegisterPlace) -> CellPart:
    if isinstance(row.text, ModeText):
        text = row.text
        return CellPart(
            text.value, guard=_guard(text), about=text.about or f"mode of move {row.move}: {_modes(text)}"
        )
    part = cell_part(row.text, place)
    about = part.about or f"move {row.move}"
    return CellPart(**{**vars(part), "about": about, "unit": part.unit or row.name.rpartition("_")[2]})


def _modes(text: ModeText) -> str:
    return ", ".join(f"{number:X}h {mode}" for number, mode in by_number(text.values).items())


def cell_part(text: CellText, place: RegisterPlace) -> CellPart:
    """Part that a cell is."""
    access = text.access or ("r" if place.table in READ_ONLY else "rw")
    return CellPart(
        number_of(text, place),
        -inf if text.minimum is None else text.minimum,
        inf if text.maximum is None else text.maximum,
        "r" in access,
        "w" in access,
        text.stored,
        text.effect == "stored",
        text.unit or "",
        text.about,
        _guard(text),
    )


def number_of(text: CellText, place: RegisterPlace) -> float:
    """Value of a cell at first; of a text the number that stands for it."""
    value: Any = text.value
    if value is None:
        return 0
    if isinstance(value, str):
        data = value.encode("latin-1", "replace").ljust(2 * place.count, b"\0")
        return int.from_bytes(data[: 2 * place.count], "big")
    return float(value) if isinstance(value, float) else int(value)


def _guard(text: GuardedText) -> WriteGuard:
    lock = text.locked_by
    if lock is None and not text.refuse_while:
        return FREE
    return WriteGuard(
        lock.cell if lock else None,
        lock.value if lock else 0.0,
        lock.exception if lock else None,
        dict(text.refuse_while),
    )


def _command(text: ByValueText) -> CommandPart:
    words = {number: tuple(each.split("+")) for number, each in by_number(text.values).items()}
    about = text.about or ", ".join(f"{number:X}h {' and '.join(each)}" for number, each in words.items())
    is_kept = text.reads == "written"
    return CommandPart(
        words, is_kept, text.others == "ignore", text.standard or "", {}, 0, _guard(text),
        about or "control word of CiA 402",
    )  # fmt: skip


def _mode(text: ModeText) -> CommandPart:
    return CommandPart(
        {}, True, text.others == "ignore", "", by_number(text.values), text.value, _guard(text),
        text.about or f"mode: {_modes(text)}",
    )  # fmt: skip


def _state(text: StateRowText) -> StatePart:
    numbers = tuple(text.values.items())
    said = ", ".join(f"{number:X}h {condition}" for condition, number in numbers)
    about = text.about or (f"{said}, else {text.otherwise:X}h" if said else "status word of CiA 402")
    return StatePart(numbers, text.otherwise, text.standard or "", about)
