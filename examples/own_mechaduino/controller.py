"""Controller of one's own: a spring of 2 counts a degree with a damper, 6,500 times a second."""

yw_1 = None


def setup(board):
    yield from board.start()
    board.enableTCInterrupts()


def controller(board):
    global yw_1
    speed = 0.0 if yw_1 is None else board.yw - yw_1
    yw_1 = board.yw
    board.e = board.r - board.yw
    board.u = max(-board.uMAX, min(board.uMAX, 2 * board.e - 60 * speed))
    board.output(-(board.y + (board.PA if board.u > 0 else -board.PA)), abs(board.u))


def loop(board):
    yield from board.serialCheck()
