"""A CANopen drive that is not of this project: SDO server, network management, heartbeat, emergencies and
PDOs are those of the library ``canopen``; the state machine of CiA 402 and a shaft are played here."""

import threading
import time
from collections.abc import Iterable
from typing import Any

import canopen
from canopen import objectdictionary as od

BUSES = iter(range(10**6))
UNITS_PER_TURN = 36_000
NUMBERS = {
    od.UNSIGNED8: 1, od.UNSIGNED16: 2, od.UNSIGNED32: 4, od.INTEGER8: 1, od.INTEGER16: 2, od.INTEGER32: 4,
}  # fmt: skip
RW, RO = "rw", "ro"
OBJECTS: list[tuple[int, int, int, str, int]] = [
    (0x1000, 0, od.UNSIGNED32, RO, 0x0002_0192),
    (0x1016, 0, od.UNSIGNED8, RO, 1),
    (0x1016, 1, od.UNSIGNED32, RW, 0),
    (0x1017, 0, od.UNSIGNED16, RW, 0),
    *((0x1018, at, od.UNSIGNED32, RO, value) for at, value in enumerate((4, 0x1234, 7, 2, 99))),
    (0x6007, 0, od.INTEGER16, RW, 1),
    (0x603F, 0, od.UNSIGNED16, RO, 0),
    (0x6040, 0, od.UNSIGNED16, RW, 0),
    (0x6041, 0, od.UNSIGNED16, RO, 0),
    (0x605A, 0, od.INTEGER16, RW, 2),
    (0x6060, 0, od.INTEGER8, RW, 0),
    (0x6061, 0, od.INTEGER8, RO, 0),
    (0x6064, 0, od.INTEGER32, RO, 0),
    (0x606C, 0, od.INTEGER32, RO, 0),
    (0x6075, 0, od.UNSIGNED32, RW, 2000),
    (0x6078, 0, od.INTEGER16, RO, 250),
    (0x607A, 0, od.INTEGER32, RW, 0),
    (0x6081, 0, od.UNSIGNED32, RW, 20 * UNITS_PER_TURN),
    (0x6083, 0, od.UNSIGNED32, RW, 10**6),
    (0x6084, 0, od.UNSIGNED32, RW, 10**6),
    (0x608F, 0, od.UNSIGNED8, RO, 2),
    (0x608F, 1, od.UNSIGNED32, RW, UNITS_PER_TURN),
    (0x608F, 2, od.UNSIGNED32, RW, 1),
    (0x60C2, 0, od.UNSIGNED8, RO, 2),
    (0x60C2, 1, od.UNSIGNED8, RW, 1),
    (0x60C2, 2, od.INTEGER8, RW, -3),
    (0x6502, 0, od.UNSIGNED32, RO, 0x81),
]


def _pdos() -> Iterable[tuple[int, int, int, str, int]]:
    for number in range(4):
        for base, cob in ((0x1400, 0x200), (0x1800, 0x180)):
            yield base + number, 0, od.UNSIGNED8, RO, 2
            yield base + number, 1, od.UNSIGNED32, RW, cob + 0x100 * number | 1 << 31
            yield base + number, 2, od.UNSIGNED8, RW, 255
            yield base + 0x200 + number, 0, od.UNSIGNED8, RW, 0
            for at in range(1, 9):
                yield base + 0x200 + number, at, od.UNSIGNED32, RW, 0


def dictionary(
    without: Iterable[int] = (), read_only: Iterable[int] = (), **values: int
) -> od.ObjectDictionary:
    """Object dictionary. ``without``: indices that are left out; ``read_only``: those that cannot be written;
    ``values``: other defaults, as x6502=1."""
    found = od.ObjectDictionary()
    records: dict[int, od.ODRecord] = {}
    rows = [*OBJECTS, *_pdos()]
    indices = [row[0] for row in rows]
    for index, subindex, kind, access, default in rows:
        if index in without:
            continue
        variable = od.ODVariable(f"x{index:04X}s{subindex}", index, subindex)
        variable.data_type, variable.access_type = kind, RO if index in read_only else access
        variable.default = values.get(f"x{index:04X}", default) if subindex == 0 else default
        if indices.count(index) == 1:
            found.add_object(variable)
            continue
        if index not in records:
            records[index] = od.ODRecord(f"x{index:04X}", index)
            found.add_object(records[index])
        records[index].add_member(variable)
    return found


class ScriptedDrive:
    """Drive of one node. ``bus``: options of its python-can bus; ``options``: of ``dictionary``."""

    def __init__(self, node: int, bus: dict[str, Any], **options: Any) -> None:
        self.bus, self.number, self.options = bus, node, options
        self.position = 0.0
        self.is_blocked = False
        self.writes: list[tuple[int, int]] = []
        self.syncs: list[tuple[float, int]] = []
        """Times of SYNCs, and the set-points taken with them."""
        self.power_on()

    def power_on(self) -> None:
        self.network = canopen.Network()
        self.network.connect(ignore_config=True, **self.bus)
        self.node = self.network.create_node(self.number, dictionary(**self.options))
        self.node.add_write_callback(self._written)
        self.network.subscribe(0x80, self._synced)
        self.state, self.fault = 0x40, 0
        self._word, self._target, self._has_taken, self._velocity = 0, 0.0, False, 0.0
        self._buffered: int | None = None
        self._since, self._was_operational, self._goal = time.monotonic(), False, None
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._tell()
        self.node.nmt.state = "PRE-OPERATIONAL"
        self.network.send_message(0x700 + self.number, [0])
        self._thread.start()

    def power_off(self) -> None:
        self._ending.set()
        self._thread.join()
        self.node.nmt.stop_heartbeat()
        self.network.disconnect()

    # ---- faults ----

    def fail(self, code: int) -> None:
        """Have a fault, and say so."""
        self.fault, self.state = code, 0x08
        self._put(0x603F, code)
        self.node.emcy.send(code, 0x21, b"\x01\x02")

    @property
    def watched(self) -> int:
        """Its 1016h: whose heartbeat it watches."""
        return self._get(0x1016, 1)

    # ---- its objects ----

    def _put(self, index: int, value: int) -> None:
        self.node.sdo[index].raw = value

    def _get(self, index: int, subindex: int | None = None) -> int:
        record = self.node.sdo[index]
        return int((record if subindex is None else record[subindex]).raw)

    def _written(self, index: int, subindex: int, od: Any, data: bytes) -> None:
        if index in (0x6041, 0x6064, 0x606C, 0x603F, 0x6061):
            return
        value = int.from_bytes(data, "little", signed=index in (0x6060, 0x607A))
        self.writes.append((index, value))
        if index == 0x6040:
            self._control(value)
        elif index == 0x6060:
            self._put(0x6061, value)
            self._goal = None
        self._tell()

    def _control(self, word: int) -> None:
        rose = word & ~self._word
        self._word = word
        if self.state == 0x08:
            if rose & 0x80:
                self.state, self.fault = 0x40, 0
                self._put(0x603F, 0)
                self.node.emcy.reset()
        elif not word & 0x02:
            self.state = 0x40
        elif not word & 0x04:
            self.state = 0x07 if self.state == 0x27 and self._get(0x605A) in (5, 6) else 0x40
            self._goal = None
        elif word & 0x0F == 0x06:
            self.state = 0x21
        elif word & 0x0F == 0x07 and self.state in (0x21, 0x27):
            self.state = 0x23
        elif word & 0x0F == 0x0F and self.state in (0x23, 0x07):
            self.state = 0x27
        if self.state == 0x27 and self._get(0x6061) == 1 and rose & 0x10:
            self._goal, self._has_taken = float(self._get(0x607A)), True
        if not word & 0x10:
            self._has_taken = False

    def _tell(self) -> None:
        is_there = self._goal is None or abs(self._goal - self.position) < 5
        mode = self._get(0x6061)
        status = self.state | (0x400 if is_there and mode == 1 else 0) | (0x1000 if self._has_taken else 0)
        self._put(0x6041, status)
        self._put(0x6064, round(self.position))
        self._put(0x606C, round(self._velocity))

    # ---- its time ----

    def _run(self) -> None:
        while not self._ending.wait(0.002):
            now = time.monotonic()
            seconds, self._since = now - self._since, now
            if self.node.nmt.state != "OPERATIONAL":
                self._was_operational = False
            elif not self._was_operational:
                self._was_operational = True
                for number in (1, 2, 3, 4):
                    self.node.tpdo[number].read()
                    self.node.rpdo[number].read()
                    if self.node.rpdo[number].enabled:
                        self.node.rpdo[number].add_callback(self._buffer)
            before = self.position
            is_halted = self._word & 0x100 or self.is_blocked
            if self.state == 0x27 and not is_halted and self._goal is not None:
                speed = self._get(0x6081) if self._get(0x6061) == 1 else 10**9
                step = speed * seconds
                self.position += max(-step, min(step, self._goal - self.position))
            self._velocity = (self.position - before) / seconds
            self._tell()

    def _buffer(self, pdo: Any) -> None:
        self._buffered = int(pdo["x607As0"].raw)

    def _synced(self, cob_id: int, data: bytes, timestamp: float) -> None:
        if not self._was_operational or self._ending.is_set():
            return
        if self._buffered is not None:
            self._put(0x607A, self._buffered)
            self.syncs.append((time.monotonic(), self._buffered))
            if self._get(0x6061) == 8 and self.state == 0x27:
                self._goal = float(self._buffered)
            self._buffered = None
        for number in (1, 2, 3, 4):
            pdo = self.node.tpdo[number]
            if pdo.enabled and pdo.trans_type <= 240:
                for each in pdo.map:
                    each.raw = self._get(each.index)
                pdo.transmit()


def virtual_bus(name: str | None = None) -> dict[str, Any]:
    """Options of a bus within this process."""
    return {"interface": "virtual", "channel": name or f"bus{next(BUSES)}"}
