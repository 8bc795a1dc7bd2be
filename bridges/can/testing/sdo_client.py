"""An SDO client for tests: expedited and segmented transfers, a frame there and a frame back.

Source: CiA 301 version 4.2.0, 7.2.4.3.
"""

from collections.abc import Callable

from bridges.can.canopen import sdo_frames
from bridges.can.canopen.sdo_frames import ABORT_BYTE, EXPEDITED_BYTES, SEGMENT_BYTES, SdoRequest


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
        answer = self._ask(index, subindex, sdo_frames.begin(SdoRequest.UPLOAD, index, subindex))
        if sdo_frames.is_expedited(answer):
            return sdo_frames.expedited(answer)
        data, toggle, is_last = b"", 0, False
        while not is_last:
            request = sdo_frames.segment_answer(SdoRequest.UPLOAD_SEGMENT, toggle)
            answer = self._ask(index, subindex, request)
            data += sdo_frames.part_of(answer)
            is_last = sdo_frames.is_last(answer)
            toggle ^= sdo_frames.TOGGLE
        return data

    def download(self, index: int, subindex: int, data: bytes) -> None:
        """Write an object. Raises SdoAborted."""
        if 0 < len(data) <= EXPEDITED_BYTES:
            self._ask(index, subindex, sdo_frames.begin(SdoRequest.DOWNLOAD, index, subindex, data))
            return
        begun = sdo_frames.begin_segments(SdoRequest.DOWNLOAD, index, subindex, len(data))
        self._ask(index, subindex, begun)
        toggle = 0
        for begin in range(0, max(len(data), 1), SEGMENT_BYTES):
            part = data[begin : begin + SEGMENT_BYTES]
            is_last = begin + SEGMENT_BYTES >= len(data)
            self._ask(index, subindex, sdo_frames.segment(toggle, part, is_last=is_last))
            toggle ^= sdo_frames.TOGGLE

    def _ask(self, index: int, subindex: int, request: bytes) -> bytes:
        answer = self._exchange(request)
        if answer[0] == ABORT_BYTE:
            raise SdoAborted(index, subindex, sdo_frames.abort_code(answer))
        return answer
