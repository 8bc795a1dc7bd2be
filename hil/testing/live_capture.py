"""Recorder of a live bench's traffic in a file."""

import contextlib
import socket
import threading
from pathlib import Path
from types import TracebackType

from hil.net.control_client import ask, begin

ANSWER_S = 60.0
"""Maximum time for an answer: of twenty benches that start at once on two CPUs each waits for its turns."""
_PIECE = 1 << 16


class LiveCapture:
    """Capture of all ports and lines that a bench has now, for a ``with`` block, as pcapng."""

    def __init__(self, control: Path, file: Path) -> None:
        self._control = control
        self._path = file

    def __enter__(self) -> "LiveCapture":
        self._client: socket.socket | None = None
        listed = ask(self._control, "status", timeout_s=ANSWER_S)
        rows = [*listed["segments"], *listed["buses"]]
        lines = [row.get("segment") or row["bus"] for row in rows]
        on_lines = {tap["tap"] for tap in listed["taps"]}
        places = [
            name
            for row in listed["devices"]
            for name in (row["device"] if row["address"] else "", *row["ports"])
        ]
        names = [*lines, *(name for name in places if name and name not in on_lines)]
        if names:
            self._client, _ = begin(self._control, "capture", timeout_s=ANSWER_S, ports=names)
            self._file = self._path.open("wb", buffering=0)
            self._thread = threading.Thread(target=self._copy, name="hil capture", daemon=True)
            self._thread.start()
        return self

    def _copy(self) -> None:
        assert self._client is not None
        with contextlib.suppress(OSError):
            while piece := self._client.recv(_PIECE):
                self._file.write(piece)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._client is None:
            return
        with contextlib.suppress(OSError):
            self._client.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._client.close()
        self._file.close()
