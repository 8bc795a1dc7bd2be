"""Linux's side of USB/IP, as far as a CDC-ACM device sees it: vhci-hcd, the hub's enumeration, and cdc-acm.

Pure: bytes of the device in (``receive``), bytes for it out (``take``). Made after the sources of Linux 6.1.
"""

import struct
from collections import deque
from collections.abc import Callable, Generator

RET_SUBMIT, RET_UNLINK = 3, 4
READ_URBS = WRITE_URBS = 16
READ_BYTES, WRITE_BYTES = 128, 1280
CONTROL, NOTIFY, BULK_OUT, BULK_IN = 0, 1, 2, 3
_STALL = -32
_GIVEN_UP = (-104, -2, -108)
"""Statuses after which the driver does not ask again."""

Steps = Generator[tuple[bytes, bytes], tuple[int, bytes], None]
"""Control transfers one after the other: setup and data out; status and data in."""


class Urb:
    """Transfer that the device has."""

    def __init__(self, length: int, is_in: bool, done: Callable[[int, bytes], None]) -> None:
        self.length = length
        self.is_in = is_in
        self.done = done
        """Called with status, and what came."""


class LinuxHost:
    """Host, and the program that has the tty open."""

    def __init__(self, bus_id: int = 7) -> None:
        self.bus_id = bus_id
        self._out = bytearray()
        self._in = bytearray()
        self._seqnum = 0
        self.urbs: dict[int, Urb] = {}
        self._unlinks: dict[int, int] = {}
        self.descriptors: dict[tuple[int, int], bytes] = {}
        self.is_bound = False
        """True once there is a tty."""
        self.is_open = self.is_throttled = False
        self.dtr = self.rts = False
        self.coding = (9600, 0, 0, 8)
        self.received = bytearray()
        """Bytes that wait for the program to read."""
        self.most_unread = 1 << 40
        """Number of them from which on the tty asks for no more."""
        self.states: list[int] = []
        """Serial states that it was told."""
        self._unwritten: deque[bytes] = deque()
        self._jobs: deque[Steps] = deque()
        self._is_busy = False
        self.stalls = 0
        self._is_stalled = False
        self._writes = 0

    # ---- wire ----

    def take(self) -> bytes:
        taken = bytes(self._out)
        self._out.clear()
        return taken

    def receive(self, data: bytes) -> None:
        self._in += data
        while len(self._in) >= 48:
            command, seqnum, _, _, _, status, length = struct.unpack_from(">IIIIIii", self._in)
            if command == RET_UNLINK:
                del self._in[:48]
                victim = self._unlinks.pop(seqnum)
                if victim in self.urbs:
                    assert status == -104, "a transfer that waits is given up with ECONNRESET"
                    self.urbs.pop(victim).done(status, b"")
                else:
                    assert status == 0
                continue
            assert command == RET_SUBMIT, command
            urb = self.urbs[seqnum]
            size = length if urb.is_in else 0
            assert 0 <= length <= urb.length, "vhci calls this malicious"
            if len(self._in) < 48 + size:
                return
            came = bytes(self._in[48 : 48 + size])
            del self._in[: 48 + size]
            del self.urbs[seqnum]
            urb.done(status, came if urb.is_in else bytes(length))

    def submit(
        self,
        endpoint: int,
        is_in: bool,
        data: bytes | int,
        done: Callable[[int, bytes], None],
        setup: bytes = bytes(8),
        flags: int = 0,
    ) -> int:
        self._seqnum += 1
        length = data if isinstance(data, int) else len(data)
        self.urbs[self._seqnum] = Urb(length, is_in, done)
        self._out += struct.pack(
            ">IIIIIIiiii8s", 1, self._seqnum, self.bus_id, int(is_in), endpoint, flags, length, 0, 0, 0, setup
        )
        if not isinstance(data, int):
            self._out += data
        return self._seqnum

    def unlink(self, victim: int) -> None:
        self._seqnum += 1
        self._unlinks[self._seqnum] = victim
        self._out += struct.pack(">IIIIII24x", 2, self._seqnum, self.bus_id, 0, 0, victim)

    # ---- control transfers ----

    def run(self, steps: Steps) -> None:
        """Carry out control transfers behind those that were asked for before."""
        self._jobs.append(steps)
        if not self._is_busy:
            self._next((0, b""), begins=True)

    def _next(self, answer: tuple[int, bytes], begins: bool = False) -> None:
        self._is_busy = True
        while self._jobs:
            try:
                setup, data = next(self._jobs[0]) if begins else self._jobs[0].send(answer)
            except StopIteration:
                self._jobs.popleft()
                begins = True
                continue
            is_in = bool(setup[0] & 0x80)
            length = int.from_bytes(setup[6:8], "little")
            self.submit(CONTROL, is_in, length if is_in else data, self._controlled, setup)
            return
        self._is_busy = False

    def _controlled(self, status: int, data: bytes) -> None:
        self.stalls += status == -32
        self._next((status, data))

    def enumerate(self) -> None:
        """Find out what was plugged in, and bind the driver cdc-acm to it."""
        self.run(self._enumerate())

    def _get(self, kind: int, index: int, length: int, language: int = 0) -> Steps:
        status, data = yield get(kind, index, length, language), b""
        assert status == 0, (kind, index, status)
        self.descriptors[kind, index] = data

    def _enumerate(self) -> Steps:
        yield from self._get(1, 0, 64)
        yield from self._get(1, 0, 18)
        yield from self._get(2, 0, 9)
        total = int.from_bytes(self.descriptors[2, 0][2:4], "little")
        yield from self._get(2, 0, total)
        yield from self._get(3, 0, 255)
        for index in self.descriptors[1, 0][14:17]:
            yield from self._get(3, index, 255, 0x0409)
        status, _ = yield request(0x00, 9, 1, 0), b""
        assert status == 0
        yield from self._set_coding()
        self.is_bound = True

    # ---- the tty ----

    def _set_coding(self) -> Steps:
        data = struct.pack("<IBBB", *self.coding)
        yield request(0x21, 0x20, 0, 0, len(data)), data

    def _set_lines(self) -> Steps:
        yield request(0x21, 0x22, self.dtr | self.rts << 1, 0), b""

    def open(self) -> None:
        """Open the tty as the first program."""
        self.run(self._open())

    def _open(self) -> Steps:
        self.is_open, self.is_throttled = True, False
        self.received.clear()
        self._poll()
        yield from self._set_coding()
        for _ in range(READ_URBS):
            self._read()
        self.dtr = self.rts = True
        yield from self._set_lines()

    def close(self, hangs_up: bool = True) -> None:
        """Close the tty as the last program; what is not written yet is lost."""
        self.run(self._close(hangs_up))

    def _close(self, hangs_up: bool) -> Steps:
        if hangs_up:
            self.dtr = self.rts = False
            yield from self._set_lines()
        self.is_open = False
        self._unwritten.clear()
        for seqnum in list(self.urbs):
            if self.urbs[seqnum].done != self._controlled:
                self.unlink(seqnum)

    def set_coding(self, baud: int, stop: int = 0, parity: int = 0, data_bits: int = 8) -> None:
        self.coding = (baud, stop, parity, data_bits)
        self.run(self._set_coding())

    def set_lines(self, *, dtr: bool, rts: bool) -> None:
        self.dtr, self.rts = dtr, rts
        self.run(self._set_lines())

    def send_break(self, duration_ms: int) -> None:
        self.run(iter_once(request(0x21, 0x23, duration_ms, 0)))

    def write(self, data: bytes) -> None:
        """Write as a program: in transfers of at most 1280 bytes, 16 at a time."""
        self._unwritten.extend(data[at : at + WRITE_BYTES] for at in range(0, len(data), WRITE_BYTES))
        self._write()

    @property
    def unwritten(self) -> bool:
        return bool(self._writes or self._unwritten)

    def _write(self) -> None:
        while self._unwritten and self._writes < WRITE_URBS:
            data = self._unwritten.popleft()
            self._writes += 1
            self.submit(BULK_OUT, False, data, self._wrote)

    def _wrote(self, status: int, data: bytes) -> None:
        self._writes -= 1
        self._write()

    def _poll(self) -> None:
        self.submit(NOTIFY, True, 16, self._notified)

    def _notified(self, status: int, data: bytes) -> None:
        if status == 0:
            kind, code, value, interface, length, state = struct.unpack("<BBHHHH", data)
            assert (kind, code, value, interface, length) == (0xA1, 0x20, 0, 0, 2)
            self.states.append(state)
        if self.is_open and status not in _GIVEN_UP:
            self._poll()

    def _read(self) -> None:
        self.submit(BULK_IN, True, READ_BYTES, self._has_read)

    def _has_read(self, status: int, data: bytes) -> None:
        if status == 0:
            self.received += data
        if len(self.received) > self.most_unread:
            self.is_throttled = True
        if status == _STALL:
            self._is_stalled = True
            self.run(self._clear_halt())
        elif self.is_open and not self.is_throttled and status not in _GIVEN_UP:
            self._read()

    def _clear_halt(self) -> Steps:
        if self._is_stalled:
            self._is_stalled = False
            yield request(0x02, 1, 0, BULK_IN | 0x80), b""
            self.unthrottle()

    def read(self) -> bytes:
        """Read as a program what has come."""
        read = bytes(self.received)
        self.received.clear()
        return read

    def unthrottle(self) -> None:
        """Ask for more, after the program has read."""
        self.is_throttled = False
        if not self.is_open:
            return
        waiting = sum(urb.done == self._has_read for urb in self.urbs.values())
        for _ in range(READ_URBS - waiting):
            self._read()


def request(kind: int, code: int, value: int, index: int, length: int = 0) -> bytes:
    return struct.pack("<BBHHH", kind, code, value, index, length)


def get(kind: int, index: int, length: int, language: int = 0) -> bytes:
    return request(0x80, 6, kind << 8 | index, language, length)


def iter_once(setup: bytes, data: bytes = b"") -> Steps:
    yield setup, data
