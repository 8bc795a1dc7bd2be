"""Unit of a map of version 2: the same contract as ``DriveUnit``, with all that such a map says.

It keeps nothing but the map. What a master writes becomes verbs of the board: ``put`` with all values and
cells of the request, at once; then the commands, one by one. So a log has inputs of the board, and every door
and every node shows the same.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from bridges.modbus.protocol.pdu import Refused, Span, Table, Write
from bridges.modbus.registers.cells import Halves, WrittenWords
from bridges.modbus.registers.control_states import words_of_control
from bridges.modbus.registers.drive_map import DriveMap, RegisterPlace
from bridges.modbus.registers.map_entries import MapEntries, MapRow
from bridges.modbus.registers.map_now import ASKED, DONE, HOMING, MODE, MapNow
from bridges.modbus.registers.map_parts import CIA402, CellPart, CommandPart
from bridges.modbus.registers.register_map import Wanted
from bridges.modbus.registers.register_unit import VerbStage
from hil.vocab.desk_protocol import AxisLook, DeviceInfo
from hil.vocab.drive_words import cells_text, is_finite

MOST = {"acceleration_rpm_per_s": 1e6, "deceleration_rpm_per_s": 1e6}
"""Values of ramps that take no time."""
_NO_RAMP = 1e9
"""Ramp of a move that takes no time, as its cell has it: the number 0 is read back as 0."""
MOVE = "move_"
_MOTIONS = ("start", "run", MOVE, "stop", "halt", "disable")
"""Beginnings of the commands that end a way home."""
_STARTS = {"velocity": "run", "home": "home", "search_home": "search_home", "relative": "start_relative"}
"""Words that `start` is, by the mode; of another mode `start_absolute`."""
_MOVE_VALUES = ("set_velocity_rpm", "acceleration_rpm_per_s", "deceleration_rpm_per_s")


class _Taken:
    """Contents of one write: values, control bits, fields, cells, and commands in their order."""

    def __init__(self) -> None:
        self.values: dict[str, float] = {}
        self.bits: dict[str, float] = {}
        self.cleared: dict[str, float] = {}
        self.fields: dict[str, float] = {}
        self.cells: dict[str, float] = {}
        self.stored: list[str] = []
        self.words: list[str] = []


class MapUnit:
    """Unit of one board, ``bridges.modbus.registers.registers_protocol.Registers``.

    Long because all that a write of one request means is decided together, before any of it is taken.
    """

    def __init__(self, of: DriveMap, info: DeviceInfo) -> None:
        self.map = MapEntries(of, info)
        self.manners = of.parts.manners
        self._of, self._is_low_first = of, of.is_low_first

    def needs_look(self, span: Span) -> bool:
        """True always: every register is the board's."""
        return True

    @property
    def looks_before_writes(self) -> bool:
        """True: what a write means depends on cells and states."""
        return True

    # ---- reads ----

    def read(self, span: Span, look: AxisLook | None, halves: Mapping[int, int]) -> Sequence[int]:
        """Read registers or bits, all of one moment. What the board does not tell is 0.

        Raises:
            Refused: one of them is not there, or can only be written.
        """
        span = self.map.span(span)
        self.map.check(span)
        self._check_halves(span)
        now = MapNow(self.map, look)
        elements = dict(halves) if span.table is Table.HOLDING_REGISTERS else {}
        addresses = range(span.address, span.address + span.count)
        for address in addresses:
            if address not in elements:
                elements = self._elements(span.table, address, now) | elements
        return [elements[address] for address in addresses]

    def _elements(self, table: Table, address: int, now: MapNow) -> dict[int, int]:
        """Bits or words, by their addresses, of what is at an address."""
        rows = self.map.at.get((table, address), ())
        readable = [row for row in rows if row.is_read]
        if rows and not readable:
            where = f"{table.value.removesuffix('s')} {address & 0xFFFF}, {rows[0].name}"
            raise Refused(self.manners.code("write_only"), f"{where}, can only be written")
        words: dict[int, int] = {address: 0}
        for row in readable:
            place = row.place
            value = now.number(row)
            if place.is_bit:
                words[address] |= (value != 0) << (place.bit or 0)
                continue
            own = self._place(place, now).words(_finite(value), is_low_first=self._is_low_first)
            for at, word in enumerate(own, place.address):
                words[at] = words.get(at, 0) | word
        return words

    def _place(self, place: RegisterPlace, now: MapNow) -> RegisterPlace:
        return place.resolved(now.cell)

    def check(self, span: Span) -> None:
        """Check that all of a span is there. Raises Refused."""
        self.map.check(self.map.span(span))

    def _check_halves(self, span: Span) -> None:
        """Refuse a part of a value, where the drive does. Raises Refused."""
        if not self.manners.is_whole:
            return
        end = span.address + span.count
        for address in (span.address, end - 1):
            for row in self.map.at.get((span.table, address), ()):
                first = row.place.address
                if first < span.address or first + row.place.width > end:
                    raise Refused(self.manners.code("half"), f"{row.name} is read and written as a whole")

    # ---- writes ----

    def write(self, write: Write, halves: Halves, look: AxisLook | None = None) -> list[Wanted]:
        """Take registers or coils; answers what is to be done. A value of which a register is missing waits
        for it.

        Raises:
            Refused: nothing was taken.
        """
        span = self.map.span(Span(write.table, write.address, len(write.values)))
        self.map.check(span)
        self._check_halves(span)
        now, taken = MapNow(self.map, look), _Taken()
        words = dict(enumerate(write.values, span.address))
        written = WrittenWords(words, halves)
        for row in self._rows(write.table, words):
            self._guard(row, now)
            place = row.place
            if place.is_bit:
                self._take(row, words[place.address] >> (place.bit or 0) & 1, taken, now)
                continue
            own = written.whole(range(place.address, place.address + place.width))
            if own is not None:
                value = self._place(place, now).value(own, is_low_first=self._is_low_first)
                self._take(row, value, taken, now)
        if block := self.map.blocks.get((write.table, write.address)):
            is_still = block.at_zero_speed and not taken.values.get("set_velocity_rpm", 1)
            taken.words += block.at_zero_speed if is_still else block.words
        wanted = list(self._wanted(taken, now))
        # From here on nothing is refused: what was written is taken.
        written.keep()
        return wanted

    def note(self, wanted: Wanted, stage: VerbStage) -> None:
        """Note nothing: the board's own values tell how it does."""

    def _rows(self, table: Table, words: Mapping[int, int]) -> list[MapRow]:
        """Rows that a write has a part of, each once. Raises Refused: one of them is only told, or a bit
        means nothing."""
        found: dict[int, MapRow] = {}
        for address, word in words.items():
            rows = self.map.at.get((table, address), ())
            where = f"{table.value.removesuffix('s')} {address & 0xFFFF}"
            if rows and not any(row.is_taken for row in rows):
                raise Refused(self.manners.code("read_only"), f"{where}, {rows[0].name}, can only be read")
            known = 0
            for row in rows:
                place = row.place
                known |= 0xFFFF if place.bit is None and place.mask is None else _mask(place)
                if row.is_taken:
                    found[id(row)] = row
            if rows and word & ~known and not self.manners.reads_gaps:
                bit = (word & ~known).bit_length() - 1
                raise Refused(self.manners.code("value"), f"{where}: bit {bit} means nothing")
        return list(found.values())

    def _guard(self, row: MapRow, now: MapNow) -> None:
        guard = row.guard
        if guard.locked_by is not None and now.kept(guard.locked_by) != guard.unlocked:
            code = self.manners.code("locked") if guard.locked is None else guard.locked
            raise Refused(code, f"{row.name} is locked by {guard.locked_by}")
        for condition, code in guard.refused.items():
            if now.holds(condition):
                raise Refused(code, f"{row.name} is not taken while the drive is {condition}")

    def _take(self, row: MapRow, value: float, taken: _Taken, now: MapNow) -> None:
        name, part = row.name, row.part
        if isinstance(part, CommandPart):
            self._take_command(row, part, int(value), taken, now)
        elif isinstance(part, CellPart):
            if name.startswith(MOVE) and name.rpartition(".")[2] in MOST:
                value = min(value, _NO_RAMP)
            if not is_finite(value) or not part.lowest <= value <= part.highest:
                limits = f"{part.lowest:g} to {part.highest:g}"
                raise Refused(self.manners.code("value"), f"{name}: {value:g} is not within {limits}")
            taken.cells[name] = value
            if part.keeps == "at_once":
                taken.stored.append(name)
        elif row.room == "control":
            taken.bits[name] = value
            if row.place.on_write and value:
                taken.cleared[name] = 0
        else:
            value = min(value, MOST[name]) if name in MOST else value
            if not is_finite(value):
                raise Refused(self.manners.code("value"), f"{name}: {value} is no number that can be used")
            value = value + now.origin_deg if name == "set_point_deg" else value
            (taken.fields if row.room == "parameter" else taken.values)[name] = value

    def _take_command(self, row: MapRow, part: CommandPart, number: int, taken: _Taken, now: MapNow) -> None:
        if part.is_kept or part.sets_mode:
            taken.cells[row.name] = number
        if part.standard == CIA402:
            words, kept = words_of_control(now, number)
            taken.words += words
            taken.cells |= kept
        elif part.sets_mode:
            if number not in part.sets_mode and not part.ignores_others:
                raise Refused(self.manners.code("value"), f"{row.name}: {number:X}h is no mode")
        elif number in part.words:
            taken.words += part.words[number]
        elif not part.ignores_others:
            raise Refused(self.manners.code("value"), f"{row.name}: {number:X}h is no command")

    # ---- what is to be done ----

    def _wanted(self, taken: _Taken, now: MapNow) -> Iterable[Wanted]:
        given: dict[str, Any] = dict(taken.values)
        if taken.cells:
            given["cells"] = cells_text(taken.cells)
        if given:
            yield _do("put", **given)
        if taken.bits:
            yield _do("write", **taken.bits)
        if taken.cleared:
            yield _do("write", **taken.cleared)
        yield from (Wanted("set", {"field": name, "value": value}) for name, value in taken.fields.items())
        words = (*taken.words, *self._words_of_mode(taken, now))
        if now.kept(HOMING) and "search_home" in words:
            yield _do("put", cells=cells_text({HOMING: 0}))
        elif now.kept(HOMING) == ASKED and any(word.startswith(_MOTIONS) for word in words):
            yield _do("put", cells=cells_text({HOMING: DONE if now.holds("homed") else 0}))
        for word in words:
            yield from self._of_word(word, taken, now)
        if taken.stored:
            yield _do("store", names=" ".join(taken.stored))

    def _words_of_mode(self, taken: _Taken, now: MapNow) -> list[str]:
        """Commands that a new mode of CiA 402 is while the drive is on: it turns at once, or stops."""
        row = self._of.parts.commands.get(MODE)
        has_standard = any(part.standard for _, part in self._of.parts.commands.values())
        if MODE not in taken.cells or row is None or not has_standard or not now.holds("enabled"):
            return []
        mode = row[1].sets_mode.get(int(taken.cells[MODE]), "")
        if mode == now.mode:
            return []
        return ["run"] if mode == "velocity" else ["stop"] if now.holds("running") else []

    def _of_word(self, word: str, taken: _Taken, now: MapNow) -> Iterable[Wanted]:
        mode = now.mode
        if MODE in taken.cells and (row := self._of.parts.commands.get(MODE)):
            mode = row[1].sets_mode.get(int(taken.cells[MODE]), "")
        if word == "start":
            word = _STARTS.get(mode, "start_absolute")
        if word.startswith(MOVE):
            yield from self._of_move(word, taken, now)
        elif word in ("start_absolute", "start_relative"):
            target_deg = taken.values.get("set_point_deg", now.told("set_point_deg") + now.origin_deg)
            if word == "start_absolute":
                yield _do("move_abs", position_deg=target_deg)
            else:
                yield _do("move_rel", angle_deg=target_deg - now.origin_deg)
        elif word == "start_directed":
            turn = next((each for each in reversed(taken.words) if each in ("forward", "reverse")), "")
            is_reversed = turn == "reverse" if turn else now.holds("reversed")
            angle_deg = taken.values.get("set_point_deg", now.told("set_point_deg") + now.origin_deg)
            angle_deg -= now.origin_deg
            yield _do("move_rel", angle_deg=-angle_deg if is_reversed else angle_deg)
        elif word == "home":
            yield _do("move_abs", position_deg=now.origin_deg)
            yield _do("put", cells=cells_text({HOMING: ASKED}))
        elif word in ("forward", "reverse"):
            yield _do("put", reverse=float(word == "reverse"))
        elif word == "turn_about":
            yield _do("put", reverse=float(not now.holds("reversed")))
        elif word in ("stop", "halt"):
            yield _do("stop", how="grace" if word == "stop" else "prejudice")
        elif word == "store":
            kept = [name for name, (_, part) in self._of.parts.cells.items() if part.keeps == "by_command"]
            yield _do("store", names=" ".join(kept))
        elif word == "restore":
            defaults = {
                name: part.default for name, (_, part) in self._of.parts.cells.items() if part.is_written
            }
            yield _do("put", cells=cells_text(defaults))
            yield _do("store", names=" ".join(defaults))
        elif word != "nothing":
            yield _do({"reset": "clear_fault", "zero": "origin"}.get(word, word))

    def _of_move(self, word: str, taken: _Taken, now: MapNow) -> Iterable[Wanted]:
        """Start a row of the table of moves."""
        moves = self._of.parts.moves

        def value(name: str) -> float | None:
            if name not in moves.names:
                return None
            cell = f"{word}.{name}"
            return taken.cells.get(cell, now.cell(cell))

        ramps: dict[str, Any] = {}
        for name in _MOVE_VALUES:
            given = value(name)
            if given is not None:
                ramps[name.removeprefix("set_")] = min(given, MOST.get(name, given))
        mode = moves.modes.get(int(value("mode") or 0), "absolute" if not moves.modes else "")
        target_deg = value("position_deg") or 0.0
        if mode == "velocity":
            yield _do("run", **ramps)
        elif mode == "relative":
            yield _do("move_rel", angle_deg=target_deg, **ramps)
        elif mode == "home":
            yield _do("move_abs", position_deg=now.origin_deg, **ramps)
            yield _do("put", cells=cells_text({HOMING: ASKED}))
        elif mode == "absolute":
            yield _do("move_abs", position_deg=target_deg + now.origin_deg, **ramps)
        else:
            raise Refused(self.manners.code("value"), f"{word}: its mode {value('mode'):g} is none")


def _do(verb: str, **parameters: Any) -> Wanted:
    return Wanted("do", {"name": verb, "parameters": parameters})


def _mask(place: RegisterPlace) -> int:
    return place.mask if place.mask is not None else 1 << (place.bit or 0)


def _finite(value: float) -> float:
    return value if is_finite(value) else 0.0
