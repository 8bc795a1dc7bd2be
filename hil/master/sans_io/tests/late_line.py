"""A line between a master and a tap that is late, and says things twice."""

from collections import deque
from collections.abc import Iterator

from hil.vocab.line_node import LineMaster
from hil.vocab.time import FOREVER


class LateLine:
    """Master behind a line that holds up what comes: the next delay (ns) for each packet, in order; 0 when
    there are no more. ``doubled``: for each packet whether it comes twice."""

    def __init__(self, master: LineMaster, delays_ns: Iterator[int], doubled: Iterator[bool]) -> None:
        self.master = master
        self._delays_ns, self._doubled = delays_ns, doubled
        self._packet = b""
        self._coming: deque[tuple[int, bytes]] = deque()
        self._now_ns = 0

    def receive(self, data: bytes, at_ns: int) -> None:
        for byte in data:
            self._packet += bytes((byte,))
            if len(self._packet) > 5 and byte == 0 and self._packet[-3] == 3:
                last_ns = self._coming[-1][0] if self._coming else 0
                come_ns = max(at_ns + next(self._delays_ns, 0), last_ns)
                self._coming.append((come_ns, self._packet * (1 + next(self._doubled, False))))
                self._packet = b""
        self._hand_on(at_ns)

    def due_ns(self) -> int:
        return min(self.master.due_ns(), self._coming[0][0] if self._coming else FOREVER)

    def advance(self, now_ns: int) -> None:
        self._hand_on(now_ns)
        if self.master.due_ns() <= now_ns:
            self.master.advance(now_ns)

    def to_send(self) -> bytes:
        return self.master.to_send()

    def _hand_on(self, now_ns: int) -> None:
        while self._coming and self._coming[0][0] <= now_ns:
            at_ns, data = self._coming.popleft()
            self.master.receive(data, max(at_ns, self._now_ns))
            self._now_ns = max(at_ns, self._now_ns)
