"""Button: when input D3 goes high the shaft turns to 90 degrees for three seconds, and back to 0."""

from hil.firmware.sketch_waits import HIGH, INPUT


def setup(board):
    yield from board.start()
    board.enableTCInterrupts()
    board.mode = "x"
    board.pinMode(3, INPUT)


def loop(board):
    board.r = 0
    if board.digitalRead(3) == HIGH:
        board.r = 90
        yield board.delay(3000)
