"""A serial line with an adapter whose receiver stays on, played at a pseudo-terminal."""

import os
import select
import threading
import time
import tty
from pathlib import Path


class EchoingLine(threading.Thread):
    """Adapter at ``path``: what is sent there comes back, ``late_s`` after its time on the line, in one piece
    or by characters. ``sent``: all that was sent."""

    def __init__(
        self, path: Path, baud: int, *, echoes: bool = True, late_s: float = 0.0, in_one: bool = False
    ) -> None:
        super().__init__(daemon=True)
        self._fd, self._end = os.openpty()
        tty.setraw(self._fd)
        tty.setraw(self._end)
        path.symlink_to(os.ttyname(self._end))
        self._character_s, self._echoes, self._late_s, self._in_one = 10 / baud, echoes, late_s, in_one
        self.sent = bytearray()
        self._free_s = 0.0
        self._coming: list[tuple[float, bytes]] = []
        self._is_over = False
        self.start()

    def run(self) -> None:
        while not self._is_over:
            next_s = self._coming[0][0] - time.monotonic() if self._coming else 0.05
            if select.select([self._fd], [], [], min(max(next_s, 0), 0.05))[0]:
                self._take(os.read(self._fd, 512))
            while self._coming and self._coming[0][0] <= time.monotonic():
                os.write(self._fd, self._coming.pop(0)[1])

    def _take(self, data: bytes) -> None:
        self.sent += data
        start_s = max(time.monotonic(), self._free_s)
        self._free_s = start_s + len(data) * self._character_s
        if self._echoes and self._in_one:
            self._coming.append((self._free_s + self._late_s, data))
        elif self._echoes:
            for index in range(len(data)):
                at_s = start_s + (index + 1) * self._character_s + self._late_s
                self._coming.append((at_s, data[index : index + 1]))

    def say(self, data: bytes) -> None:
        """Send from another station."""
        os.write(self._fd, data)

    def close(self) -> None:
        self._is_over = True
        self.join()
        os.close(self._fd)
        os.close(self._end)
