"""Recorder of a live bench's traffic in a file."""

import contextlib
import socket
import threading
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType

from hil.net.control_client import ask, begin
from hil.wire.pcapng import CaptureError, Record, RecordKind, read

_PIECE = 1 << 16
_APART_NS = 20_000_000
"""Bytes that come so long after others are a line of their own."""


def traffic_at_ports(data: bytes) -> Iterator[str]:
    """Texts of what has passed at ports: seconds since the first record, port, direction, bytes."""
    held: list[Record] = []
    first_ns: int | None = None
    with contextlib.suppress(CaptureError):  # the last record may be on its way
        for each in read(data):
            if each.line.is_can or each.line.framing:
                continue
            first_ns = each.at_ns if first_ns is None else first_ns
            if held and not _belongs(held[-1], each):
                yield _burst(held, first_ns)
                held = []
            held.append(each)
    if held and first_ns is not None:
        yield _burst(held, first_ns)


def _belongs(last: Record, each: Record) -> bool:
    """True if a record goes on with the bytes of the one before."""
    same_way = (last.interface, last.event) == (each.interface, each.event)
    return same_way and each.at_ns - last.at_ns <= _APART_NS


def _burst(records: list[Record], first_ns: int) -> str:
    arrow = "<-" if records[0].event == RecordKind.TX else "->"
    data = b"".join(each.data for each in records)
    return f"{(records[0].at_ns - first_ns) / 1e9:9.3f}  {records[0].interface} {arrow} {data!r}"


class LiveCapture:
    """Capture of all ports and lines that a bench has now, for a ``with`` block, as pcapng."""

    def __init__(self, control: Path, file: Path) -> None:
        self._control = control
        self._path = file

    def __enter__(self) -> "LiveCapture":
        self._client: socket.socket | None = None
        listed = ask(self._control, "status")
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
            self._client, _ = begin(self._control, "capture", ports=names)
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
