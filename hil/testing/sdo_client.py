"""An SDO client for tests: expedited and segmented transfers, a frame there and a frame back.

Source: CiA 301 version 4.2.0, 7.2.4.3.
"""

from collections.abc import Callable

_ABORT = 0x80
_EXPEDITED_BYTES = 4
_SEGMENT_BYTES = 7


class SdoAborted(Exception):
    """Abort of a transfer by the node; ``code`` says why."""

    def __init__(self, index: int, subindex: int, code: int) -> None:
        self.code = code
        super().__init__(f"{index:04X}h:{subindex:02X}: aborted, {code:#010x}")


class SdoClient:
    """Client of one node. ``exchange`` sends eight bytes and answers the eight that come."""

    def __init__(self, exchange: Callable[[bytes], bytes]) -> None:
        self._exchange = exchange

    def upload(self, index: int, subindex: int = 0) -> bytes:
        """Read an object. Raises SdoAborted."""
        answer = self._ask(index, subindex, bytes((0x40,)) + _at(index, subindex) + bytes(4))
        if answer[0] & 2:
            size = _EXPEDITED_BYTES - (answer[0] >> 2 & 3) if answer[0] & 1 else _EXPEDITED_BYTES
            return answer[4 : 4 + size]
        data, toggle = b"", 0
        while True:
            answer = self._ask(index, subindex, bytes((0x60 | toggle, *bytes(7))))
            data += answer[1 : 1 + _SEGMENT_BYTES - (answer[0] >> 1 & 7)]
            toggle ^= 0x10
            if answer[0] & 1:
                return data

    def download(self, index: int, subindex: int, data: bytes) -> None:
        """Write an object. Raises SdoAborted."""
        if 0 < len(data) <= _EXPEDITED_BYTES:
            command = 0x23 | _EXPEDITED_BYTES - len(data) << 2
            self._ask(index, subindex, bytes((command,)) + _at(index, subindex) + data.ljust(4, b"\0"))
            return
        size = len(data).to_bytes(4, "little")
        self._ask(index, subindex, b"\x21" + _at(index, subindex) + size)
        toggle = 0
        for begin in range(0, max(len(data), 1), _SEGMENT_BYTES):
            piece = data[begin : begin + _SEGMENT_BYTES]
            is_last = begin + _SEGMENT_BYTES >= len(data)
            command = toggle | _SEGMENT_BYTES - len(piece) << 1 | is_last
            self._ask(index, subindex, bytes((command,)) + piece.ljust(_SEGMENT_BYTES, b"\0"))
            toggle ^= 0x10

    def _ask(self, index: int, subindex: int, request: bytes) -> bytes:
        answer = self._exchange(request)
        if answer[0] == _ABORT:
            raise SdoAborted(index, subindex, int.from_bytes(answer[4:8], "little"))
        return answer


def _at(index: int, subindex: int) -> bytes:
    return index.to_bytes(2, "little") + bytes((subindex,))
