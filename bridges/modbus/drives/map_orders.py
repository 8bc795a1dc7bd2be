"""Orders to a real drive by a map of version 2: the writes that are a command, a move, or a speed."""

from collections.abc import Callable, Iterator, Mapping, Sequence

from bridges.modbus.drives.control_bits import RegisterWrite, settings_beside, value_write
from bridges.modbus.protocol.pdu import Table
from bridges.modbus.registers.drive_map import DriveMap, RegisterPlace, lowest_bit
from bridges.modbus.registers.map_parts import CIA402, MODES, BlockPart, CommandPart
from hil.drives.drive_fields import FOLLOW_RPM, FOLLOW_RPM_PER_S

MODE, START_WORDS = "mode", ("start_absolute", "start")
_TABLES = 1 << 16
_SHUTDOWN, _SWITCH_ON, _OPERATE = 0x0006, 0x0007, 0x000F
_START, _HALT, _RESET = 0x0010, 0x0100, 0x0080
_CIA402: Mapping[str, tuple[int, ...]] = {
    "enable": (_SHUTDOWN, _SWITCH_ON, _OPERATE),
    "disable": (_SHUTDOWN,),
    "start_absolute": (_OPERATE, _OPERATE | _START),
    "run": (_OPERATE,),
    "stop": (_OPERATE | _HALT,),
    "reset": (0, _RESET, 0),
}
"""Control words of CiA 402 by command, one after the other."""
_IN_BLOCKS: Mapping[str, float] = {
    "set_velocity_rpm": FOLLOW_RPM,
    "acceleration_rpm_per_s": FOLLOW_RPM_PER_S,
    "deceleration_rpm_per_s": FOLLOW_RPM_PER_S,
}
"""Values of a block that a move leaves out: it is written as a whole."""
_FREE = ("enable", "nothing", "forward")
"""Words that may stand beside one that is looked for."""
Writes = tuple[RegisterWrite, ...]


class MapOrders:
    """Orders by one map. ``cell``: answers the value of a cell by its name, as it was read last."""

    def __init__(self, of: DriveMap, cell: Callable[[str], float]) -> None:
        self._of, self._parts, self._cell = of, of.parts, cell

    def knows(self, word: str) -> bool:
        """True if there is a write for a command."""
        values = {"set_point_deg": 0.0} if word == "start_absolute" and self._parts.moves.count else {}
        return self.order(word, values) is not None

    def order(self, word: str, values: Mapping[str, float] | None = None) -> list[Writes] | None:
        """Writes of a command and of the values that it needs, one step behind the other; None: the map has
        no such command. Raises ValueError: the registers cannot hold a value."""
        given = dict(values or {})
        if (standard := self._standard()) is not None and word in _CIA402:
            steps = [self._values(given), self._mode(word)]
            steps += [(self._number_write(standard, word_of),) for word_of in _CIA402[word]]
            return [step for step in steps if step]
        if word == "start_absolute" and (move := self._move(given)) is not None:
            return move
        if (block := self._block(word)) is not None:
            return [(self._block_write(block, given),)]
        if (found := self._command(word, is_reversed=given.pop("reverse", 0) != 0)) is None:
            return None
        return [step for step in (self._values(given), self._mode(word), found) if step]

    def value(self, name: str, value: float) -> Writes:
        """Write of one value, or of none where the map has it in blocks alone."""
        return self._values({name: value})

    # ---- how ----

    def _standard(self) -> RegisterPlace | None:
        rows = self._parts.commands.values()
        return next((place for place, part in rows if part.standard == CIA402), None)

    def _values(self, values: Mapping[str, float]) -> Writes:
        found = []
        for name, value in values.items():
            place = self._of.values.get(name)
            if place is not None and place.address < _TABLES:
                found.append(value_write(self._of, place.resolved(self._cell), value))
        return tuple(found)

    def _mode(self, word: str) -> Writes:
        """Write of the mode that a command needs, if the map has modes."""
        wanted = {"run": "velocity"}.get(word, "absolute" if word in START_WORDS else "")
        row = self._parts.commands.get(MODE)
        if not wanted or row is None:
            return ()
        number = next((number for number, mode in row[1].sets_mode.items() if mode == wanted), None)
        return () if number is None else (self._number_write(row[0], number),)

    def _number_write(self, place: RegisterPlace, number: int) -> RegisterWrite:
        if (bits := place.bits) is None:
            words = (number,) if place.is_bit else place.words(number)
        else:
            words = (number << lowest_bit(bits) & bits,)
        return RegisterWrite(place.table, place.address, words, settings_beside(self._of, place))

    def _numbers(self, word: str) -> Iterator[tuple[RegisterPlace, int]]:
        """Places and numbers of a command: those that are it alone first."""
        rows: list[tuple[int, RegisterPlace, int]] = []
        for place, part in self._parts.commands.values():
            for number, words in part.words.items():
                if word in words and all(each == word or each in _FREE for each in words):
                    rows.append((len(words), place, number))
        yield from ((place, number) for _, place, number in sorted(rows, key=lambda row: row[0]))

    def _command(self, word: str, *, is_reversed: bool) -> Writes | None:
        known = (word, "start") if word == "start_absolute" else (word, "halt") if word == "stop" else (word,)
        found = next((row for each in known for row in self._numbers(each)), None)
        if found is None or found[0].address >= _TABLES:
            return None
        own = self._number_write(*found)
        if word != "run":
            return (own,)
        direction = "reverse" if is_reversed else "forward"
        beside = next((self._number_write(*row) for row in self._numbers(direction)), None)
        if beside is None:
            return (own,)
        if (beside.table, beside.address) == (own.table, own.address):
            words = (own.words[0] | beside.words[0],)
            return (RegisterWrite(own.table, own.address, words, own.keeps & beside.keeps),)
        return beside, own

    def _move(self, values: Mapping[str, float]) -> list[Writes] | None:
        """A row of the table of moves, and its trigger."""
        moves = self._parts.moves
        trigger = self._command("move_0", is_reversed=False) if moves.count else None
        if trigger is None or "set_point_deg" not in values:
            return None
        names = {"set_point_deg": "position_deg"}
        writes = []
        for name, value in values.items():
            row = self._parts.cells.get(f"move_0.{names.get(name, name)}")
            if row is not None:
                writes.append(value_write(self._of, row[0].resolved(self._cell), value))
        mode = next((number for number, each in moves.modes.items() if each == MODES[0]), None)
        if mode is not None:
            writes.insert(0, value_write(self._of, self._parts.cells["move_0.mode"][0], mode))
        return [tuple(writes), trigger]

    def _block(self, word: str) -> BlockPart | None:
        """Block of which a write is a command."""
        for block in self._parts.blocks.values():
            if word in block.words and all(each == word or each in _FREE for each in block.words):
                return block
        return None

    def _block_write(self, block: BlockPart, values: Mapping[str, float]) -> RegisterWrite:
        words = [0] * block.registers

        def put(place: RegisterPlace, own: Sequence[int]) -> None:
            for at, word in enumerate(own, place.address - block.base):
                words[at] |= word

        for name, place in (*self._of.values.items(), *self._parts.also):
            if self._is_in(place, block):
                value = values.get(name, _IN_BLOCKS.get(name))
                resolved = place.resolved(self._cell)
                if value is None:
                    continue
                if not resolved.holds(value):
                    raise ValueError(f"the registers of the drive cannot hold {value:g}")
                put(place, resolved.words(value, is_low_first=self._of.is_low_first))
        for place, part in self._parts.commands.values():
            if self._is_in(place, block):
                put(place, self._number_write(place, self._direction(part, values)).words)
        return RegisterWrite(block.table, block.address, tuple(words))

    @staticmethod
    def _direction(part: CommandPart, values: Mapping[str, float]) -> int:
        wanted = "reverse" if values.get("reverse") else "forward"
        return next((number for number, words in part.words.items() if words == (wanted,)), 0)

    @staticmethod
    def _is_in(place: RegisterPlace, block: BlockPart) -> bool:
        return place.table is Table.HOLDING_REGISTERS and place.address >> 16 == block.number
