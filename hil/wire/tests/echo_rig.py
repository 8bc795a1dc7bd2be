"""A line in simulated time with an adapter that echoes or does not, for what filters its echoes."""

from collections.abc import Callable, Iterable

from bridges.modbus.protocol.exchange import sole_of_frame
from bridges.modbus.protocol.frame import encode
from hil.vocab.ports import EchoState
from hil.vocab.time import FOREVER, NS_PER_MS
from hil.wire.echo import Echo
from hil.wire.serial_line import character_ns, silence_ns

BAUD = 19200
READ = encode(1, 4, bytes((0, 0, 0, 2)))
READ_ANSWER = encode(1, 4, bytes((4, 0, 0, 0, 0)))
WRITE = encode(1, 6, bytes((0, 16, 0, 7)))
"""Write of a register, whose answer has the same bytes."""
TO_ALL = encode(0, 6, bytes((0, 16, 0, 7)))


class EchoLine:
    """Line, and the program at it. ``late_ns``: delay of the adapter; ``in_one``: it gives bytes in one
    piece, when the last is there. ``heard``: what the program gets."""

    def __init__(
        self,
        *,
        echoes: bool,
        baud: int = BAUD,
        late_ns: int = 0,
        in_one: bool = False,
        wanted: bool | None = None,
        is_here: Callable[[int], bool] = lambda unit: False,
        in_pieces: bool = False,
    ) -> None:
        self.echo = Echo(
            baud, wanted=wanted, sole=lambda data: sole_of_frame(data, is_here), in_pieces=in_pieces
        )
        self.echoes, self._late_ns, self._in_one, self._baud = echoes, late_ns, in_one, baud
        self.now_ns = 0
        self.heard = bytearray()
        self._free_ns = 0
        self._coming: list[tuple[int, bytes]] = []

    @property
    def state(self) -> EchoState:
        return self.echo.told.state

    def send(self, data: bytes, spoilt: bytes | None = None) -> None:
        """Send now; ``spoilt``: comes back in place of it."""
        self.echo.sent(data, self.now_ns)
        end_ns = self._on_wire(len(data))
        if self.echoes:
            self._come(data if spoilt is None else spoilt, end_ns)

    def answer(self, data: bytes, after_ns: int | None = None) -> None:
        """Let another station send, after the shortest silence or this one."""
        self._free_ns = max(self._free_ns, self.now_ns)
        self._free_ns += silence_ns(self._baud) if after_ns is None else after_ns
        self._come(data, self._on_wire(len(data)))

    def _on_wire(self, count: int) -> int:
        self._free_ns = max(self._free_ns, self.now_ns) + character_ns(count, self._baud)
        return self._free_ns

    def _come(self, data: bytes, end_ns: int) -> None:
        end_ns += self._late_ns
        if self._in_one:
            self._coming.append((end_ns, data))
            return
        for index in range(len(data)):
            at_ns = end_ns - character_ns(len(data) - 1 - index, self._baud)
            self._coming.append((at_ns, data[index : index + 1]))

    def wait(self, until_ns: int) -> None:
        """Let time pass."""
        while True:
            due_ns, coming = self.echo.due_ns(), min(self._coming, default=(FOREVER, b""))
            at_ns = min(due_ns, coming[0])
            if at_ns > until_ns:
                break
            self.now_ns = max(self.now_ns, at_ns)
            if coming[0] <= due_ns:
                self._coming.remove(coming)
                self.heard += self.echo.received(coming[1])
            else:
                self.heard += self.echo.advance(self.now_ns)
        self.now_ns = until_ns

    def rest(self, ms: float = 400) -> bytes:
        """Let all come that comes; answers what was heard since the last rest."""
        self.wait(self.now_ns + round(ms * NS_PER_MS))
        heard = bytes(self.heard)
        self.heard.clear()
        return heard

    def known(self) -> "EchoLine":
        """The same line, after it has become known."""
        for _ in range(4):
            self.send(READ)
            self.rest()
        return self


def pieces(data: bytes, sizes: Iterable[int]) -> list[bytes]:
    """Cut data into pieces of these sizes, and the rest."""
    cut = []
    for size in sizes:
        cut.append(data[:size])
        data = data[size:]
    return [each for each in (*cut, data) if each]
