"""Endpoints of a device: each answers the transfers that the host has asked it for, in their order.

Pure. ``answer`` takes what goes to the host.
"""

from collections import deque
from collections.abc import Callable

from virtual_ports.usb.urb import OK, SHORT, SHORT_NOT_OK, STALL, Submit, ret_submit

Answer = Callable[[bytes], None]
_NOBODY = -1


class Endpoint:
    """Endpoint with transfers that wait, ``pending``. While it is halted it refuses each."""

    def __init__(self, answer: Answer) -> None:
        self.pending: deque[Submit] = deque()
        self.is_halted = False
        self._answer = answer

    def submit(self, submit: Submit) -> None:
        if self.is_halted:
            self._answer(ret_submit(submit.seqnum, STALL, 0))
            return
        self.pending.append(submit)
        self.go_on()

    def unlink(self, seqnum: int) -> bool:
        """Give up a transfer without an answer. False: it is none of those that wait."""
        for index, submit in enumerate(self.pending):
            if submit.seqnum == seqnum:
                self._forget(index)
                return True
        return False

    def halt(self) -> None:
        """Refuse what waits and what comes, until ``clear``."""
        self.is_halted = True
        self.fail(STALL)

    def fail(self, status: int) -> None:
        """Answer all that waits with this status."""
        while self.pending:
            seqnum = self.pending[0].seqnum
            self._forget(0)
            if seqnum != _NOBODY:
                self._answer(ret_submit(seqnum, status, 0))

    def clear(self) -> None:
        """Go on after a halt."""
        self.is_halted = False

    def go_on(self) -> None:
        """Answer what can be answered now."""

    def _forget(self, index: int) -> None:
        del self.pending[index]


class InEndpoint(Endpoint):
    """Endpoint towards the host: a stream of bytes, ``queue``. A transfer is answered as soon as there is a
    byte for it, as by a device that sends a short packet."""

    def __init__(self, answer: Answer) -> None:
        super().__init__(answer)
        self.queue = bytearray()
        self.sent_bytes = 0
        """Number of bytes that the host got."""

    def send(self, data: bytes) -> None:
        """Send bytes; they wait for the host's transfers."""
        self.queue += data
        self.go_on()

    def go_on(self) -> None:
        queue = self.queue
        while queue and self.pending:
            submit = self.pending.popleft()
            piece = queue[: submit.length]
            del queue[: submit.length]
            self.sent_bytes += len(piece)
            is_short = submit.flags & SHORT_NOT_OK and len(piece) < submit.length
            self._answer(ret_submit(submit.seqnum, SHORT if is_short else OK, len(piece), piece))


class MessageEndpoint(Endpoint):
    """Endpoint towards the host: messages, each the answer to one transfer. The last ``most`` are kept
    for a host that does not ask for them."""

    def __init__(self, answer: Answer, most: int = 16) -> None:
        super().__init__(answer)
        self.messages: deque[bytes] = deque(maxlen=most)

    def send(self, message: bytes) -> None:
        self.messages.append(message)
        self.go_on()

    def go_on(self) -> None:
        while self.messages and self.pending:
            submit = self.pending.popleft()
            piece = self.messages.popleft()[: submit.length]
            self._answer(ret_submit(submit.seqnum, OK, len(piece), piece))


class OutEndpoint(Endpoint):
    """Endpoint from the host: a stream of bytes. A transfer is answered when its last byte is taken."""

    def __init__(self, answer: Answer) -> None:
        super().__init__(answer)
        self._taken = 0
        """Number of bytes of the first transfer that are taken."""

    @property
    def is_waiting(self) -> bool:
        """True if there is something to take."""
        return bool(self.pending)

    def insert(self, data: bytes) -> None:
        """Put bytes behind those that the host has sent; the host waits for no answer to them."""
        if not self.pending or self.pending[-1].seqnum != _NOBODY:
            self.pending.append(Submit(_NOBODY, 0, False, 0, len(data), b"", data))

    def go_on(self) -> None:
        """Answer transfers of no bytes that are the next."""
        self.drain(0)

    def drain(self, most_bytes: int) -> bytes:
        """Take bytes of the host, in their order."""
        taken = b""
        while self.pending:
            first = self.pending[0]
            piece = first.data[self._taken : self._taken + most_bytes - len(taken)]
            taken += piece
            self._taken += len(piece)
            if self._taken < first.length:
                break
            self.pending.popleft()
            self._taken = 0
            if first.seqnum != _NOBODY:
                self._answer(ret_submit(first.seqnum, OK, first.length))
        return taken

    def _forget(self, index: int) -> None:
        super()._forget(index)
        if index == 0:
            self._taken = 0
