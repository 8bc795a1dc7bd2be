"""Bytes that come at a port with the simulated time of each: a capture that runs beside it."""

import socket
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from hil.cli.captures.capture_files import Records, blocks_of
from hil.net.control_client import begin
from hil.wire.pcapng import RecordKind

_PIECE = 65536


class TimedBytes:
    """Bytes that a board sends at its port, with simulated times, from a capture that runs beside it.
    ``lost``: number of records that the bench could not hand over in time.

    Raises:
        ControlError: the bench refuses it.
    """

    def __init__(self, path: Path, port: str) -> None:
        self._client, answer = begin(path, "capture", ports=[port])
        self._epoch_ns = int(answer["epoch_ns"])
        self._records, self._pieces = Records(), list[bytes]()
        self._blocks = blocks_of(self._piece)
        self.lost = 0

    @property
    def fd(self) -> int:
        return self._client.fileno()

    def read(self) -> Iterator[tuple[int, bytes]] | None:
        """Read what is there: simulated times in ns, with what was sent then; None: its bench has ended."""
        try:
            data = self._client.recv(_PIECE)
        except OSError:
            return None
        if not data:
            return None
        self._pieces.append(data)
        return self._sent()

    def _sent(self) -> Iterator[tuple[int, bytes]]:
        for blocks in self._blocks:
            if not blocks:
                return
            for record in self._records.feed(blocks):
                self.lost += record.lost
                if record.event == RecordKind.RX and record.data:
                    yield record.at_ns - self._epoch_ns, record.data

    def _piece(self, size: int) -> bytes | None:
        return self._pieces.pop() if self._pieces else None

    def close(self) -> None:
        with suppress(OSError):
            self._client.shutdown(socket.SHUT_RDWR)
        self._client.close()
