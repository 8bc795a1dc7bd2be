"""Limit switch: the shaft turns down until input D3 goes low, and half a turn back up: that is its 0."""

from hil.firmware.sketch_waits import HIGH, INPUT

SPEED_DEG_PER_MS = 0.036  # 6 rpm


def setup(board):
    yield from board.start()
    board.enableTCInterrupts()
    board.mode = "x"
    board.pinMode(3, INPUT)
    board.r = board.yw
    while board.digitalRead(3) == HIGH:
        board.r -= SPEED_DEG_PER_MS
        yield board.delay(1)
    board.home = board.yw + 180


def loop(board):
    board.r = board.home
    yield board.delay(1000)
