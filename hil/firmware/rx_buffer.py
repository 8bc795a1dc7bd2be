"""The receive side of a board's serial interface, with the Arduino core's held byte."""


class RxBuffer:
    """Received bytes that the sketch has not read: at most ``capacity``, and the one held by ``peek``.

    ``peek`` takes its byte out of the buffer, as the SAMD core's USB serial does up to 1.6.21: the
    byte is neither counted by ``available`` nor does it take room.
    """

    def __init__(self, capacity: int) -> None:
        self._capacity = capacity
        self.unread = bytearray()
        """Bytes in the buffer, the held one not among them; to be looked at only."""
        self._held = -1

    def feed(self, data: bytes, *, at_once: bool = False) -> int:
        """Take bytes from the line; answers how many found room. ``at_once``: all do, read as they come."""
        taken = data if at_once else data[: self.room()]
        self.unread.extend(taken)
        return len(taken)

    def room(self) -> int:
        """Number of bytes that ``feed`` would take now."""
        return self._capacity - len(self.unread)

    def available(self) -> int:
        """Unread bytes in the buffer, the held one not counted."""
        return len(self.unread)

    def read_all(self) -> bytes:
        data = bytes(self.unread)
        self.unread.clear()
        return data

    def read(self) -> int:
        """Take the next byte, the held one first; -1 if there is none."""
        byte = self.peek()
        self._held = -1
        return byte

    def peek(self) -> int:
        """Answer the next byte and hold it until ``read``; -1 if there is none."""
        if self._held < 0 and self.unread:
            self._held = self.unread[0]
            del self.unread[:1]
        return self._held
