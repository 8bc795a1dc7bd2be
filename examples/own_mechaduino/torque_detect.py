"""Torque detect: a push at the shaft takes it on by 90 degrees, the way it was pushed."""


def setup(board):
    yield from board.start()
    board.enableTCInterrupts()
    board.mode = "x"


def loop(board):
    if board.u > 35:
        board.r -= 90
        yield board.delay(100)
    elif board.u < -35:
        board.r += 90
        yield board.delay(100)
