"""A firmware in handlers: bytes at each of its UARTs, and ticks that do not drift."""

from hil.firmware.board_handlers import BoardHandlers
from hil.firmware.runtime import RxBuffer
from hil.vocab.address import DeviceParts
from hil.vocab.firmware import Board, ByteAvailable

MS = 1_000_000


class Line(RxBuffer):
    """UART of which only the receive buffer is there."""

    baud = None


class Heard(BoardHandlers):
    TICK_NS = 10 * MS

    def setup(self):
        self.calls = ["setup"]

    def received(self, uart, data):
        self.calls.append((uart, data))

    def tick(self):
        self.calls.append(self.board.millis())


class Untimed(Heard):
    TICK_NS = None


def board_at(times):
    lines = DeviceParts({"main": Line(64), "log": Line(64)})
    return Board(uarts=lines, axes=DeviceParts({}), nvm={}, clock=lambda: times["now"])


def test_bytes_and_ticks_come_to_their_handlers():
    times = {"now": 0}
    board = board_at(times)
    sketch = Heard(board)
    main = sketch.main()
    assert next(main) == ByteAvailable(timeout_ns=10 * MS)
    board.uarts["log"].feed(b"ab")
    board.uarts["main"].feed(b"c")
    times["now"] = 4 * MS
    assert main.send(True) == ByteAvailable(timeout_ns=6 * MS)
    times["now"] = 10 * MS
    assert main.send(False) == ByteAvailable(timeout_ns=10 * MS)
    times["now"] = 33 * MS  # it was held up: two are due
    assert main.send(False) == ByteAvailable(timeout_ns=7 * MS)
    assert sketch.calls == ["setup", ("main", b"c"), ("log", b"ab"), 10, 33, 33]


def test_without_ticks_it_waits_for_bytes():
    sketch = Untimed(board_at({"now": 0}))
    main = sketch.main()
    assert next(main) == ByteAvailable()
    assert main.send(True) == ByteAvailable()
    assert sketch.calls == ["setup"]
