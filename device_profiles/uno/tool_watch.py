"""Watch for a tool that uploads while hil's own sketch runs, which the opening of the port does not reset."""

GET_SYNC = b"0 "
"""First bytes of a tool, which it sends until it is answered."""


class ToolWatch:
    """Sieve of what clients send. Only the first bytes after the opening of the port can be a tool's."""

    def __init__(self) -> None:
        self._is_first = False
        self._held = b""

    def open(self) -> None:
        """Note that a client has opened the port."""
        self._is_first, self._held = True, b""

    def sift(self, data: bytes) -> tuple[bytes, bytes]:
        """Part data into what is typed at the sketch, and what a tool has sent; one of them is empty. What
        may become either is held back."""
        if not self._is_first:
            return data, b""
        self._held += data
        if len(self._held) < len(GET_SYNC) and GET_SYNC.startswith(self._held):
            return b"", b""
        data, self._is_first = self._held, False
        return (b"", data) if data.startswith(GET_SYNC) else (data, b"")
