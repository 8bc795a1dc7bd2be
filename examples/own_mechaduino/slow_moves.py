"""Slow moves: a ramp of the set-point by hand, then the two functions that make trapezoids of speed."""


def setup(board):
    yield from board.start()
    board.enableTCInterrupts()
    board.mode = "x"


def loop(board):
    while board.r < 90:
        board.r += 0.1
        yield board.delayMicroseconds(100)
    yield board.delay(2000)
    yield from board.moveRel(360, 100, 30)
    yield board.delay(2000)
    yield from board.moveAbs(0, 100, 30)
    yield board.delay(2000)
