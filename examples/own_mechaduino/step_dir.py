"""Step and direction: position mode from the start; a pulse at D1 is a sixteenth of a step, and counted."""

STEP_DEG = 1.8 / 16
pulses = 0


def setup(board):
    yield from board.start()
    board.configureStepDir()
    board.enableTCInterrupts()
    board.mode = "x"


def step_interrupt(board):
    global pulses
    pulses += 1
    board.r += STEP_DEG if board.dir else -STEP_DEG


def loop(board):
    if board.SerialUSB.available() and board.SerialUSB.read() == ord("?"):
        board.SerialUSB.println(pulses)
