"""Program of the arm. Console: ``s`` and ``e`` print an angle, all else gets ``?``. Each command is a line at
the logger. On the bus ``#`` is answered with the number of commands so far."""

from array import array
from functools import cache

from hil.vocab.firmware import Axis, Board, ByteAvailable, CoreEvent, Main

COUNTS = 16384
READ_ANGLE = 0xFFFF


@cache
def perfect_table() -> bytes:
    return array("f", [count * 360 / COUNTS for count in range(COUNTS)]).tobytes()


class Arm:
    def __init__(self, board: Board) -> None:
        self.axes = board.axes
        self._console, self._logger, self._bus = (board.uarts[name] for name in ("main", "logger", "bus"))
        self._count = 0

    def main(self) -> Main:
        for axis in self.axes.values():
            axis.write_table(perfect_table())
            hold(axis)
        self._console.write(b"arm\r\n")
        while True:
            yield ByteAvailable()
            for byte in self._console.read_all():
                self._command(chr(byte))
            self._logger.read_all()
            if b"#" in self._bus.read_all():
                self._bus.write(b"=%d;" % self._count)

    def _command(self, letter: str) -> None:
        self._count += 1
        name = {"s": "shoulder", "e": "elbow"}.get(letter)
        said = f"{name} {self.axes[name].get('yw'):.1f}" if name else "?"
        self._console.write(f"{said}\r\n".encode())
        self._logger.write(f"{self._count}: {letter}\r\n".encode())

    def interrupt(self, event: CoreEvent) -> None:
        self._logger.write(f"{event.kind} of {event.axis}\r\n".encode())


def hold(axis: Axis) -> None:
    """Hold the shaft where it is."""
    axis.spi(READ_ANGLE)
    axis.set("mode", ord("x"))
    axis.set("r", (axis.spi(READ_ANGLE) & (COUNTS - 1)) * 360 / COUNTS)
    axis.loop(True)
