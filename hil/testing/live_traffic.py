"""Traffic of a bench that is served: as a capture in a file, and as records for tests."""

import contextlib
import socket
import threading
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import BinaryIO

from hil.net.control_client import begin
from hil.testing.live_desk import ANSWER_S, LiveDesk, LiveError
from hil.wire.pcapng import Record, header, header_length, read, whole_blocks

_PIECE = 1 << 16
LATE_S = 0.05
"""Maximum time after which what has passed is here, on a computer that is not busy: the daemon sends it in
batches of 20 ms."""


class LiveTraffic:
    """Records of ports, taps and wires from now on, with simulated times. ``names``: of at least one;
    ``file``: gets the capture as it comes."""

    def __init__(self, desk: LiveDesk, names: Sequence[str], file: BinaryIO | None = None) -> None:
        self._file = file
        self.records: list[Record] = []
        """Records so far."""
        self._head, self._rest = b"", b""
        self._client, answer = begin(desk.control, "capture", timeout_s=ANSWER_S, ports=[*names])
        self._epoch_ns: int = answer["epoch_ns"]
        self._thread = threading.Thread(target=self._copy, name="hil capture", daemon=True)
        self._thread.start()

    def of(self, name: str, since: int, kind: int) -> tuple[list[Record], int]:
        """Records of one kind (``RecordKind``; 0: frames) and one source, from a number of records on; and
        the number now.

        Raises:
            LiveError: some were lost, because this computer is too slow.
        """
        time.sleep(LATE_S)
        fresh = self.records[since:]
        for each in fresh:
            if each.lost:
                raise LiveError(f"{each.interface}: {each.comment}")
        return [each for each in fresh if each.interface == name and each.event == kind], since + len(fresh)

    def close(self) -> None:
        """End it when all that has passed is here."""
        with contextlib.suppress(OSError):
            self._client.shutdown(socket.SHUT_WR)
        self._thread.join(ANSWER_S)
        self._client.close()

    def _copy(self) -> None:
        with contextlib.suppress(OSError):
            while piece := self._client.recv(_PIECE):
                if self._file:
                    self._file.write(piece)
                self._note(piece)

    def _note(self, piece: bytes) -> None:
        self._rest += piece
        whole = whole_blocks(self._rest)
        blocks, self._rest = self._rest[:whole], self._rest[whole:]
        if not self._head and blocks:
            self._head = blocks[: header_length(blocks)]
            blocks = blocks[len(self._head) :]
        if blocks:
            for each in read(self._head + blocks):
                self.records.append(replace(each, at_ns=each.at_ns - self._epoch_ns))


class LiveCapture:
    """Capture of all ports and lines that a bench has now, for a ``with`` block, as pcapng."""

    def __init__(self, desk: LiveDesk, file: Path) -> None:
        self._desk, self._path = desk, file

    def __enter__(self) -> LiveTraffic | None:
        names = sources(self._desk)
        self._file = self._path.open("wb", buffering=0)
        self._traffic = LiveTraffic(self._desk, names, self._file) if names else None
        if not names:
            self._file.write(header("hil", []))
        return self._traffic

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._traffic:
            self._traffic.close()
        self._file.close()


def sources(desk: LiveDesk) -> list[str]:
    """Names of all lines of a bench, and of its ports that are on none."""
    listed = desk.ask("status")
    lines = [row.get("segment") or row["bus"] for row in [*listed["segments"], *listed["buses"]]]
    on_lines = {tap["tap"] for tap in listed["taps"]}
    places = [
        name for row in listed["devices"] for name in (row["device"] if row["address"] else "", *row["ports"])
    ]
    return [*lines, *(name for name in places if name and name not in on_lines)]
