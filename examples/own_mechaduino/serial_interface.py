"""Serial interface: the stock commands, and one more: `g` and a number go there at 100 degrees a second."""


def setup(board):
    yield from board.start()


def go(board):
    angle_deg = yield from board.SerialUSB.parseFloat()
    yield from board.moveAbs(angle_deg, 100, 1000)
    board.SerialUSB.println(angle_deg)


def loop(board):
    yield from board.serialCheck({"g": go})
