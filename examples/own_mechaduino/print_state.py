"""Print: set-point and error ten times a second, beside the commands of the stock firmware."""


def setup(board):
    yield from board.start()
    board.enableTCInterrupts()
    board.mode = "x"


def loop(board):
    yield from board.serialCheck()
    board.SerialUSB.print("setpoint: ")
    board.SerialUSB.print(board.r)
    board.SerialUSB.print(", error: ")
    board.SerialUSB.println(board.e)
    yield board.delay(100)
